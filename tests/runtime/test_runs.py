# SPDX-License-Identifier: Apache-2.0
"""From what is received to what is done: events, actions, calls, and how a run ends."""

from __future__ import annotations

import math
import re
import shlex
import sys
from typing import Any

import pytest

from rai_missions.cli.inputs import read_pairs
from rai_missions.connectors.connector import Message
from rai_missions.engine.step import CallService, StartGoal
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.runtime.arguments import WRITTEN, accepted
from tests.rigs.runs import KEYS, Rig, mission, robot

MOVING: dict[str, Any] = {
    "idle": {"transitions": [{"on": "go", "to": "moving"}]},
    "moving": {
        "action": "move",
        "timeout_s": 10,
        "goal": {"speed": {"from": "speed"}},
        "transitions": [
            {"on": "succeeded", "to": "done"},
            {"on": "failed", "to": "lost"},
            {"on": "timed_out", "to": "late"},
        ],
    },
    "done": {"final": "succeeded", "requires": {"key": "there", "==": True}},
    "lost": {"final": "failed"},
    "late": {"final": "failed"},
}
CALLING: dict[str, Any] = {
    "idle": {"transitions": [{"on": "go", "to": "calling"}]},
    "calling": {
        "call": "horn",
        "timeout_s": 5,
        "transitions": [{"on": "succeeded", "to": "over"}, {"on": ["failed", "rejected", "timed_out"], "to": "lost"}],
    },
    "over": {"final": "aborted"},
    "lost": {"final": "failed"},
}


def test_an_event_becomes_a_step_and_the_step_a_call() -> None:
    rig = Rig(CALLING)
    rig.stage.play({1.0: lambda: rig.post("go")})
    result = rig.run()
    assert rig.called == [(1.0, "/horn")]
    assert (result.outcome, result.why) == ("aborted", "'over' was reached")
    assert [type(effect) for step in rig.steps for effect in step.effects] == [CallService]


def test_an_action_succeeds_only_as_its_server_and_the_facts_state() -> None:
    rig = Rig(MOVING, arguments={"speed": 2.5})
    rig.stage.play(
        {
            1.0: lambda: rig.post("go"),
            2.0: lambda: rig.publish("/there", data=True),
            3.0: lambda: rig.move.report("succeeded"),
        }
    )
    result = rig.run()
    assert result.outcome == "succeeded" and result.duration_s == 3.0
    assert rig.move.given == [{"speed": 2.5}]


@pytest.mark.parametrize(
    ("message", "why"),
    [
        ("failed", "'lost' was reached"),
        ("lost", "'lost' was reached"),
        ("canceled", "moving: canceled"),
        ("rejected", "'lost' was reached"),
    ],
)
def test_an_action_that_does_not_succeed_is_no_success(message: str, why: str) -> None:
    rig = Rig(MOVING)
    rig.stage.play(
        {
            1.0: lambda: rig.post("go"),
            1.5: lambda: rig.publish("/there", data=True),
            2.0: lambda: rig.move.report(message),
        }
    )
    result = rig.run()
    assert (result.outcome, result.why) == ("failed", why)


def test_a_word_that_no_server_reports_ends_no_goal() -> None:
    rig = Rig(MOVING)
    rig.stage.play(
        {
            1.0: lambda: rig.post("go"),
            1.5: lambda: rig.publish("/there", data=True),
            2.0: lambda: rig.move.report("exploded"),
            3.0: lambda: rig.move.report("succeeded"),
        }
    )
    assert rig.run().outcome == "succeeded"


def test_a_success_that_the_facts_do_not_bear_out_fails_the_mission() -> None:
    rig = Rig(MOVING)
    rig.stage.play({1.0: lambda: rig.post("go"), 2.0: lambda: rig.move.report("succeeded")})
    result = rig.run()
    assert result.outcome == "failed" and "there" in result.why


