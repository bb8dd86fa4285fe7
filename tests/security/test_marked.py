# SPDX-License-Identifier: Apache-2.0
"""A marked secret that enters anywhere while people, a model, a robot and documents meet in one run leaves nowhere.

Rule: each example draws where the secret enters; all that a run shows, speaks, publishes, writes and logs is searched.
"""

from __future__ import annotations

import io
import json
import logging
import random
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from langchain_core.messages import AIMessage

from rai_missions.agents.talk.doors import TalkLine
from rai_missions.agents.talk.hri_door import HRIDoor
from rai_missions.agents.talk.look_tools import look_tools
from rai_missions.agents.talk.model import TalkModel
from rai_missions.agents.talk.run_status import RobotWords
from rai_missions.answerers.test_models import DoubleModel, call
from rai_missions.cli.progress import Lines
from rai_missions.connectors.connector import Report
from rai_missions.connectors.hri.connector import HRIConnector
from rai_missions.connectors.hri.message import HRIMessage
from rai_missions.connectors.local import LocalConnector
from rai_missions.conversation import Settings
from rai_missions.embodiment.identity import Identity
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import ConversationPolicy, Robot, dump_profile
from rai_missions.replay.replay import replay
from rai_missions.runtime.clock import WallClock
from tests.agents.talk.scenes import Talk
from tests.rigs.runs import ROBOT
from tests.security.test_leaks import files, log_of
from tests.security.test_secrets_in_pieces import SECRETS, assert_whole
from visualize import draw_review

Json = dict[str, Any]
STRING = "std_msgs/msg/String"
SHAPED = "sk-proj-Qk3mQ9vT7wXyB2nC5dF8hJ"
"""A key of no account that a model makes up: known by its shape alone."""
ENTRIES = ("fact", "event", "goal", "sentence", "author", "message", "answer", "order", "words", "proposal",
           "parameters", "identity", "document", "call")  # fmt: skip
"""Where a secret may enter."""
LONGEST_NAME = 150
"""Characters of a name that a message carries."""
BEST = "best"
"""A word by which a person leaves an answer to the model."""


def mission() -> Mission:
    """One that asks a person, by free words too, while it moves, reports what it knows and is handed over."""
    free = {"type": "object", "properties": {"text": {"type": "string"}}, "required": ["text"]}
    return Mission.model_validate({
        "name": "errand", "initial": "going", "events": ["go", "again", "stop_now"],
        "blackboard": {
            "label": {"type": "string", "source": "robot", "optional": True},
            "note": {"type": "string", "source": "argument", "initial": "none"},
            "reply": {"type": "string", "source": "answer", "initial": ""},
        },
        "states": {
            "going": {
                "action": "move", "timeout_s": 600, "control": "agent",
                "entry": [{"say": "the label is {label}"}, {"log": "{label} {note}"}],
                "transitions": [{"on": "go", "to": "asking"}, {"on": ["succeeded", "failed"], "to": "asking"}],
            },
            "asking": {
                "decision": {
                    "question": "What is to be written?", "evidence": ["label"], "ask": ["operator"],
                    "options": {"write": {"about": "write it", "parameters": free}, "leave": {"about": "leave it"}},
                    "deadline_s": 600, "fallback": "leave",
                },
                "transitions": [{"on": "write", "to": "over", "do": [{"set": "reply", "from": "answer.text"},
                                                                     {"say": "written: {reply}"}]},
                                {"on": "leave", "to": "over"}],
            },
            "over": {"call": "horn", "transitions": [{"on": ["succeeded", "failed"], "to": "ended"}]},
            "ended": {"final": "aborted"},
        },
    })  # fmt: skip


class Guide(DoubleModel):
    """A model that speaks, looks up and proposes what it was given, one after the other."""

    deeds: list[Any]

    def bind_tools(self, tools: Any, **words: Any) -> Any:
        return self

    def reply_to(self, messages: list[Any]) -> Any:
        """Where a question is open, what it would answer; else the next of all else that it does."""
        is_asked = BEST in repr(messages[-1].content)
        fitting = [each for each in self.deeds if ("'answer'" in repr(each)) is is_asked]
        if not fitting:
            return "I do not know."
        self.deeds.remove(fitting[0])
        return fitting[0]


