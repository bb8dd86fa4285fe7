# SPDX-License-Identifier: Apache-2.0
"""From files to a run: what is wired, what is refused, and the Agent around it."""

from __future__ import annotations

import json
import logging
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.mission import MissionAgent, RunConfig, prepare, prepare_next, run
from rai_missions.agents.runner import AgentRunner
from rai_missions.agents.talk.doors import TextDoor
from rai_missions.engine import Chart
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.event import Event
from rai_missions.journal import Journal, read, verify
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.clock import WallClock
from rai_missions.testing import ScriptedModel, check_agent

WAITING: dict[str, Any] = {
    "name": "waiting",
    "initial": "idle",
    "events": ["go"],
    "states": {"idle": {"transitions": [{"on": "go", "to": "over"}]}, "over": {"final": "aborted"}},
}
ASKING: dict[str, Any] = {
    "name": "asking",
    "initial": "asks",
    "blackboard": {"low": {"type": "boolean", "source": "mission", "initial": True}},
    "states": {
        "asks": {
            "decision": {
                "question": "Which?",
                "options": {"left": {"when": {"key": "low", "==": True}}, "right": {}},
                "ask": ["agent", "rules"],
                "deadline_s": 20,
                "fallback": "right",
            },
            "transitions": [{"on": "left", "to": "over"}, {"on": "right", "to": "lost"}],
        },
        "over": {"final": "aborted"},
        "lost": {"final": "failed"},
    },
}


def robot(**words: Any) -> Robot:
    return Robot.model_validate({"name": "tried", "events": {"go": {"posted": True}}, **words})


@pytest.mark.parametrize("given", [3, b"robot.json", {"name": "tried"}], ids=repr)
def test_what_is_no_robot_is_refused_as_such(given: Any) -> None:
    with pytest.raises(UsageError, match=r"a run takes a Robot, .* not .*; Robot.model_validate\(…\) makes"):
        run(Mission.model_validate(WAITING), robot=given)


@pytest.mark.parametrize("given", ["mission.json", Path("mission.json"), {"mission": "mission.json"}, None])
def test_what_is_no_configuration_of_a_run_is_refused(given: Any) -> None:
    for prepared in (prepare, MissionAgent):
        with pytest.raises(UsageError, match=r"a run is prepared of a RunConfig, not .*; write RunConfig\("):
            prepared(given)


@pytest.mark.parametrize("speed", [0, -1, float("nan"), "fast"])
def test_what_is_no_speed_is_refused_before_anything_is_opened(speed: Any) -> None:
    with pytest.raises(UsageError, match="is no speed; give a positive number such as 5, or infinity"):
        run("none.json", speed=speed)


def test_an_option_that_no_run_has_is_refused_with_the_nearest() -> None:
    over = Mission.model_validate({"name": "m", "initial": "over", "states": {"over": {"final": "aborted"}}})
    for word, sentence in (
        ("modle", r"^run takes no 'modle'; did you mean 'model'\?$"),
        ("guards", "^run takes no 'guards'; there is: "),
    ):
        with pytest.raises(UsageError, match=sentence):
            run(over, **{word: None})


def test_a_run_from_files_writes_a_journal_that_verifies(tmp_path: Path) -> None:
    (tmp_path / "mission.json").write_text(json.dumps({"format": 1, **ASKING}))
    rules = {"asks": [{"when": {"key": "low", "==": True}, "answer": "left"}]}
    (tmp_path / "robot.json").write_text(json.dumps({"format": 1, "name": "tried", "rules": rules}))
    path = tmp_path / "deep" / "run.journal"
    result = run(tmp_path / "mission.json", tmp_path / "robot.json", journal=path)
    assert (result.outcome, result.decisions, result.journal) == ("aborted", 1, str(path))
    verify(path)


def test_a_model_is_asked_first_and_rules_after_it() -> None:
    mission = Mission.model_validate(ASKING)
    assert run(mission, robot(), model=ScriptedModel(['{"option": "right"}'])).outcome == "failed"
    assert run(mission, robot(rules={"asks": [{"answer": "left"}]})).outcome == "aborted"
    assert run(mission, robot()).outcome == "failed", "without an answerer, the fallback"