def test_a_timeout_cancels_its_action_and_waits_for_the_end_of_it() -> None:
    rig = Rig(MOVING)
    rig.move.on_cancel = ()
    rig.stage.play({1.0: lambda: rig.post("go"), 13.0: lambda: rig.move.report("canceled")})
    result = rig.run()
    assert (result.outcome, rig.entered[-1]) == ("failed", "late")
    assert len(rig.move.canceled) == 1
    assert result.duration_s == 13.0, "the run ends when the server has confirmed, not before"


def test_a_goal_that_never_confirms_its_end_does_not_hold_up_the_end_of_the_run() -> None:
    rig = Rig(MOVING)
    rig.move.on_cancel = ()
    rig.stage.play({1.0: lambda: rig.post("go")})
    result = rig.run()
    assert result.duration_s == pytest.approx(16.0, abs=0.11), "timeout_s 10 and cancel_s 5 after the start at 1 s"
    assert any("orphaned" in note for step in rig.book.steps for note in step.notes)


def test_a_cancel_before_the_acceptance_is_sent_as_soon_as_it_is_accepted() -> None:
    rig = Rig(MOVING)
    rig.move.at_once = ()
    rig.stage.play({1.0: lambda: rig.post("go"), 11.5: lambda: rig.move.report("accepted")})
    result = rig.run()
    assert len(rig.move.canceled) == 1 and result.duration_s == 11.5


def test_after_the_end_nothing_is_performed() -> None:
    rig = Rig(MOVING)
    rig.move.on_cancel = ()
    rig.stage.play(
        {
            1.0: lambda: rig.post("go"),
            11.5: lambda: (rig.post("go"), rig.publish("/there", data=True)),
            12.0: lambda: rig.move.report("succeeded"),
        }
    )
    result = rig.run()
    assert result.outcome == "failed" and len(rig.move.goals) == 1
    late = [step for step in rig.book.steps if step.at > 11.1]
    assert late and not any(step.effects or step.moves for step in late)


def test_the_world_is_still_once_the_run_has_ended() -> None:
    rig = Rig(CALLING)
    rig.stage.play({1.0: lambda: rig.post("go")})
    rig.run()
    assert rig.stage.at == 1.0


def test_a_late_result_belongs_to_no_other_goal() -> None:
    states = {
        "first": {
            "action": "move",
            "timeout_s": 1,
            "cancel_s": 1,
            "transitions": [{"on": "timed_out", "to": "second"}],
        },
        "second": {
            "action": "move",
            "timeout_s": 5,
            "over_orphan": True,
            "transitions": [{"on": "succeeded", "to": "done"}, {"on": "timed_out", "to": "late"}],
        },
        "done": {"final": "aborted"},
        "late": {"final": "failed"},
    }
    rig = Rig(states)
    rig.move.on_cancel = ()
    rig.stage.play({3.0: lambda: rig.move.report("succeeded", 0)})
    result = rig.run()
    assert len(rig.move.goals) == 2 and result.outcome == "failed"


def test_an_action_made_of_services_starts_ends_and_is_canceled_by_them() -> None:
    states = {
        "driving": {
            "action": "drive",
            "timeout_s": 3,
            "transitions": [{"on": "succeeded", "to": "done"}, {"on": "timed_out", "to": "late"}],
        },
        "done": {"final": "aborted"},
        "late": {"final": "failed"},
    }
    rig = Rig(states)
    rig.stage.play({2.0: lambda: rig.publish("/there", data=True)})
    assert rig.run().outcome == "aborted" and [name for _, name in rig.called] == ["/drive"]
    rig = Rig(states)
    assert rig.run().outcome == "failed" and rig.called == [(0.0, "/drive"), (3.0, "/halt")]


def test_a_robot_key_never_received_refuses_the_start_and_nothing_is_performed() -> None:
    keys = {**KEYS, "battery": {**KEYS["battery"], "optional": False}, "there": {**KEYS["there"], "optional": False}}
    states = {
        "moving": {"action": "move", "timeout_s": 1, "transitions": [{"on": "succeeded", "to": "end"}]},
        "end": {"final": "failed"},
    }
    rig = Rig(mission(states, blackboard=keys, ready_s=2))
    rig.stage.play({0.5: lambda: rig.publish("/there", data=True)})
    with pytest.raises(UsageError, match=r"the robot has not reported within 2 s: battery; is it running\?"):
        rig.run()
    assert rig.move.goals == [] and rig.stage.at == pytest.approx(2.0, abs=0.11)
    assert "battery" in rig.book.notes[0], "the journal has why there was no run"


