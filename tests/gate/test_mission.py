# SPDX-License-Identifier: Apache-2.0
"""A mission that shares its robot's actuators through a gate, in one process, on a simulated clock."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import pytest

from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError
from rai_missions.gate import GateAgent, gate_words
from rai_missions.profile import Robot, parse_profile
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.result import Result
from tests.rigs.runs import Rig, ScriptedWorld, robot

CONTROL = {who: f"/gate/{{by}}/hand_to_{who}" for who in ("autonomy", "agent", "operator", "nobody")}
HOLDER = {"topic": "/gate/holder", "type": "std_msgs/msg/String"}
ALIVE = {"topic": "/gate/agent/alive"}
STATES: dict[str, Any] = {
    "driving": {
        "control": "autonomy",
        "action": "move",
        "timeout_s": 60,
        "transitions": [{"on": "go", "to": "crossing"}],
    },
    "crossing": {
        "control": "agent",
        "handover_s": 3,
        "action": "turn",
        "timeout_s": 60,
        "transitions": [{"on": "again", "to": "over"}],
    },
    "over": {"final": "aborted"},
}


class Shared:
    """A run, and the gate before what it commands."""

    def __init__(
        self,
        moments: Mapping[float, Callable[[Shared], object]],
        *,
        gate: bool = True,
        profile: Robot | None = None,
        **words: Any,
    ) -> None:
        stage = ScriptedWorld({at: lambda do=do: do(self) for at, do in moments.items()})  # type: ignore[misc]
        clock = SimulatedClock(stage)
        connector = LocalConnector(now=clock.now)
        connector.start()
        self.rig = Rig(
            STATES,
            clock=clock,
            connector=connector,
            robot=profile or robot(control=CONTROL, holder=HOLDER, alive=ALIVE),
            **words,
        )
        self.gate = GateAgent(gate_words({}), connector, clock=clock)
        if gate:
            self.gate.open()
            stage.each = self.gate.tick

    def run(self) -> Result:
        try:
            return self.rig.run()
        finally:
            self.gate.close()

    @property
    def controls(self) -> list[tuple[float, str]]:
        return [(step.at, step.event.name) for step in self.rig.steps if step.event.kind == "control"]


def test_an_activity_starts_when_the_gate_reports_that_its_holder_has_control() -> None:
    shared = Shared({3.0: lambda all_: all_.rig.post("go"), 6.0: lambda all_: all_.rig.post("again")})
    assert shared.run().outcome == "aborted"
    assert shared.controls == [(1.0, "autonomy"), (3.0, "agent")]
    assert len(shared.rig.turn.goals) == 1 and shared.gate.gate.revision == 1, "the run reports that it is alive"


def test_a_run_begins_once_it_has_received_who_holds_control() -> None:
    with pytest.raises(UsageError, match="the robot has not reported within 10 s: who holds control; is it running"):
        Shared({}, gate=False).run()


def test_a_run_that_begins_while_the_operator_drives_waits_for_control() -> None:
    def give_back(all_: Shared) -> None:
        assert all_.rig.move.goals == []
        all_.gate.ask("autonomy", "operator")

    shared = Shared({2.0: give_back, 3.0: lambda all_: all_.rig.post("go"), 4.0: lambda all_: all_.rig.post("again")})
    shared.gate.ask("operator", "operator")
    shared.run()
    assert len(shared.rig.move.goals) == 1


def test_control_that_the_operator_takes_at_the_gate_stops_what_runs_until_it_is_given_back() -> None:
    def look(all_: Shared) -> None:
        assert len(all_.rig.turn.canceled) == 1, "what the agent did was stopped"

    shared = Shared(
        {
            3.0: lambda all_: all_.rig.post("go"),
            4.0: lambda all_: all_.gate.ask("operator", "operator"),
            5.0: look,
            6.0: lambda all_: all_.gate.ask("agent", "operator"),
            7.0: lambda all_: all_.rig.post("again"),
        }
    )
    shared.run()
    assert shared.controls == [(1.0, "autonomy"), (3.0, "agent"), (4.0, "operator"), (6.0, "agent")]
    assert len(shared.rig.turn.goals) == 2


def test_an_operator_who_takes_control_at_the_gate_holds_the_mission_until_it_is_given_back() -> None:
    shared = Shared(
        {
            2.0: lambda all_: all_.gate.ask("operator", "operator"),
            3.0: lambda all_: all_.rig.post("go"),
            900.0: lambda all_: all_.gate.ask("autonomy", "operator"),
            901.0: lambda all_: all_.rig.post("again"),
        }
    )
    assert shared.run().outcome == "aborted"
    assert shared.controls == [(1.0, "autonomy"), (2.0, "operator"), (900.0, "autonomy"), (900.0, "agent")]
    assert len(shared.rig.turn.goals) == 1


def test_an_operator_who_takes_at_the_gate_what_the_mission_gave_keeps_it() -> None:
    """The gate names the same holder before and after; that it is kept shows in what the gate refuses."""
    shared = Shared(
        {
            2.0: lambda all_: all_.gate.ask("operator", "agent"),
            3.0: lambda all_: all_.gate.ask("operator", "operator"),
            4.0: lambda all_: all_.rig.runner._control.acknowledge("operator"),
            5.0: lambda all_: all_.rig.runner._handovers.hand_over("agent", "mission"),
            6.0: lambda all_: all_.rig.post("go"),
            600.0: lambda all_: all_.gate.ask("autonomy", "operator"),
            601.0: lambda all_: all_.rig.post("again"),
        }
    )
    assert shared.run().outcome == "aborted" and len(shared.rig.turn.goals) == 1


def test_the_status_reports_by_whom_the_mission_is_held_and_since_when() -> None:
    lines: list[tuple[str, float | None, str]] = []
    shared = Shared(
        {
            2.0: lambda all_: all_.gate.ask("operator", "operator"),
            3.0: lambda all_: all_.gate.ask("nobody", "operator"),
            4.0: lambda all_: all_.gate.ask("autonomy", "operator"),
            5.0: lambda all_: all_.rig.runner.cancel("the test"),
        },
        on_status=lambda status: lines.append((status.held_by, status.held_since, status.waits)),
    )
    shared.run()
    words = "held until the operator gives control back; {} has it; driving waits"
    held = [("operator", 2.0, words.format("operator")), ("nobody", 3.0, words.format("nobody"))]
    assert [each for each in lines if each[0]] == held
    assert lines[-1][:2] == ("", None)


def test_a_gate_that_is_gone_acknowledges_nothing() -> None:
    shared = Shared({2.0: lambda all_: all_.gate.close(), 3.0: lambda all_: all_.rig.post("go")})
    assert shared.run().why == "crossing: rejected (agent was not given control in time)"


def test_a_run_that_does_not_state_that_it_continues_loses_control_and_learns_of_it() -> None:
    shared = Shared(
        {3.0: lambda all_: all_.rig.post("go"), 5.0: lambda all_: all_.rig.runner.kill()},
        profile=robot(control=CONTROL, holder=HOLDER),
    )
    shared.run()
    assert shared.controls[:3] == [(1.0, "autonomy"), (3.0, "agent"), (3.5, "autonomy")]
    assert len(shared.rig.turn.canceled) == 1


def test_an_operator_who_asks_the_run_for_control_keeps_it_at_the_gate_too() -> None:
    def look(all_: Shared) -> None:
        assert all_.gate.gate.holder == "operator" and all_.gate.gate.kept
        assert all_.gate.ask("agent", "agent")["message"] == "the operator has control and has not given it back"

    shared = Shared(
        {
            3.0: lambda all_: all_.rig.runner.control("operator"),
            4.0: look,
            5.0: lambda all_: all_.gate.ask("autonomy", "operator"),
            6.0: lambda all_: all_.rig.post("go"),
            7.0: lambda all_: all_.rig.post("again"),
        }
    )
    assert shared.run().outcome == "aborted"
    assert [holder for _, holder in shared.controls] == ["autonomy", "operator", "autonomy", "agent"]


def test_an_e_stop_leaves_control_with_no_one_at_the_gate() -> None:
    shared = Shared({3.0: lambda all_: all_.rig.post("go"), 4.0: lambda all_: all_.rig.runner.kill()})
    shared.run()
    assert shared.gate.gate.holder == "nobody"


def test_a_mission_that_ends_leaves_control_where_it_is_until_its_lease_ends() -> None:
    shared = Shared({3.0: lambda all_: all_.rig.post("go"), 4.0: lambda all_: all_.rig.post("again")})
    shared.run()
    assert shared.gate.gate.holder == "agent"


def test_a_profile_states_where_the_holder_is_received_and_the_run_is_alive() -> None:
    written = robot(control=CONTROL, holder=HOLDER, alive={**ALIVE, "every_s": 0.2}).written()
    assert written["alive"] == {"topic": "/gate/agent/alive", "every_s": 0.2} and written["holder"] == HOLDER
    assert parse_profile(json.dumps(written)).alive == robot(alive={**ALIVE, "every_s": 0.2}).alive