def deeds(secret: str, entries: frozenset[str]) -> list[Any]:
    """What the model does with a secret that it has."""
    made: list[Any] = []
    if "words" in entries:
        made += [f"You could try {secret} or {SHAPED}.", RuntimeError(f"401 {secret}")]
    if "document" in entries:
        made += [
            AIMessage("", tool_calls=[call(tool, **words)])
            for tool, words in (("who_am_i", {}), ("recall", {"question": "what is the word"}), ("status", {}))
        ]
    for name, order in (
        ("proposal", {"order": "start", "mission": "errand", "arguments": {"note": f"{secret} {SHAPED}"}}),
        ("parameters", {"order": "answer", "option": "write", "parameters": {"text": f"{SHAPED} {secret}"}}),
    ):
        if name in entries:
            made.append(AIMessage("", tool_calls=[call("propose_order", order=order)]))
    return made


class Ear:
    """A robot's other end: what it publishes for people and programs."""

    def __init__(self, connector: LocalConnector) -> None:
        self.received: list[str] = []
        self._publish = connector.publish
        connector.publish = self  # type: ignore[method-assign,assignment]

    def __call__(self, topic: str, type_name: str, message: Mapping[str, Any]) -> None:
        if topic not in ("/label", "/from_human"):
            self.received.append(repr((topic, message)))
        self._publish(topic, type_name, message)


def robot() -> Robot:
    blackboard = {"label": {"topic": "/label", "type": STRING, "field": "data"}}
    return Robot.model_validate(
        ROBOT | {"blackboard": blackboard, "topics": {"say": {"topic": "/spoken", "type": STRING}}}
    )


class Meeting:
    """People, a model, a robot and documents in one run; a secret enters by some of them.

    Args:
        secret: What is marked.
        entries: Where it enters.
        seed: The seed of all else.
        folder: For what is written.
    """

    def __init__(self, secret: str, entries: frozenset[str], seed: int, folder: Path) -> None:
        self.secret, self.entries, self.folder = secret, entries, folder
        self.rng, self.shown = random.Random(seed), io.StringIO()
        (folder / "identity").mkdir()
        (folder / "identity" / "description.md").write_text(f"I carry {self.mark('identity')} about. I am small.\n")
        (folder / "identity" / "words.md").write_text(f"# Words\n\nThe word is {self.mark('document')} today.\n")
        identity = Identity.read(folder / "identity", index=folder / "identity.index")
        made = mission()
        self.journal = Journal.create(folder / "run.journal", Header(dump(made), dump_profile(robot())))
        connector = LocalConnector()
        connector.start()
        self.ear, self.hri = Ear(connector), HRIConnector(connector)
        lines = Lines(made, self.shown, verbose=True)
        self.model = Guide(deeds=deeds(secret, entries))
        model = TalkModel(self.model, identity=identity, tools=lambda view: look_tools(identity, view))
        self.talk = Talk(
            made,
            model=model,
            settings=SETTINGS,
            clock=WallClock(),
            robot=robot(),
            connector=connector,
            journal=self.journal,
            names=RobotWords("errand boy", identity.first_sentence),
            doors=[HRIDoor(self.hri, "errand boy")],
        )
        follow = self.talk.rig.on_step
        self.talk.rig.on_step = lambda step: (follow(step), lines.step(step))

    def mark(self, entry: str) -> str:
        """The secret, where it enters here; else a word."""
        return self.secret if entry in self.entries else "something"

    def hold(self) -> None:
        """Have them all meet."""
        talk, rig, mark = self.talk, self.talk.rig, self.mark
        with talk:
            talk.screen.until(lambda line: "started" in line.text)
            rig.connector.publish("/label", STRING, {"data": f"x {mark('fact')} y"})
            rig.post("again", why=mark("event"), **{mark("event"): 1})
            for text in self.sentences():
                talk.agent.wait_answered(5.0)
                self.utter(text, author=f"Anna {mark('author')}")
            name, text = mark("author")[:LONGEST_NAME], f"what is {mark('message')}"
            name = name if name == mark("author") else ""  # a piece is no secret that could be known
            self.hri.send(HRIMessage(text, name=name, communication_id=f"m {name}"), "/from_human")
            talk.agent.wait_answered(5.0)
            rig.runner.control("operator", by=f"Anna {mark('author')}")
            rig.runner.control("agent", by=f"Anna {mark('author')}")
            talk.until(lambda: rig.move.goals)
            rig.move._report[rig.move.goals[-1]](
                Report(rig.move.goals[-1], "failed", {mark("goal"): [mark("goal")]}, mark("goal"))
            )
            talk.until(lambda: rig.runner.view.questions or talk.result)
            talk.order(f"please do whatever you think is {BEST}")
            talk.until(lambda: BEST in "".join(line.text for line in talk.screen.every))
            talk.until(lambda: any(line.way == "model" or "right?" in line.text for line in self.last_lines()))
            talk.order(self.rng.choice(["yes", "no"]))
            talk.agent.wait_answered(5.0)
            self.utter(f"write {mark('answer')}")
            talk.agent.wait_answered(5.0)
            talk.order("yes")
            talk.agent.wait_answered(5.0)
            if talk.result is None and rig.runner.view.questions:
                rig.runner.answer(rig.runner.view.questions[0].number, "leave", by="operator")
            talk.end()
            talk.agent.conclude(5.0)

    def utter(self, text: str, author: str = "Anna") -> None:
        """A sentence; one that is too long is refused, and the refusal is shown."""
        refused = self.talk.agent.receive(text, role="operator", channel="terminal", author=author)
        self.shown.write(refused)

    def last_lines(self) -> list[TalkLine]:
        """What the robot spoke since a model was asked what is best."""
        lines = self.talk.screen.every
        asked = max(index for index, line in enumerate(lines) if BEST in line.text)
        return [line for line in lines[asked:] if line.by == "robot"]

    def sentences(self) -> list[str]:
        """What is spoken, in an order that was drawn."""
        mark = self.mark
        made = [
            "what is the label?", "who are you?", f"what about {mark('sentence')} then", f"{mark('sentence')}",
            f"start errand with note {mark('order')}", "yes", "what did you do?", "what comes next?",
            "please help me on", "would you rather do the other one", "what do your documents report of the word?",
            "yes", "no",
        ]  # fmt: skip
        self.rng.shuffle(made)
        return [
            *made[: self.rng.randint(3, 9)],
            "is anything of that so",
            "yes",
            "why not that way then",
            "yes",
        ]

    def left(self) -> dict[str, bytes | str]:
        """All that came out of it."""
        self.journal.close()
        path = self.folder / "run.journal"
        assert replay(path).holds
        draw_review(mission(), self.folder / "page.html", [path])
        agent = self.talk.agent
        lines = json.dumps([line._asdict() for line in self.talk.screen.every])
        return files(self.folder) | {
            "lines": lines,
            "topics": "\n".join(self.ear.received),
            "terminal": self.shown.getvalue(),
            "result": repr(self.talk.result),
            "steps": repr(self.talk.steps),
            "history": repr(agent._dialogue.history),
            "health": repr(agent.health),
            "prompts": repr(self.model.received),
        }