def test_what_came_with_the_last_fact_that_must_be_there_is_known_at_the_start() -> None:
    keys = {**KEYS, "battery": {**KEYS["battery"], "optional": False}}
    states = {
        "looking": {
            "transitions": [
                {"when": {"fresh": "there"}, "to": "end"},
                {"when": {"not": {"fresh": "there"}}, "to": "blind"},
            ]
        },
        "end": {"final": "aborted"},
        "blind": {"final": "failed"},
    }
    rig = Rig(mission(states, blackboard=keys))
    rig.stage.play({0.5: lambda: (rig.publish("/battery", percentage=0.8), rig.publish("/there", data=True))})
    assert rig.run().outcome == "aborted"


def test_a_run_starts_as_soon_as_all_is_received() -> None:
    keys = {**KEYS, "battery": {**KEYS["battery"], "optional": False}}
    rig = Rig(mission({"end": {"final": "aborted"}}, blackboard=keys))
    rig.stage.play({0.7: lambda: rig.publish("/battery", percentage=0.5)})
    assert rig.run().duration_s == 0.7


def test_a_mission_may_end_as_it_starts() -> None:
    for outcome in ("succeeded", "failed", "aborted", "canceled"):
        seen: list[str] = []
        rig = Rig({"end": {"final": outcome}}, on_status=lambda status, seen=seen: seen.append(status.mode))
        assert rig.run().outcome == outcome and seen == [outcome]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"sped": 1.0}, "the mission takes no argument 'sped'; did you mean 'speed'"),
        ({"speed": "fast"}, "the argument does not fit: 'fast' is not of type 'number'"),
        ({"count": 3}, "the mission takes no argument 'count': the source of that key is 'mission'; there is: speed"),
    ],
)
def test_an_argument_that_the_mission_does_not_take_is_refused(arguments: dict[str, Any], sentence: str) -> None:
    with pytest.raises(DefinitionError) as caught:
        Rig(CALLING, arguments=arguments)
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"x": 1, "y": 2, "frame": "map", "yaw": -3.1}, ""),
        ({"x": 1, "y": 2, "frame": "map", "yaw": 90}, "yaw 90 is more than a turn; it is in radians: 90° are 1.571"),
        ({"x": 1, "y": 2, "frame": "map", "yaw_deg": 90}, "a pose has no 'yaw_deg'; did you mean 'yaw'?"),
        ({"x": 1, "y": 2, "frame": "odom"}, "is not in the frame of this key"),
        ("kitchen", "'kitchen' is not of type 'pose'"),
    ],
)
def test_a_pose_that_is_given_is_held_to_its_words_alone_and_in_a_list(given: Any, why: str) -> None:
    pose = {"type": "pose", "source": "argument", "frame": "map"}
    keys = {"home": pose, "bed": {"type": "pose", "frame": "map"}, "beds": {"type": "list", "source": "argument"}}
    going = {"each": "beds", "as": "bed", "initial": "over", "states": {"over": {"final": "succeeded"}}}
    states = {"going": going | {"transitions": [{"on": "succeeded", "to": "end"}]}, "end": {"final": "aborted"}}
    mission = Mission.model_validate({"name": "taking", "initial": "going", "states": states, "blackboard": keys})
    fit = {"x": 0, "y": 0, "frame": "map"}
    for arguments, where in (({"home": given, "beds": [fit]}, ""), ({"home": fit, "beds": [fit, given]}, "item 1: ")):
        if why:
            with pytest.raises(DefinitionError, match=f"does not fit: {where}.*{re.escape(why)}"):
                accepted(mission, arguments)
        else:
            assert accepted(mission, arguments) == arguments


