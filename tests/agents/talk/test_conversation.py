# SPDX-License-Identifier: Apache-2.0
"""A conversation about a run that works: state questions, orders, questions to the operator, models, closed doors."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from typing import Any

import pytest
from langchain_core.messages import AIMessage, BaseMessage
from langchain_core.tools import StructuredTool

from rai_missions.agents.agent import AgentHealth
from rai_missions.agents.contract import check_agent
from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.talk.doors import OnSpoken, TalkLine, TextDoor
from rai_missions.agents.talk.happenings import happenings
from rai_missions.agents.talk.hri_door import HRIDoor
from rai_missions.agents.talk.model import MOST_AT_ONCE, MOST_LOOKS, TalkModel
from rai_missions.agents.talk.orders import refusal_kind
from rai_missions.agents.talk.reception import MOST_WAITING
from rai_missions.agents.talk.run_status import RunStatus
from rai_missions.connectors.hri.connector import FROM_HUMAN, TO_HUMAN, HRIConnector
from rai_missions.connectors.hri.message import HRIMessage
from rai_missions.connectors.hri.wire import TYPE
from rai_missions.connectors.local import LocalConnector
from rai_missions.conversation import Settings, Speech, StatusView
from rai_missions.engine.chart import Chart
from rai_missions.event import Event, Role
from rai_missions.profile import ConversationPolicy
from rai_missions.runtime.clock import WallClock
from rai_missions.runtime.lifecycle import Status
from rai_missions.testing import Inbox
from tests.agents.talk.scenes import PATIENCE_S, RepliesModel, Screen, Talk, settle
from tests.rigs.runs import KEYS, Rig, asking, mission, robot

MOVING: dict[str, Any] = {
    "moving": {"about": "moves to the shed", "action": "move", "timeout_s": 600,
               "transitions": [{"on": "go", "to": "over"}, {"on": "succeeded", "to": "over"}]},
    "over": {"final": "aborted", "about": "given up"},
}  # fmt: skip
KEPT = robot(
    actions={
        "move": {"action": "/move", "type": "x/action/Move", "uses": ["base"], "keep": True},
        "turn": {"action": "/turn", "type": "x/action/Turn", "uses": ["base"]},
        "drive": {"start": "/drive", "succeeded": {"key": "there", "==": True}},
    }
)
ASKED = asking(ask=["operator"], deadline_s=600)


def talked(given: Any = None, **words: Any) -> Talk:
    return Talk(mission(given or MOVING), clock=WallClock(), **words)


def running(talk: Talk) -> None:
    talk.screen.until(lambda line: "started" in line.text)


def test_it_is_an_agent() -> None:
    check_agent(ConversationalAgent)


def test_a_state_question_is_answered_by_rule_while_the_robot_moves() -> None:
    with talked() as talk:
        running(talk)
        line = talk.ask("what are you doing?", "viewer")
        assert "moves to the shed" in line.text and line.way == "rules"


def test_a_typed_stop_pauses_and_cancels_a_kept_goal_at_once() -> None:
    with talked(robot=KEPT) as talk:
        running(talk)
        paused = threading.Event()
        talk.rig.move.cancel, cancel = lambda goal: (cancel(goal), paused.set()), talk.rig.move.cancel  # type: ignore
        took = time.monotonic()
        talk.order("stop", "person")
        assert paused.wait(5.0)
        took = time.monotonic() - took
        assert len(talk.rig.move.canceled) == 1 and took < 1.0, took  # on a busy machine; benchmarks/bench_talk.py
        talk.screen.until(lambda line: "stop" in line.text.casefold())
        assert talk.rig.runner.view.mode == "paused"


@pytest.mark.parametrize(("order", "role"), [("stop", "person"), ("pause", "operator")])
def test_a_stop_before_the_start_keeps_the_robot_where_it_is_until_it_is_resumed(order: str, role: Role) -> None:
    needed = {**KEYS, "there": {"type": "boolean", "source": "robot"}}
    with Talk(mission(MOVING, blackboard=needed), clock=WallClock()) as talk:
        talk.order(order, role)
        talk.until(lambda: talk.mode == "paused")
        talk.rig.publish("/there", data=False)
        assert "paused" in talk.ask("what are you doing?").text
        assert not talk.rig.move.goals and not any("started" in text for text in talk.screen.texts())
        talk.order("resume")
        running(talk)
        talk.until(lambda: talk.rig.move.goals)
        assert not any("not carried out" in text for text in talk.screen.texts())


@pytest.mark.parametrize("waits", [True, False])
def test_a_start_after_a_stop_before_it_begins_the_mission(waits: bool) -> None:
    with Talk(
        mission(MOVING, blackboard={**KEYS, "there": {"type": "boolean", "source": "robot"}}),
        clock=WallClock(),
        waits=waits,
    ) as talk:
        talk.order("stop", "person")
        talk.until(lambda: talk.mode == "paused")
        talk.rig.publish("/there", data=False)
        talk.order_to_confirm("start")
        talk.order("yes")
        running(talk)
        talk.until(lambda: talk.rig.move.goals)


def test_a_stop_while_it_is_canceled_is_the_e_stop() -> None:
    states = {
        **MOVING,
        "tidying": {"action": "turn", "timeout_s": 600, "transitions": [{"on": "succeeded", "to": "over"}]},
    }
    with Talk(mission(states, on_cancel="tidying", cancel_s=60), clock=WallClock()) as talk:
        running(talk)
        talk.rig.runner.cancel()
        talk.until(lambda: talk.rig.runner.view.mode == "canceling" and talk.rig.turn.goals)
        talk.order("stop")
        assert talk.end().outcome in ("aborted", "canceled")
        assert talk.rig.turn.canceled and talk.rig.runner.view.holder == "nobody"


def test_the_open_question_is_shown_and_answered_in_words_and_judged_like_any_other() -> None:
    with talked(ASKED) as talk:
        talk.screen.until(lambda line: "Which?" in line.text)
        talk.order("left", "person")
        assert talk.rig.runner.view.questions, "a person may not answer unless the profile grants it"
        talk.order("left")
        assert talk.end().outcome == "aborted"
        answered = [step for step in talk.steps if step.verdict is not None and step.verdict.accepted]
        assert [(step.event.data["by"], step.event.data["role"]) for step in answered] == [
            ("operator Anna (terminal)", "operator")
        ]


def test_what_a_run_refuses_is_of_the_kind_that_its_step_has() -> None:
    chart = Chart(mission(ASKED))
    events = {
        "not_started": Event("operator", 0.0, {"option": "left"}, "proposal", 1),
        "": Event("start", 0.0, {}, "command"),
        "mode": Event("resume", 0.0, {}, "command"),
        "stale": Event("operator", 0.0, {"option": "left"}, "proposal", 99),
        "judged": Event("operator", 0.0, {"option": "fly"}, "proposal", 1),
    }  # fmt: skip
    steps = {kind: chart.start() if event.name == "start" else chart.send(event) for kind, event in events.items()}
    assert {kind: refusal_kind(step) for kind, step in steps.items() if kind} == {kind: kind for kind in steps if kind}
    chart.send(Event("kill", 0.0, {}, "command"))
    assert refusal_kind(chart.send(events["mode"])) == "ended"


def test_what_the_profile_grants_a_person_may_do() -> None:
    settings = Settings(may=ConversationPolicy(may={"person": ["answer"]}).granted())
    with talked(ASKED, settings=settings) as talk:
        talk.screen.until(lambda line: "Which?" in line.text)
        talk.order("left", "person")
        assert talk.end().outcome == "aborted"
        (answer,) = [each for step in talk.steps for each in happenings(step, {}, {}) if each.kind == "answered"]
        assert answer.by.startswith("person "), "who answered is named, and not who was asked"


def test_an_option_that_is_to_be_confirmed_counts_with_the_yes() -> None:
    states = asking(ask=["operator"], deadline_s=600, options={"left": {"confirm": True}, "right": {}})
    with talked(states) as talk:
        talk.screen.until(lambda line: "Which?" in line.text)
        talk.order_to_confirm("left")
        assert talk.rig.runner.view.questions, "it is read back first"
        talk.order("yes")
        assert talk.end().outcome == "aborted"


def test_a_yes_that_was_typed_before_the_order_is_read_back_is_no_confirmation() -> None:
    with talked() as talk:
        running(talk)

        def hasty(line: TalkLine) -> None:
            if line.text == "cancel the mission":  # its turn has come, and the answer is not shown yet
                talk.order("yes")

        talk.agent.add_door(TextDoor("page", hasty))
        talk.order("cancel the mission")
        talk.until(lambda: sum("Is that right?" in text for text in talk.screen.texts()) == 2)
        assert talk.rig.runner.view.mode == "running"
        talk.order("yes")
        assert talk.end().outcome == "canceled"


def test_a_run_that_waits_is_started_by_an_order_with_its_arguments() -> None:
    with talked(waits=True) as talk:
        assert "ready" in talk.ask("what are you doing?").text
        talk.order_to_confirm("start with speed 2")
        assert talk.rig.runner.view.mode == "ready", "it is read back first"
        talk.order("yes")
        running(talk)
        assert talk.rig.runner.view.board["speed"].value == 2.0


def test_a_hanging_model_delays_no_state_question() -> None:
    resume = threading.Event()
    with talked(model=RepliesModel(before=resume.wait)) as talk:
        running(talk)
        talk.order("I would like a story about the moon")
        waits = []
        for _ in range(15):
            began = time.monotonic()
            talk.ask("what are you doing?")
            waits.append(time.monotonic() - began)
        resume.set()
        assert sorted(waits)[7] < 0.5 and max(waits) < 5.0, waits  # the model has 20 s; benchmarks/bench_talk.py


def test_who_interrupts_a_slow_model_has_the_last_sentence_answered() -> None:
    free, asked = threading.Semaphore(0), list[str]()

    class Slow(RepliesModel):
        def reply_to(self, messages: list[BaseMessage]) -> AIMessage:
            asked.append(str(messages[-1].content))
            free.acquire(timeout=PATIENCE_S)
            return AIMessage("Tea is grown in Asia.")

    with talked(model=Slow(), settings=Settings(late="interrupt")) as talk:
        for kind in ("green", "black", "white", "yellow", "dark", "smoked"):
            talk.order(f"what do you think of {kind} tea")
            settle(talk.agent)
        free.release(6)
        talk.screen.until(lambda line: line.way == "model")
        settle(talk.agent)
        assert [line.text for line in talk.screen.of_robot() if line.way == "model"] == ["Tea is grown in Asia."]
        assert not any(line.way == "unknown" for line in talk.screen.of_robot())
        assert len(asked) == MOST_AT_ONCE + 1, "what was interrupted before its turn is not asked"
        assert "smoked tea" in asked[-1]


@pytest.mark.parametrize("fault", [RuntimeError, SystemExit, MemoryError])
def test_a_model_that_fails_leaves_the_conversation_as_it_is(
    fault: type[BaseException], caplog: pytest.LogCaptureFixture
) -> None:
    def fail() -> None:
        raise fault

    with talked(model=RepliesModel(before=fail)) as talk:
        running(talk)
        talk.order("I would like a story about the moon")
        assert talk.screen.until(lambda line: line.way == "unknown").text.startswith("The model gave no reply.")
        assert f"the model gave no reply: the model raised {fault.__name__}" in caplog.text
        assert "moves to the shed" in talk.ask("what are you doing?").text


def test_a_models_text_is_labelled_and_its_claims_are_replaced() -> None:
    with talked(model=RepliesModel(reply="The moon is far away. I have driven all the alleys.")) as talk:
        running(talk)
        talk.order("I would like a story about the moon")
        line = talk.screen.until(lambda line: "moon" in line.text)
        assert line.way == "model"
        talk.ask("what are you doing?")
        assert not any("driven all" in text for text in talk.screen.texts())


def test_the_end_is_reported_once_and_is_in_the_journal() -> None:
    with talked() as talk:
        running(talk)
        talk.rig.post("go")
        talk.end()
        assert talk.agent.conclude(5.0)
        assert len([line for line in talk.screen.of_robot() if line.report.endswith(":end")]) == 1
        talk.until(lambda: any(row["kind"] == "spoken" for row in talk.talk()))


def test_an_end_that_no_one_could_read_is_reported_when_a_door_opens_and_marked() -> None:
    with talked() as talk:
        running(talk)
        talk.screen.is_open = False
        talk.agent.doors_changed()
        talk.rig.post("go")
        talk.end()
        assert not talk.agent.conclude(0.3)
        assert any(line.spoken == "failed" for line in talk.screen.of_robot()), "page and journal show it"
        talk.until(lambda: any(row["kind"] == "unspoken" for row in talk.talk()))
        talk.screen.is_open = True
        talk.agent.doors_changed()
        assert talk.screen.until(lambda line: line.report.endswith(":end") and not line.spoken).repeated


@pytest.mark.parametrize("stop", ["stop", "Stop!", "please stop now", "halt"])
def test_a_stop_comes_through_a_flood_at_its_door(stop: str) -> None:
    def flooded(text: str) -> str:
        """Send until one is refused: on a busy machine a hundred may take longer than they are counted for."""
        refusals = (talk.agent.receive(text, role="person", channel="topic", author="F") for _ in range(10_000))
        return next(filter(None, refusals), "")

    with talked() as talk:
        running(talk)
        assert flooded("flood") == "too many sentences at once; wait a moment"
        assert talk.agent.receive(stop, role="person", channel="topic", author="Anna") == ""
        talk.until(lambda: talk.rig.runner.view.mode == "paused")
        assert flooded("stop") == "too many sentences at once; wait a moment"


def test_a_reply_at_a_door_that_is_shut_is_shown_once_and_marked() -> None:
    page = TextDoor("page", lambda _: None, lambda: False)
    with talked(doors=[page]) as talk:
        running(talk)
        for channel in ("page", "terminal"):
            assert talk.agent.receive("what are you doing?", role="operator", channel=channel) == ""
            settle(talk.agent)
        replies = [
            (line.channel, line.spoken) for line in talk.screen.every if line.text.endswith("moves to the shed.")
        ]
        assert replies == [("page", "failed"), ("terminal", "")]


def test_a_sentence_that_is_too_long_or_empty_is_refused_with_the_reason() -> None:
    with talked() as talk:
        receive = talk.agent.receive
        assert "at most 2000 characters" in receive("a" * 10_000_000, role="operator", channel="page")
        assert "no text" in receive("  ", role="operator", channel="page")


def test_what_comes_after_the_end_of_a_conversation_is_refused_and_leaves_its_next_life_free() -> None:
    screen = Screen()
    agent = ConversationalAgent(doors=[TextDoor("terminal", screen.show)])
    agent.run()
    agent.stop()
    for number in range(MOST_WAITING + 1):
        assert agent.receive("hello", role="operator", channel=f"door {number}") == "the conversation has ended"
    agent.run()
    assert agent.receive("what are you doing?", role="operator", channel="terminal") == ""
    assert screen.until(lambda line: line.way == "rules").text == "No mission is running."
    agent.stop()


def test_orders_of_a_conversation_are_events_with_role_and_sentence() -> None:
    with talked() as talk:
        running(talk)
        talk.order("pause")
        talk.until(lambda: talk.rig.runner.view.mode == "paused" and talk.steps[-1].mode == "paused")
        commands = [step.event for step in talk.steps if step.event.kind == "command" and step.event.name == "pause"]
        assert [(each.data["by"], each.data["role"]) for each in commands] == [("operator Anna (terminal)", "operator")]
        rows = [row for row in talk.talk() if row["kind"] == "heard"]
        assert rows and rows[0]["text"] == "pause" and rows[0]["role"] == "operator"
        talk.order("resume", author="A" * 1_000_000)
        talk.until(lambda: any(step.event.name == "resume" for step in tuple(talk.steps)))
        (resume,) = [step.event for step in talk.steps if step.event.name == "resume"]
        assert resume.data["by"] == f"operator {'A' * 200} (terminal)"


def test_the_steps_of_a_list_of_orders_are_those_of_the_same_orders_one_by_one() -> None:
    def steps(*sentences: str) -> list[tuple[object, ...]]:
        with talked(waits=True) as talk:
            for sentence in sentences:
                settle(talk.agent)
                before = len(talk.screen.of_robot())
                talk.order(sentence)
                talk.screen.until(lambda line, before=before: talk.screen.of_robot().index(line) >= before)
                if "Is that right?" in talk.screen.texts()[-1]:
                    talk.order("yes")
                    talk.until(lambda: talk.steps)
                settle(talk.agent)
            assert talk.end().outcome == "canceled"
            commands = [step for step in talk.steps if step.event.kind == "command"]
            return [(step.event.name, step.mode, step.entered, step.exited) for step in commands]

    orders = ("start with speed 2", "pause", "cancel the mission")
    assert steps(", then ".join(orders)) == steps(*orders) != []


class Aloud(Screen):
    """A door that speaks for as long as it is let, and keeps how it was silenced."""

    channel, is_aloud = "voice", True

    def __init__(self) -> None:
        super().__init__()
        self.silenced: list[bool] = []
        self.health = AgentHealth("running")

    def speak(self, speech: Speech, on_end: OnSpoken) -> None:
        on_end("whole")

    def silence(self, *, is_total: bool = True) -> None:
        self.silenced.append(is_total)


def test_who_asks_for_quiet_ends_what_may_be_interrupted_and_who_stops_ends_all() -> None:
    with talked() as talk:
        door = Aloud()
        talk.agent.add_door(door)
        running(talk)
        talk.order("be quiet")
        talk.ask("what are you doing?")
        talk.ask("stop")
        talk.until(lambda: len(door.silenced) == 2)
        assert door.silenced == [False, True]


class Broken(Aloud):
    """A door of which nothing works."""

    def __init__(self, what: str) -> None:
        self.what = what
        super().__init__()

    def __getattribute__(self, name: str) -> Any:
        if name == object.__getattribute__(self, "what"):
            raise RuntimeError("the door is off its hinges")
        return super().__getattribute__(name)


@pytest.mark.parametrize("what", ["silence", "speak", "show", "is_open"])
def test_a_door_that_raises_harms_no_other(what: str) -> None:
    with talked() as talk:
        talk.agent.add_door(Broken(what))
        running(talk)
        assert talk.ask("stop").text.startswith("Stop.")
        talk.until(lambda: talk.rig.runner.view.mode == "paused")
        talk.rig.runner.kill()
        talk.end()
        assert talk.agent.conclude(0.3) is (what != "speak"), (
            "what was to be spoken aloud, and was not, is not reported"
        )
        assert any(line.report.endswith(":end") for line in talk.screen.of_robot())


def test_its_health_names_the_door_that_is_dead_and_those_that_are_open() -> None:
    door = Aloud()
    agent = ConversationalAgent(doors=[door])
    assert agent.health.state == "ready"
    agent.run()
    assert (agent.health.why, agent.health.values["doors open"]) == ("", "voice")
    door.health, door.is_open = AgentHealth("died", "no voice 'flit'"), False
    assert (agent.health.why, agent.health.values["doors open"]) == ("the door 'voice': no voice 'flit'", "none")
    agent.add_door(Broken("health"))
    assert (
        agent.health.why == "the door 'voice': it cannot report its health (RuntimeError: the door is off its hinges)"
    )
    assert agent.health.state == "running", "a door that raises ends no conversation"
    agent.stop()
    assert agent.health.state == "stopped"


def test_a_person_on_the_topic_asks_and_stops_and_orders_nothing_else() -> None:
    connector, received = LocalConnector(), Inbox[HRIMessage]()
    connector.start()
    hri, person = HRIConnector(connector), HRIConnector(connector)
    person.listen(TO_HUMAN, received)
    door = HRIDoor(hri, "rob")
    with talked(doors=[door]) as talk:  # from the beginning, as of a profile: the start is reported to the doors there
        door.open(talk.agent.receive)
        running(talk)
        wanted = {
            "what are you doing?": "moves to the shed", "cancel the mission": "may not cancel the mission",
            "operator: yes": "", "stop": "Stop.",
        }  # fmt: skip
        for number, (text, reply) in enumerate(wanted.items()):
            person.send(HRIMessage(text, name="operator Anna (page)", communication_id=str(number)), FROM_HUMAN)
            received.wait(lambda all_, reply=reply: any(reply in each.text for each in all_), f"'{text}': '{reply}'")
        talk.until(lambda: talk.rig.runner.view.mode == "paused")
        talk.until(lambda: any("request" in step.event.data for step in talk.steps))  # a step is shown after its effect
        events = [step.event.data for step in talk.steps if "request" in step.event.data]
        assert [event["role"] for event in events] == ["person"], "the name grants nothing"
        communications = {each.text: each.communication_id for each in received.all}
        assert any(text.startswith("Stop.") and not number for text, number in communications.items())
        assert any(number.endswith(":start") for number in communications.values()), "a report is known by its identity"
    hri.close()
    person.close()
    connector.stop()


def test_a_person_on_the_topic_receives_why_a_message_is_not_taken() -> None:
    connector, received, at = LocalConnector(), Inbox[HRIMessage](), 0.0
    connector.start()
    hri, person = HRIConnector(connector, now=lambda: at), HRIConnector(connector)
    person.listen(TO_HUMAN, received)
    door = HRIDoor(hri, "rob")
    door.open(lambda text, **_: "" if len(text) < 9 else "it is too long")
    wanted = {
        "it is too long": HRIMessage("far too long", name="Ann"),
        "part 3 has no communication_id": HRIMessage("pause", name="Ann", seq_no=3),
    }
    for why, message in wanted.items():
        at += 1.0
        for _ in range(50):  # a flood has one reply a second
            person.send(message, FROM_HUMAN)
        assert f"Ann: your message is not taken: {why}" in received.all[-1].text
    at += 1.0
    connector.publish(FROM_HUMAN, TYPE, {"text": "pause", "seq_no": "x"})
    assert "Your message is not taken: /from_human: seq_no" in received.all[-1].text
    parts = [HRIMessage(text, communication_id="7", seq_no=no, seq_end=no == 1) for no, text in enumerate("ab")]
    for part in (*parts, parts[1]):  # what comes twice is taken once
        at += 1.0
        person.send(part, FROM_HUMAN)
    assert len(received.all) == 3 and all(each.author == "ai" and each.name == "rob" for each in received.all)
    hri.close()
    person.close()
    connector.stop()


def test_an_order_that_was_sent_long_ago_does_not_count_and_a_stop_does() -> None:
    connector, received = LocalConnector(), Inbox[HRIMessage]()
    connector.start()
    hri = HRIConnector(connector)
    hri.listen(TO_HUMAN, received)
    door = HRIDoor(hri, "rob")
    settings = Settings(may=ConversationPolicy(may={"person": ["pause", "resume", "cancel"]}).granted())
    with talked(doors=[door], settings=settings) as talk:
        door.open(talk.agent.receive)
        running(talk)

        def send(text: str, reply: str, *, ago_s: float) -> str:
            """The stamp is a number or a time as ROS has it, in the header or next to the text."""
            at, before = time.time() - ago_s, len(received.all)
            stamp: dict[str, Any] = {"stamp": at} if ago_s > 1e6 else {"header": {"stamp": {"sec": int(at)}}}
            connector.publish(FROM_HUMAN, TYPE, {"text": text, "seq_end": True, **stamp})
            return received.wait(lambda all_: any(reply in each.text for each in all_[before:]), text)[-1].text

        for ago_s, age in ((600.0, "10 min"), (11.5, "s"), (1e300, "min")):
            for order in ("pause", "cancel the mission", "could you please pause now"):
                refusal = send(order, "Please give it again", ago_s=ago_s)
                assert f"{age} ago" in refusal and "an order counts for 10 s" in refusal and len(refusal) < 200
        assert not talk.rig.move.canceled and talk.rig.runner.view.mode == "running"
        send("what are you doing?", "moves to the shed", ago_s=600.0)
        send("cancel the mission", "Is that right?", ago_s=0.0)
        send("yes", "Is that right?", ago_s=8.0)  # of before it was asked
        assert talk.rig.runner.view.mode == "running"
        send("pause", "pause", ago_s=-600.0)  # its sender's clock is ahead: it came now
        talk.until(lambda: talk.rig.runner.view.mode == "paused")
        settle(talk.agent)  # the conversation learns of it a moment later
        send("resume", "resume", ago_s=0.0)
        talk.until(lambda: talk.rig.runner.view.mode == "running")
        send("stop", "Stop.", ago_s=600.0)
        talk.until(lambda: talk.rig.runner.view.mode == "paused")
    assert [row["by"] for row in talk.talk() if row.get("by") == "too_old"] == ["too_old"] * 9
    hri.close()
    connector.stop()


def test_a_person_addresses_one_robot_of_two_by_where_its_topics_are() -> None:
    connector, received = LocalConnector(), {name: Inbox[HRIMessage]() for name in ("/alpha", "/beta")}
    connector.start()
    person, taken = HRIConnector(connector), list[tuple[str, str]]()
    doors = {name: HRIDoor(HRIConnector(connector), name[1:], below=name, is_stop="stop".__eq__) for name in received}
    for name, door in doors.items():
        person.listen(f"{name}{TO_HUMAN}", received[name])
        door.open(lambda text, name=name, **_: taken.append((name, text)) or "")  # type: ignore[misc]
    for text in ("stop", "what are you doing?"):
        person.send(HRIMessage(text), f"/beta{FROM_HUMAN}")
    for text in ("what are you doing?", "stop"):
        person.send(HRIMessage(text), FROM_HUMAN)
    doors["/alpha"].speak(Speech("1", "I am waiting."), lambda _: None)
    received["/alpha"].wait(lambda all_: [each.text for each in all_] == ["I am waiting."], "alpha's reply")
    for door in doors.values():
        door.close()
    person.close()
    connector.stop()
    assert sorted(taken) == [("/alpha", "stop"), ("/beta", "stop"), ("/beta", "stop"), ("/beta", "what are you doing?")]
    assert received["/beta"].all == []


def test_a_model_that_asks_for_a_flood_of_tools_looks_at_nothing_and_the_person_is_answered() -> None:
    looked: list[str] = []

    def look() -> str:
        """Looks."""
        looked.append("looked")
        return "a wall"

    tool = StructuredTool.from_function(look, name="look", metadata={"read_only": True})
    flood = tuple({"name": "look", "args": {}, "id": str(number)} for number in range(MOST_LOOKS + 1))
    model = TalkModel(RepliesModel(calls=flood), tools=lambda _view: (tool,))
    with talked(model=model) as talk:
        talk.order("what is behind the wall?")
        assert talk.screen.until(lambda line: line.way == "unknown").text == "The model gave no reply. I do not know."
    assert looked == []


def nested(depth: int) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for _ in range(depth):
        made = {"order": made}
    return made


@pytest.mark.parametrize(
    "given",
    [
        {"reply": "Apples ripen in autumn. " * 50_000},
        {"reply": "", "calls": ({"name": "propose_order", "args": nested(5_000), "id": "1"},)},
        {"reply": "", "calls": ({"name": "answer", "args": nested(5_000), "id": "1"},)},
    ],
)
def test_a_reply_that_is_too_long_or_too_deep_is_no_reply(given: Mapping[str, Any]) -> None:
    with talked(model=RepliesModel(**given)) as talk:
        talk.order("I would like a story about the moon")
        assert "That is no order" in talk.screen.until(lambda line: line.way != "rules").text
        assert not any("no reply in time" in str(row) for row in talk.talk())


def region(name: str, **options: Any) -> dict[str, Any]:
    asked = {"question": f"{name}?", "options": options, "ask": ["operator"], "deadline_s": 600, "fallback": "off"}
    states = {
        f"{name}_asks": {"decision": asked, "transitions": [{"on": list(options), "to": f"{name}_over"}]},
        f"{name}_over": {"final": "succeeded"},
    }
    return {"initial": f"{name}_asks", "states": states}


def test_the_state_that_acts_is_named_where_a_region_waits() -> None:
    moving, over = MOVING["moving"], MOVING["over"]
    work = {"about": "it works", "initial": "moving", "states": {"moving": {**moving, "about": ""}}}
    power = {"initial": "fine", "states": {"fine": {"about": "the battery is full"}}}
    with talked({"both": {"parallel": {"work": work, "power": power}}, "over": over}) as talk:
        running(talk)
        assert "in the state 'moving': it works." in talk.ask("what are you doing?").text
        assert "It has been in the state 'moving' for" in talk.ask("how long have you been doing this?").text


def test_a_mode_is_seen_with_what_led_to_it_in_whatever_order_a_run_reports_them() -> None:
    views = list[StatusView]()

    def changed(status: Status) -> None:
        seen.status(status)
        views.append(seen.view())

    rig = Rig(mission(MOVING), on_step=lambda step: seen.step(step), on_status=changed)
    seen = RunStatus(rig.runner)
    rig.post("go")
    rig.run()
    views.append(seen.view())
    assert [view.mode for view in views][-1] == "aborted" and len(views) > 2
    assert all(view.began is not None and view.since is not None for view in views if view.mode == "running")


def test_two_regions_ask_at_the_same_time_and_each_is_answered_by_its_own_option() -> None:
    regions = {"left": region("left", red={}, off={}), "right": region("right", blue={}, off={})}
    both = {"parallel": regions, "transitions": [{"on": "succeeded", "to": "done"}]}
    with talked({"both": both, "done": {"final": "aborted"}}) as talk:
        reported = [talk.screen.until(lambda line, name=name: name in line.text) for name in ("left?", "right?")]  # type: ignore[misc]
        assert [line.report.rpartition(":")[2] for line in reported] == ["1", "2"]
        assert "left?" in (asked := talk.ask("what did you ask?").text) and "right?" in asked
        assert talk.ask("off").text.startswith("You want: answer 'off' to: left? Is that right?")
        assert talk.ask("blue").text == "Answer taken: blue."
        talk.order("red")
        talk.end()
    answers = [step.event for step in talk.steps if step.event.kind == "proposal"]
    assert [(event.number, event.data["option"]) for event in answers] == [(2, "blue"), (1, "red")]


def test_the_end_has_been_reported_before_all_earlier_sentences_are_answered() -> None:
    """However many sentences wait: on a slow machine they would keep an end from the persons it is for."""
    with talked() as talk:
        running(talk)
        begin, resumed = threading.Event(), threading.Event()
        talk.agent.reception.after_all(begin.wait)
        for number in range(20):
            talk.order(f"how far are you, {number}?")
            if number == 9:
                talk.agent.reception.after_all(resumed.wait)
        talk.rig.post("go")
        talk.end()
        begin.set()
        is_reported = talk.agent.conclude(5.0)
        resumed.set()
        assert is_reported
        talk.until(lambda: sum(line.by == "operator" for line in tuple(talk.screen.lines.values())) == 20)