def test_a_mission_with_a_fault_is_refused_before_anything_moves(tmp_path: Path) -> None:
    bad = {**WAITING, "states": {**WAITING["states"], "lonely": {"final": "failed"}}}
    with pytest.raises(DefinitionError, match="lonely"):
        prepare(RunConfig(Mission.model_validate(bad), robot(), journal=tmp_path / "run.journal"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("named", "why"),
    [
        ({"near": lambda board: True}, "'near' takes (board), and is called with (board, place=…)"),
        ({"far": lambda board, place: True}, "no registered predicate 'near'; there is: far"),
    ],
)
def test_a_predicate_that_does_not_fit_its_guard_is_refused_before_anything_moves(
    named: dict[str, Any], why: str
) -> None:
    near = {"when": {"named": "near", "with": {"place": "dock"}}, "to": "end"}
    states = {"going": {"call": "go", "transitions": [{"on": ["succeeded", "failed"], "to": "end"}, near]}}
    mission = {"format": 1, "name": "m", "initial": "going", "states": states | {"end": {"final": "aborted"}}}
    with pytest.raises(DefinitionError) as caught:
        run(Mission.model_validate(mission), named=named)
    assert why in str(caught.value)
    assert [fault.place for fault in caught.value.faults] == ["/states/going/transitions/1/when/named"]


def test_arguments_that_are_missing_are_reported_in_the_order_of_the_mission() -> None:
    names = [f"n{number}" for number in (3, 1, 4, 5, 9, 2, 6, 8, 7, 0)]
    keys = {name: {"type": "number", "source": "argument"} for name in names}
    mission = {"format": 1, "name": "m", "blackboard": keys, "initial": "end", "states": {"end": {"final": "aborted"}}}
    with pytest.raises(DefinitionError) as caught:
        run(Mission.model_validate(mission))
    assert [fault.place for fault in caught.value.faults] == [f"/blackboard/{name}" for name in names]


def test_a_run_without_the_robot_that_its_mission_needs_is_refused_at_once(tmp_path: Path) -> None:
    keys = {"low": {"type": "boolean", "source": "robot"}, "high": {"type": "boolean", "source": "robot"}}
    needy = Mission.model_validate({**ASKING, "blackboard": {**keys, "seen": {**keys["low"], "optional": True}}})
    with pytest.raises(UsageError, match="the mission must receive low, high from a robot, and none was given"):
        run(needy, journal=tmp_path / "run.journal")
    assert list(tmp_path.iterdir()) == []


def test_a_connector_that_there_is_not_is_named() -> None:
    with pytest.raises(UsageError, match=r"no connector of kind 'locale'; did you mean 'local'\?"):
        prepare(RunConfig(Mission.model_validate(WAITING), robot(connector={"kind": "locale"})))


def test_a_journal_is_never_written_over(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    path.write_text("mine")
    with pytest.raises(DefinitionError, match="no journal"):
        prepare(RunConfig(Mission.model_validate(WAITING), robot(), journal=path))
    assert path.read_text() == "mine"


def test_the_agent_runs_and_stops_as_agents_do() -> None:
    check_agent(lambda: MissionAgent(RunConfig(Mission.model_validate(WAITING), robot())))


@pytest.mark.parametrize("is_read", [True, False])
def test_a_mission_with_a_conversation_keeps_the_contract_whether_or_not_a_person_reads(is_read: bool) -> None:
    talk = ConversationalAgent(doors=[TextDoor("terminal", lambda line: None, lambda: is_read)])
    talk.run()
    check_agent(lambda: MissionAgent(RunConfig(Mission.model_validate(WAITING), robot()), talk=talk))
    talk.stop()


def test_people_talk_about_the_run_of_an_agent_and_are_reported_its_end(tmp_path: Path) -> None:
    lines: list[str] = []
    talk = ConversationalAgent(doors=[TextDoor("terminal", lambda line: lines.append(line.text))])
    is_running = threading.Event()
    config = RunConfig(
        Mission.model_validate(WAITING),
        robot(),
        journal=tmp_path / "run.journal",
        on_status=lambda status: is_running.set() if status.mode == "running" else None,
    )
    mission = MissionAgent(config, talk=talk)
    both = AgentRunner({"talk": talk, "mission": mission})
    both.run()
    assert is_running.wait(5)
    assert talk.receive("what are you doing?", role="operator", channel="terminal") == ""
    talk.wait_answered(5)
    assert lines[-1] == "The mission 'waiting' is running, in the state 'idle'."
    both.stop()
    assert lines[-1] == "The mission 'waiting' was canceled: canceled by stop."
    assert mission.result is not None and mission.result.outcome == "canceled"
    with read(tmp_path / "run.journal") as record:
        rows = str(list(record.notes()))
    assert "what are you doing?" in rows and lines[-1] in rows


def test_an_agent_that_is_stopped_has_canceled_its_mission(tmp_path: Path) -> None:
    started = threading.Event()
    agent = MissionAgent(
        RunConfig(Mission.model_validate(WAITING), robot(), clock=WallClock(), on_step=lambda step: started.set())
    )
    agent.run()
    assert started.wait(5.0)
    agent.stop()
    assert agent.result is not None and (agent.result.outcome, agent.result.why) == ("canceled", "canceled by stop")


def test_an_agent_that_is_stopped_at_once_has_canceled_its_mission_too() -> None:
    for _ in range(20):
        agent = MissionAgent(RunConfig(Mission.model_validate(WAITING), robot()))
        agent.run()
        agent.stop()
        assert agent.result is not None and agent.result.outcome == "canceled"


@pytest.mark.parametrize("word", ["on_step", "on_status"])
def test_an_agent_that_is_stopped_by_what_follows_its_run_cancels_it_and_closes_everything(
    word: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    words: dict[str, Any] = {word: lambda _: agent.stop(), "journal": tmp_path / "run.journal"}
    agent = MissionAgent(RunConfig(Mission.model_validate(WAITING), robot(), **words))
    agent.run()
    assert agent._thread is not None
    agent._thread.join(10.0)
    assert agent.result is not None and agent.result.outcome == "canceled" and not caplog.records
    assert agent._prepared.journal is not None
    with pytest.raises(UsageError, match="is closed; open it again to write"):
        agent._prepared.journal.note("after it")
    agent.stop()


def test_an_agent_that_is_stopped_before_it_is_run_runs_its_mission(monkeypatch: pytest.MonkeyPatch) -> None:
    plugins = Path(__file__).parents[1] / "plugins"
    monkeypatch.syspath_prepend(str(plugins / "installed"))
    agent = MissionAgent(RunConfig(plugins / "mission.json", plugins / "robot.json"))
    agent.stop()
    agent.run()
    assert agent._thread is not None
    agent._thread.join(30.0)
    agent.stop()
    assert agent.error is None and agent.result is not None and agent.result.outcome == "succeeded"


def test_an_agent_whose_run_breaks_off_reports_why(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.CRITICAL + 1)
    keys = {"battery": {"type": "number", "source": "robot"}}
    states = {
        "idle": {
            "transitions": [
                {"when": {"key": "battery", "<": 0.5}, "to": "over"},
                {"when": {"not": {"fresh": "battery"}}, "to": "over"},
            ]
        },
        "over": {"final": "aborted"},
    }
    given = {"name": "deaf", "initial": "idle", "states": states, "blackboard": keys, "ready_s": 0.05}
    source = {"topic": "/battery", "type": "std_msgs/msg/Float32"}
    agent = MissionAgent(
        RunConfig(
            Mission.model_validate(given), Robot.model_validate({"name": "mute", "blackboard": {"battery": source}})
        )
    )
    agent.run()
    assert agent._thread is not None
    agent._thread.join(5.0)
    agent.stop()
    assert agent.result is None and "the robot has not reported within 0.05 s: battery" in str(agent.error)


def test_an_event_can_be_posted_to_a_run_that_was_prepared() -> None:
    with prepare(RunConfig(Mission.model_validate(WAITING), robot())) as prepared:
        prepared.runner.post(Event("go"))
        assert prepared.runner.run().outcome == "aborted"


SHORT = {
    "name": "short",
    "initial": "idle",
    "states": {"idle": {"transitions": [{"after_s": 0.02, "to": "over"}]}, "over": {"final": "aborted"}},
}
COUNTED = {**SHORT, "blackboard": {"count": {"type": "integer", "source": "argument", "initial": 1}}}


def test_a_run_follows_another_in_its_environment_with_its_own_arguments_and_journal(tmp_path: Path) -> None:
    config = RunConfig(Mission.model_validate(COUNTED), robot(), journal=tmp_path / "first.journal")
    with prepare(config) as first:
        first.hold_connector()
        with pytest.raises(UsageError, match="the run before is not over"):
            prepare_next(first, config)
        first.runner.run()
        second = replace(config, arguments={"count": 3}, journal=tmp_path / "second.journal")
        with pytest.raises(DefinitionError, match="the mission takes no argument 'cont'"):
            prepare_next(first, replace(second, arguments={"cont": 3}))
        with prepare_next(first, second) as next_one:
            assert next_one.clock is first.clock and next_one.environment.connector is first.environment.connector
            first.close_files()
            assert next_one.runner.run().outcome == "aborted"
            assert next_one.runner.view.board["count"].value == 3
    assert verify(tmp_path / "first.journal") == verify(tmp_path / "second.journal") == ()


def test_no_run_follows_one_that_was_stopped_at_once() -> None:
    config = RunConfig(Mission.model_validate(WAITING), robot())
    with prepare(config) as first:
        first.hold_connector()
        first.runner.kill("operator")
        assert first.runner.run().outcome == "aborted"
        with pytest.raises(UsageError, match="stopped at once, and no one has control since"):
            prepare_next(first, config)


@pytest.mark.sim
def test_a_run_that_continues_has_the_world_of_its_seed(tmp_path: Path) -> None:
    profile = robot(connector={"kind": "local", "world": "orchard", "seed": 7, "camera": False})
    path = tmp_path / "run.journal"
    with prepare(RunConfig(Mission.model_validate(WAITING), profile, journal=path, seed=5)) as killed:
        kinds = [each.kind for each in killed.world.obstacles]  # type: ignore[union-attr]
    with prepare(RunConfig(None, resume=path)) as again:
        assert [each.kind for each in again.world.obstacles] == kinds  # type: ignore[union-attr]


def test_a_run_that_continues_without_its_robots_identity_reports_it(tmp_path: Path) -> None:
    (tmp_path / "identity").mkdir()
    (tmp_path / "identity" / "description.md").write_text("I am a robot.")
    profile, path = tmp_path / "robot.json", tmp_path / "run.journal"
    profile.write_text(json.dumps({"format": 1, "name": "tried", "identity": "identity"}))
    prepare(RunConfig(Mission.model_validate(ASKING), profile, journal=path)).close()
    for given, is_there in ((None, False), (profile, True)):
        with prepare(RunConfig(None, given, resume=path, model=ScriptedModel([]))) as again:
            assert (again.plan.identity is not None) is is_there
            assert ("the model lacks the robot's identity" in again.resumption_notice) is not is_there


def test_a_run_that_continues_names_what_it_waits_for(tmp_path: Path) -> None:
    source, path = {"topic": "/battery", "type": "std_msgs/msg/Float32"}, tmp_path / "run.journal"
    battery = {"type": "number", "source": "robot", "max_age_s": 2}
    end = {"final": "aborted", "requires": {"key": "battery", ">": 0.9}, "settle_s": 60}
    given = {"name": "waits", "initial": "end", "states": {"end": end}, "blackboard": {"battery": battery}}
    profile = Robot.model_validate({"name": "tried", "blackboard": {"battery": source}})
    with prepare(RunConfig(Mission.model_validate(given), profile, journal=path)) as killed:
        chart = Chart(killed.mission)
        assert isinstance(killed.journal, Journal)
        for step in (chart.write("battery", 0.5, at=1.0), chart.start(1.0)):
            killed.journal.write(step, since=1.0)
    with prepare(RunConfig(None, resume=path)) as again:
        notice = "the run continues at 1.00 s in: end; it waits for the robot, 10 s at most: battery"
        assert again.resumption_notice == notice