@pytest.mark.parametrize(
    ("bounds", "given", "why"),
    [
        ({"minimum": 1, "maximum": 3600}, 0, "0 is out of range; it must be from 1 to 3600"),
        ({"minimum": 0.5}, 0.4, "0.4 is out of range; it must be 0.5 or more"),
        ({"maximum": -1}, 0, "0 is out of range; it must be -1 or less"),
        ({"minimum": 1, "maximum": 3600}, 1, ""),
        ({"minimum": 1, "maximum": 3600}, 3600, ""),
    ],
)
def test_an_argument_is_held_to_its_range(bounds: dict[str, float], given: float, why: str) -> None:
    mission = Mission.model_validate({
        "name": "taking", "initial": "end", "states": {"end": {"final": "aborted"}},
        "blackboard": {"given": {"type": "number", "source": "argument", **bounds}},
    })  # fmt: skip
    if not why:
        assert accepted(mission, {"given": given}) == {"given": given}
        return
    with pytest.raises(DefinitionError, match=re.escape(why)):
        accepted(mission, {"given": given})


def test_an_argument_is_one_of_its_listed_values() -> None:
    mission = Mission.model_validate({
        "name": "taking", "initial": "end", "states": {"end": {"final": "aborted"}},
        "blackboard": {"given": {"type": "string", "source": "argument", "enum": ["water", "spray"]}},
    })  # fmt: skip
    assert accepted(mission, {"given": "spray"}) == {"given": "spray"}
    with pytest.raises(DefinitionError, match="there is no 'sprai'; did you mean 'spray'"):
        accepted(mission, {"given": "sprai"})


@pytest.mark.parametrize("sort", WRITTEN)
def test_an_argument_that_a_shell_made_text_is_refused_with_one_that_the_mission_takes(sort: str) -> None:
    mission = Mission.model_validate({
        "name": "taking", "initial": "end", "states": {"end": {"final": "aborted"}},
        "blackboard": {"given": {"type": sort, "source": "argument"}},
    })  # fmt: skip
    with pytest.raises(DefinitionError, match="does not fit") as caught:
        accepted(mission, {"given": "[a, b]"})
    option = str(caught.value).rpartition("--set ")[2]
    taken = read_pairs("--set", [shlex.split(option)[0]])
    assert accepted(mission, taken) == taken and not isinstance(taken["given"], str)


def test_a_profile_that_lacks_a_name_is_refused_before_the_start() -> None:
    with pytest.raises(DefinitionError, match="horn"):
        Rig(CALLING, robot=robot(services={}))


def test_a_polled_service_is_an_event_when_its_guard_becomes_true() -> None:
    reported = ["DRIVING"]
    rig = Rig(
        {
            "waiting": {
                "transitions": [{"on": "go", "do": [{"set": "count", "add": 1}]}, {"on": "again", "to": "end"}]
            },
            "end": {"final": "failed"},
        },
        robot=robot(
            events={
                "go": {"service": "/state", "type": "t", "every_s": 0.5, "when": {"key": "message", "==": "WAITING"}},
                "again": {"posted": True},
                "stop_now": {"posted": True},
            }
        ),
    )
    asked: list[float] = []
    rig.connector.serve("/state", "t", lambda _: (asked.append(rig.stage.at), {"message": reported[0]})[1])
    rig.stage.play(
        {
            1.1: lambda: reported.__setitem__(0, "WAITING"),
            2.1: lambda: reported.__setitem__(0, "DRIVING"),
            3.1: lambda: reported.__setitem__(0, "WAITING"),
            4.1: lambda: rig.post("again"),
        }
    )
    rig.run()
    assert rig.runner.view.board["count"].value == 2, "once for each time that it became true"
    assert asked == pytest.approx([0.5 * n for n in range(9)])


def test_what_was_so_before_the_start_happens_when_the_mission_starts() -> None:
    keys = {**KEYS, "battery": {**KEYS["battery"], "optional": False}}
    states = {"waiting": {"transitions": [{"on": "go", "to": "end"}]}, "end": {"final": "aborted"}}
    source = {"service": "/state", "type": "t", "every_s": 0.5, "when": {"key": "message", "==": "WAITING"}}
    rig = Rig(
        mission(states, blackboard=keys),
        robot=robot(events={"go": source, "again": {"posted": True}, "stop_now": {"posted": True}}),
    )
    rig.connector.serve("/state", "t", lambda _: {"message": "WAITING"})
    rig.stage.play({1.2: lambda: rig.publish("/battery", percentage=0.5), 9.0: lambda: rig.runner.kill("too late")})
    assert rig.run().why == "'end' was reached"