GRANTED = ConversationPolicy(may={"person": ["start", "answer", "cancel"]}).granted()
SETTINGS = Settings(
    may=GRANTED, results=("label", "reply"), asked_with=("label",), questions={"what is the label": "label"}
)


Meet = Callable[[str, set[str], int], None]


@pytest.fixture
def meet(caplog: pytest.LogCaptureFixture, tmp_path_factory: pytest.TempPathFactory) -> Meet:
    """Has a secret enter at these places of a meeting with this seed, and nothing with it come out."""

    def check(secret: str, entries: set[str], seed: int) -> None:
        caplog.set_level(logging.DEBUG)
        caplog.clear()
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("STRANGERS_API_KEY", secret)
            meeting = Meeting(secret, frozenset(entries), seed, tmp_path_factory.mktemp("meeting"))
            meeting.hold()
            left = meeting.left() | {"log": log_of(caplog)}
        index = {name for name in left if name.startswith("identity")}
        assert_whole({name: each for name, each in left.items() if name not in index}, secret, SHAPED)

    return check


LAW = settings(
    deadline=None, suppress_health_check=list(HealthCheck), phases=[Phase.generate], report_multiple_bugs=False
)
DRAWN = (SECRETS, st.sets(st.sampled_from(ENTRIES), min_size=1), st.integers(0, 10**6))


@settings(LAW, max_examples=3)
@given(*DRAWN)
def test_a_secret_that_enters_anywhere_leaves_nowhere(meet: Meet, secret: str, entries: set[str], seed: int) -> None:
    meet(secret, entries, seed)


@pytest.mark.drill
@pytest.mark.timeout(3600)
@settings(LAW, max_examples=300)
@given(*DRAWN)
def test_a_secret_that_enters_anywhere_leaves_nowhere_in_many_meetings(
    meet: Meet, secret: str, entries: set[str], seed: int
) -> None:
    meet(secret, entries, seed)