def test_a_stale_reading_counts_as_unknown() -> None:
    states = {
        "arriving": {"transitions": [{"when": {"fresh": "battery"}, "to": "watching"}]},
        "watching": {"transitions": [{"when": {"not": {"fresh": "battery"}}, "to": "blind"}]},
        "blind": {"final": "aborted"},
    }
    rig = Rig(states)
    rig.runner.post(Event("battery", 0.0, {"value": 0.9}, "write"))
    rig.stage.play(
        {
            1.0: lambda: rig.publish("/battery", percentage=0.8, header={"stamp": {"sec": 0, "nanosec": 900_000_000}}),
            2.0: lambda: rig.publish("/battery", percentage=0.7, header={"stamp": {"sec": 0, "nanosec": 500_000_000}}),
        }
    )
    assert rig.run().duration_s == pytest.approx(2.9, abs=0.11), "2 s after the newest stamp, whenever it was received"


def test_effects_are_performed_only_after_their_transition_is_written() -> None:
    rig = Rig(MOVING)
    order: list[str] = []
    rig.book.on_write = lambda step: order.extend("written" for effect in step.effects if isinstance(effect, StartGoal))
    rig.move.accept = lambda *_: order.append("sent")  # type: ignore[method-assign]
    rig.stage.play({1.0: lambda: rig.post("go")})
    rig.run()
    assert order == ["written", "sent"]


def test_writes_that_enable_nothing_travel_and_the_newest_of_a_key_arrives() -> None:
    rig = Rig({"waiting": {"transitions": [{"on": "go", "to": "end"}]}, "end": {"final": "aborted"}})
    rig.stage.each = lambda: rig.publish("/battery", percentage=rig.stage.at)
    rig.stage.play({9.5: lambda: rig.post("go")})
    rig.run()
    assert 9 <= len(rig.book.steps) <= 12, "95 writes, a row a second"
    assert rig.book.quiet[-1][:2] == ("battery", 9.5)
    assert max(later[2] - sooner[2] for sooner, later in zip(rig.book.quiet, rig.book.quiet[1:], strict=False)) <= 1.2


def test_of_the_readings_of_a_key_that_are_refused_one_a_second_has_a_row() -> None:
    rig = Rig({"waiting": {"transitions": [{"on": "go", "to": "end"}]}, "end": {"final": "aborted"}})

    def publish_twice() -> None:
        """As two robots do whose clocks differ, on one topic."""
        for late_s in (0.0, 0.05):
            sec, rest = divmod(round((rig.stage.at + 1.0 - late_s) * 1e9), 10**9)
            rig.publish("/battery", percentage=0.5, header={"stamp": {"sec": sec - 1, "nanosec": rest}})

    rig.stage.each = publish_twice
    rig.stage.play({9.5: lambda: rig.post("go")})
    rig.run()
    refused = [step for step in rig.book.steps if step.refusal]
    assert 9 <= len(refused) <= 10 and all("older than what is known" in step.why for step in refused)


def test_what_is_due_in_the_instant_of_a_quiet_transition_is_done() -> None:
    states = {
        "waiting": {"transitions": [{"after_s": 2.0, "to": "calling"}]},
        **{name: CALLING[name] for name in ("calling", "over", "lost")},
    }
    rig = Rig(states)
    rig.stage.play({1.0: lambda: rig.publish("/battery", percentage=0.5)})
    assert rig.run().outcome == "aborted" and rig.called == [(2.0, "/horn")]


def test_an_event_that_no_transition_handles_is_in_the_journal() -> None:
    rig = Rig(CALLING)
    rig.stage.play({0.5: lambda: rig.post("again"), 0.7: lambda: rig.post("unheard_of"), 1.0: lambda: rig.post("go")})
    rig.run()
    written = {step.event.name: step for step in rig.book.steps}
    assert written["again"].ignored
    assert written["unheard_of"].why.startswith("the mission declares no event 'unheard_of'")


def test_a_rejected_start_is_reported_with_its_reason() -> None:
    rig = Rig(
        {
            "moving": {"action": "move", "timeout_s": 1, "transitions": [{"on": "succeeded", "to": "end"}]},
            "end": {"final": "failed"},
        }
    )
    rig.move.at_once = ("rejected",)
    assert rig.run().why.startswith("moving: rejected")


def test_a_feedback_changes_nothing() -> None:
    rig = Rig(MOVING)
    rig.stage.play(
        {
            1.0: lambda: rig.post("go"),
            2.0: lambda: rig.move.report("feedback", left_m=3.0),
            3.0: lambda: rig.move.report("failed"),
        }
    )
    rig.run()
    (reported,) = [step for step in rig.book.steps if step.event.kind == "feedback"]
    assert reported.ignored and reported.event.data == {"left_m": 3.0}


def test_goals_that_share_a_resource_do_not_overlap() -> None:
    states = {
        "moving": {"action": "move", "timeout_s": 9, "transitions": [{"on": "go", "to": "turning"}]},
        "turning": {"action": "turn", "timeout_s": 9, "transitions": [{"on": "succeeded", "to": "end"}]},
        "end": {"final": "aborted"},
    }
    rig = Rig(states)
    rig.move.on_cancel, rig.turn.at_once = (), ("accepted", "succeeded")

    def confirm() -> None:
        assert rig.turn.goals == [], "the old goal has not confirmed its end"
        rig.move.report("canceled")

    rig.stage.play({1.0: lambda: rig.post("go"), 3.0: confirm})
    assert rig.run().outcome == "aborted" and len(rig.turn.goals) == 1


@pytest.mark.parametrize(
    ("own", "connector", "stamp"),
    [
        (None, 2.5, 2.5),
        (2.0, 2.5, 2.5),
        (1.7e9, 2.5, 2.5),
        (0.0, 2.5, 2.5),
        (1.7e9, 1.7e9, 3.0),
        (None, 1.7e9, 3.0),
        (None, 0.0, 0.0),
        (None, -3600.0, -3600.0),
        (None, math.nan, 3.0),
        (None, -math.inf, 3.0),
    ],
)
def test_a_reading_is_as_old_as_its_connector_dates_it(own: Any, connector: float, stamp: float) -> None:
    """Its own stamp is of its sender's clock, which its connector alone can read."""
    rig = Rig(CALLING)
    listeners: list[Any] = []
    subscribe = rig.connector.subscribe
    rig.connector.subscribe = lambda topic, kind, on_message: (
        listeners.append((topic, on_message)),
        subscribe(topic, kind, on_message),
    )[1]
    data = {"percentage": 0.5, **({} if own is None else {"header": {"stamp": own}})}
    received = Message("/battery", data, connector)
    rig.stage.play({3.0: lambda: dict(listeners)["/battery"](received), 4.0: lambda: rig.post("go")})
    rig.run()
    assert rig.runner.view.board["battery"].at == stamp


def calls_of_events(states: int) -> int:
    """The functions that a run calls for ten events in a mission that has so many states more."""
    more = {f"s{number}": {"transitions": [{"on": "stop_now", "to": "over"}]} for number in range(states)}
    idle = {"transitions": [{"on": "go", "do": [{"call": "horn"}]}, {"on": "stop_now", "to": "over"}]}
    count = 0

    def called(frame: object, event: str, what: object) -> None:
        nonlocal count
        count += event == "call"

    def flood() -> None:
        for _ in range(10):
            rig.post("go")
        sys.setprofile(called)

    rig = Rig({"idle": idle, "over": {"final": "aborted"}, **more})
    rig.stage.play({1.0: flood, 2.0: lambda: sys.setprofile(None), 3.0: lambda: rig.post("stop_now")})
    rig.run()
    assert len(rig.called) == 10
    return count


def test_an_event_takes_as_much_in_a_mission_of_many_states() -> None:
    assert calls_of_events(300) <= calls_of_events(3) + 100
