# SPDX-License-Identifier: Apache-2.0
"""A run that continues in a mission that has changed: what continues, what begins again, what is refused."""

from __future__ import annotations

import copy
import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from rai_missions.agents.talk.journal import earlier_lines, waiting_requests
from rai_missions.engine import Chart
from rai_missions.engine.step import CallService, StartGoal
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.event import Event, Tick
from rai_missions.journal import Header, Journal, Record, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.replay.migrate import Map, load_map, map_schema, migrate
from rai_missions.replay.open_run import open_run
from rai_missions.replay.resume import resumption
from tests.replay.mortal import Fate, Land, live
from tests.replay.test_kills import ROBOT, Ended, entered, holds
from tests.rigs.runs import ReplyingAnswerer

DOCUMENT: dict[str, Any] = {
    "name": "errand", "version": "1.0.0", "initial": "work", "events": {"go": {}},
    "blackboard": {"rounds": {"type": "integer", "initial": 0}, "place": {"type": "string", "initial": "here"}},
    "states": {
        "work": {"parallel": {
            "body": {"initial": "moving", "states": {
                "moving": {"action": "move", "timeout_s": 60, "entry": [{"set": "rounds", "add": 1}],
                           "transitions": [{"on": "succeeded", "to": "moved"}]},
                "moved": {"final": "succeeded"}}},
            "head": {"initial": "waiting", "states": {
                "waiting": {"transitions": [{"after_s": 8, "to": "waited"}]},
                "waited": {"final": "succeeded"}}}},
            "transitions": [{"on": "succeeded", "to": "asking"}]},
        "asking": {"decision": {"question": "On?", "options": {"on": {"about": "on"}, "stop": {"about": "stop"}},
                                "ask": ["someone"], "deadline_s": 30, "fallback": "stop"},
                   "transitions": [{"on": "on", "to": "over"}, {"on": "stop", "to": "given_up"}]},
        "over": {"final": "canceled"}, "given_up": {"final": "aborted"}},
}  # fmt: skip
BODY = ("states", "work", "parallel", "body", "states")
HEAD = ("states", "work", "parallel", "head", "states")


def changed(*changes: tuple[tuple[str, ...], Any]) -> Mission:
    """The errand with other things in some places; None takes a thing away."""
    document = copy.deepcopy(DOCUMENT)
    document["version"] = "2.0.0"
    for (*path, last), value in changes:
        inside = document
        for word in path:
            inside = inside[word]
        inside.pop(last, None)
        if value is not None:
            inside[last] = value
    return Mission.model_validate(document)


ERRAND = Mission.model_validate(DOCUMENT)


def land() -> Land:
    return Land([], {"move": 6.0, "turn": 4.0, "look": 2.0}, {})


def died(path: Path, there: Land, waits: int = 3, mission: Mission = ERRAND) -> Path:
    """A run that was killed after so many periods of half a second."""
    assert live(path, there, mission, ROBOT, {"someone": ReplyingAnswerer("on")}, Fate(waits, what="wait")) is None
    return path


def moved(tmp_path: Path, there: Land, mission: Mission, **words: Any) -> Path:
    path = died(tmp_path / "run.journal", there, words.pop("waits", 3))
    return migrate(path, mission, Map(**words), to=tmp_path / "new.journal").journal


def continued(path: Path, there: Land, mission: Mission) -> Ended:
    result = live(path, there, mission, ROBOT, {"someone": ReplyingAnswerer("on")}, Fate())
    assert result is not None
    holds(path, there, mission)
    return Ended(result.outcome, result.why)


def first_notes(path: Path) -> tuple[str, ...]:
    with read(path) as record:
        return next(record.steps()).notes


# -- what continues
# -----------------------------------------------------------------------------------------------------


def test_what_is_as_it_was_continues_by_itself(tmp_path: Path) -> None:
    there, now = land(), changed((("states", "over"), {"final": "failed"}))
    path = moved(tmp_path, there, now)
    assert first_notes(path) == ()
    assert continued(path, there, now) == ("failed", "'over' was reached")
    assert [action for action, _ in there.started] == ["move"], "its goal is found again"
    assert there.at == pytest.approx(8, abs=1.5), "its timer has the time that was left"
    assert entered(path).count("moving") == 1, "nothing is entered that was active"
    with read(path) as record:
        assert record.last() is not None
        assert {key: value for step in record.steps() for key, value in step.writes}.get("rounds") is None


def waiting_for(event: str, version: str, **entry: Any) -> Mission:
    """A mission that waits for an event, and raises it by itself where `entry` has it so."""
    return Mission.model_validate({
        "name": "waiting", "version": version, "initial": "here", "events": {event: {}, "stop": {}},
        "states": {"here": {"entry": [{"raise": event, **entry}] if entry else [],
                            "transitions": [{"on": event, "to": "there"}, {"on": "stop", "to": "over"}]},
                   "there": {"transitions": [{"on": "stop", "to": "over"}]}, "over": {"final": "aborted"}},
    })  # fmt: skip


def carried(tmp_path: Path, was: Mission, now: Mission, *events: Event) -> Chart:
    """The chart of a run in the mission as it is now, in which the event `go` is called `set_off`."""
    chart = Chart(was)
    with Journal.create(tmp_path / "run.journal", Header(dump(was))) as journal:
        for step in (chart.start(0.0), *map(chart.send, events)):
            journal.write(step, since=step.at)
    path = migrate(tmp_path / "run.journal", now, Map(events={"go": "set_off"}), to=tmp_path / "new.journal").journal
    with read(path) as record:
        return resumption(record, now).chart


def bounded(version: str, temperature: str, **brief: Any) -> Mission:
    """A mission with a temperature under this name, and a bound on how long something may be so."""
    mission = waiting_for("go", version).written()
    mission["blackboard"] = {key: {"type": "integer", "initial": 1} for key in (temperature, "speed")}
    mission["invariants"] = {"brief": {"not": brief}} if brief else {}
    return Mission.model_validate(mission)


@pytest.mark.parametrize(
    ("brief", "since"),
    [
        ({"held": {"key": "warmth", "==": 1}, "for_s": 5}, {"/invariants/brief#0": 0.0}),
        ({"held": {"key": "speed", "==": 1}, "for_s": 5}, {}),
        ({"held": {"key": "warmth", "==": 1}, "for_s": 6}, {}),
        ({}, {}),
    ],
    ids=["as it was, with its key's new name", "about another key", "with another time", "gone"],
)
def test_the_time_of_an_invariant_continues_where_it_is_as_it_was(
    tmp_path: Path, brief: dict[str, Any], since: dict[str, float]
) -> None:
    was = bounded("1.0.0", "heat", held={"key": "heat", "==": 1}, for_s=5)
    now, chart, path = bounded("2.0.0", "warmth", **brief), Chart(was), tmp_path / "run.journal"
    with Journal.create(path, Header(dump(was))) as journal:
        for step in (chart.start(0.0), chart.send(Tick(3.0))):
            journal.write(step, since=step.at)
    with read(migrate(path, now, Map(keys={"heat": "warmth"}), to=tmp_path / "new.journal").journal) as record:
        held = resumption(record, now).chart.snapshot()["held"]
    assert {memory: at for memory, at in held.items() if at < 3.0} == since


def test_an_event_that_came_in_a_pause_counts_at_its_end_under_its_new_name(tmp_path: Path) -> None:
    by = {"by": "operator"}
    events = (Event("pause", 1.0, by, "command"), Event("go", 2.0))
    chart = carried(tmp_path, waiting_for("go", "1.0.0"), waiting_for("set_off", "2.0.0"), *events)
    assert (chart.mode, chart.active) == ("paused", {"here"})
    chart.send(Event("resume", 3.0, by, "command"))
    assert chart.active == {"there"}


def test_an_event_that_is_raised_later_is_raised_at_its_time_under_its_new_name(tmp_path: Path) -> None:
    later = {"after_s": 6, "id": "x"}
    was, now = waiting_for("go", "1.0.0", **later), waiting_for("set_off", "2.0.0", **later)
    chart = carried(tmp_path, was, now, Tick(2.0))
    assert chart.send(Tick(5.5)).entered == ()
    assert chart.send(Tick(6.0)).entered == ("there",)


def test_a_state_that_has_changed_and_is_named_begins_what_it_runs_again(tmp_path: Path) -> None:
    there = land()
    now = changed(((*BODY, "moving", "action"), "turn"))
    path = moved(tmp_path, there, now, states={"moving": "moving"})
    assert "what ran in 'moving' has changed; 'moving' begins again" in first_notes(path)
    assert "goal 1 of 'move' belongs to nothing any more and is canceled" in first_notes(path)
    assert continued(path, there, now).outcome == "canceled"
    assert [action for action, _ in there.started] == ["move", "turn"]
    assert [how for _, how in there.ended] == ["canceled", "succeeded"]
    assert there.most_at_once == 1, "what was under way has ended before what is new is started"


def test_a_row_s_time_continues_where_the_row_is_as_it_was_and_begins_again_where_it_is_not(tmp_path: Path) -> None:
    there = land()
    now = changed(((*HEAD, "waiting", "transitions"), [{"after_s": 20, "to": "waited"}]))
    path = moved(tmp_path, there, now, states={"waiting": "waiting"})
    assert any("/waiting/transitions/0 begins again" in note for note in first_notes(path))
    continued(path, there, now)
    assert there.at == pytest.approx(3 + 20, abs=1.5)


def test_a_region_that_is_new_begins_and_one_that_is_gone_is_left(tmp_path: Path) -> None:
    there = land()
    look = {"initial": "looking", "states": {
        "looking": {"action": "look", "timeout_s": 9, "entry": [{"set": "place", "value": "there"}],
                    "transitions": [{"on": "succeeded", "to": "looked"}]},
        "looked": {"final": "succeeded"}}}  # fmt: skip
    now = changed((HEAD[:-1], None), (("states", "work", "parallel", "eyes"), look))
    path = moved(tmp_path, there, now, states={"head": None, "waiting": None})
    assert continued(path, there, now).outcome == "canceled"
    assert [action for action, _ in there.started] == ["move", "look"]
    with read(path) as record:
        writes = [dict(step.writes) for step in record.steps()]
    assert {"place": "there"} in writes, "what is new is entered"


def test_a_question_that_is_as_it_was_is_asked_again_and_another_is_not(tmp_path: Path) -> None:
    slow = ReplyingAnswerer("on")
    for number, question in enumerate(("On?", "Further?")):
        there, path = land(), tmp_path / f"{number}.journal"
        assert live(path, there, ERRAND, ROBOT, {"someone": slow}, Fate(0, what="ask")) is None
        now = changed((("states", "asking", "decision", "question"), question), (("states", "over", "about"), "done"))
        states = {"asking": "asking"} if number else {}
        new = migrate(path, now, Map(states=states), to=tmp_path / f"new{number}.journal").journal
        slow.asked.clear()
        assert live(new, there, now, ROBOT, {"someone": slow}, Fate()) is not None
        assert [each.text for each in slow.asked] == [question]


def test_keys_carry_their_values_under_their_new_names(tmp_path: Path) -> None:
    there = land()
    now = changed(
        (("blackboard", "rounds"), None),
        (("blackboard", "place"), None),
        (("blackboard", "tours"), {"type": "integer", "initial": 7}),
        (("blackboard", "mood"), {"type": "string"}),
        ((*BODY, "moving", "entry"), [{"set": "tours", "add": 1}]),
    )
    path = moved(tmp_path, there, now, keys={"rounds": "tours", "place": None}, values={"mood": "good"})
    taken = open_run(path)
    board = taken.resumption.chart.view.board
    assert {name: board[name].value for name in now.blackboard} == {"tours": 1, "mood": "good"}
    taken.record.close()


def test_a_run_may_continue_in_another_mission_again_and_again(tmp_path: Path) -> None:
    there, path = land(), tmp_path / "0.journal"
    died(path, there)
    names = ["moving", "going", "driving", "moving"]
    for number, (old, new) in enumerate(itertools.pairwise(names), start=1):
        state = DOCUMENT["states"]["work"]["parallel"]["body"]["states"]["moving"]
        now = changed((BODY, {new: state, "moved": {"final": "succeeded"}}), ((*BODY[:-1], "initial"), new))
        path = migrate(path, now, Map(states={old: new}), to=tmp_path / f"{number}.journal").journal
    assert continued(path, there, now).outcome == "canceled"
    assert [action for action, _ in there.started] == ["move"], "its goal is found again"


def test_what_programs_read_from_the_notes_of_a_run_goes_with_it_such_as_its_talk(tmp_path: Path) -> None:
    path = died(tmp_path / "0.journal", land())
    with read(path) as record:
        seal = record.seal
    line = {"number": 1, "by": "operator", "text": "start with rounds 2"}
    given = [{"talk": [{"kind": "waiting", "requests": ["two rounds"]}], "lines": [line]}, [1], "x"]
    with Journal.open(path, seal=seal) as journal:
        journal.note("for people alone")
        for data in given:
            journal.note("talk", data)
    for number in (1, 2):
        path = migrate(path, changed(), Map(), to=tmp_path / f"{number}.journal").journal
    with read(path) as record:
        notes = record.notes()
    assert [note.data for note in notes] == given
    assert waiting_requests(notes) == ("two rounds",)
    assert [line.text for line in earlier_lines(notes)] == ["start with rounds 2"]
    assert continued(path, land(), changed())


# -- what is refused --------------------------------------------------------------------------------------------------

ENDING = {"final": "succeeded"}
REFUSED: Mapping[str, tuple[Mission, dict[str, Any], str]] = {
    "a state that is active and has changed": (
        changed(((*BODY, "moving", "timeout_s"), 90)), {},
        '/states: \'moving\' is active and has changed (\'timeout_s\'); if it still means the same, name it: "moving": '
        '"moving"'),
    "a state that is active and is no more": (
        changed((BODY, {"going": {}, "moved": ENDING}), ((*BODY[:-1], "initial"), "going")), {},
        "/states: 'moving' is active, and the mission now has no state of that name; name what has become of it: "
        '"moving": "…", or null if nothing has'),
    "a state that there was not": (
        ERRAND, {"states": {"movin": "moving"}},
        "/states/movin: the mission of the run has no state 'movin'; did you mean 'moving'?"),
    "a state that there is not": (
        ERRAND, {"states": {"moving": "moved", "waiting": "wating"}},
        "/states/waiting: the mission now has no state 'wating'; did you mean 'waiting'?"),
    "an end": (
        ERRAND, {"states": {"moving": "over", "waiting": None, "head": None, "body": None, "work": None}},
        "/states/moving: 'over' is a final: a map ends no run; name a state from which a transition leads there"),
    "states that exclude each other": (
        changed((("states", "aside"), {"transitions": [{"on": "go", "to": "work"}]})),
        {"states": {"moving": "aside"}},
        "/states: 'work' and 'aside' would be active together, and cannot be; name one of them"),
    "a state that nothing inside leads to": (
        ERRAND, {"states": {"work": "asking"}},
        "/states/work: 'asking' would not be active, for what was active inside 'work' is not inside 'asking' now; "
        "name that too, or leave 'work' out"),
    "nowhere": (
        ERRAND, {"states": {"moving": None, "waiting": None}},
        "/states: none of the active states has a place in the mission now; name one for each"),
    "a list that has not begun": (
        changed((("blackboard", "stops"), {"type": "list", "initial": ["a"]}), (("states", "tour"), {
            "each": "stops", "as": "place", "initial": "at", "states": {"at": {}}})),
        {"states": {"moving": "at", "waiting": None, "work": None, "body": None, "head": None}},
        "/states: 'tour' goes through a list, and no active state shows how far in it the run has come; name one "
        "that did so, or a state outside"),
    "a key that is dropped unnamed": (
        changed((("blackboard", "place"), None)), {},
        "/keys: the run has a value for 'place', and the mission now has no such key; name it, or drop "
        'it: "place": null'),
    "a key of another type": (
        changed((("blackboard", "place"), {"type": "integer"})), {},
        "/keys: the value of 'place' does not fit 'place': 'here' is not of type 'integer'; give another in 'values'"),
    "a value that does not fit": (
        ERRAND, {"values": {"rounds": "two"}},
        "/values/rounds: 'two' is not of type 'integer'; an integer is like 3"),
    "what the robot reports": (
        changed((("blackboard", "battery"), {"type": "number", "source": "robot", "optional": True})),
        {"values": {"battery": 1.0}},
        "/values/battery: 'battery' is what the robot reports; leave it out, it is received again"),
    "what becomes what the robot reports": (
        changed((("blackboard", "place"), {"type": "string", "source": "robot", "optional": True})), {},
        "/keys: 'place' is what the robot reports, and 'place' was not; drop its value: \"place\": null"),
    "an argument without a value": (
        changed((("blackboard", "speed"), {"type": "number", "source": "argument"})), {},
        "/values: the mission now takes an argument 'speed'; give its value here"),
    "an invariant that does not hold": (
        changed((("invariants",), {"few": {"key": "rounds", "<": 1}})), {},
        "/invariants/few: it is false where the run would continue: rounds < 1; give other values or states"),
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be_is_refused_with_what_is_missing_and_changes_nothing(tmp_path: Path, what: str) -> None:
    now, words, sentence = REFUSED[what]
    there = land()
    path = died(tmp_path / "run.journal", there)
    with read(path) as record:
        seal = record.seal
    with pytest.raises(DefinitionError) as refused:
        migrate(path, now, Map(**words), to=tmp_path / "new.journal")
    assert sentence in [str(fault) for fault in refused.value.faults]
    with read(path) as record:
        assert record.seal == seal
    assert [each.name for each in tmp_path.iterdir()] == ["run.journal"]
    assert continued(path, there, ERRAND).outcome == "canceled"


def test_all_that_is_missing_is_reported_at_once(tmp_path: Path) -> None:
    path = died(tmp_path / "run.journal", land())
    now = changed(((*BODY, "moving", "action"), "turn"), (("blackboard", "place"), None))
    with pytest.raises(DefinitionError) as refused:
        migrate(path, now, Map(states={"wating": None}), to=tmp_path / "new.journal")
    assert [fault.place for fault in refused.value.faults] == ["/states/wating", "/states", "/keys"]


def test_a_run_that_has_ended_or_not_begun_has_nothing_to_continue_with(tmp_path: Path) -> None:
    path, there = tmp_path / "run.journal", land()
    live(path, there, ERRAND, ROBOT, {"someone": ReplyingAnswerer("on")}, Fate(0, what="write"))
    with pytest.raises(UsageError, match="has not begun"):
        migrate(path, ERRAND, Map(), to=tmp_path / "new.journal")
    continued(path, there, ERRAND)
    with pytest.raises(UsageError, match="has ended, canceled"):
        migrate(path, ERRAND, Map(), to=tmp_path / "new.journal")


def test_an_action_whose_goal_is_under_way_must_be_what_it_was_to_the_robot(tmp_path: Path) -> None:
    path = died(tmp_path / "run.journal", land())
    other = ROBOT.model_copy(update={"actions": {**ROBOT.actions, "move": ROBOT.actions["turn"]}})
    with pytest.raises(DefinitionError, match="/actions/move: a goal of it is under way"):
        migrate(path, ERRAND, Map(), to=tmp_path / "new.journal", robot=other)


def test_a_migration_alone_begins_nothing_and_ends_nothing(tmp_path: Path) -> None:
    there, now = land(), changed(((*BODY, "moving", "action"), "turn"))
    path = moved(tmp_path, there, now, states={"moving": "moving"})
    with Record(path) as record:
        (step,) = record.steps()
    assert step.outcome is None and step.moves[0].taken == ()
    started = [each for each in step.effects if isinstance(each, StartGoal | CallService)]
    assert [each.number for each in started] == [1], "what is under way, and nothing else"
    assert [action for action, _ in there.started] == ["move"]


# -- the map ----------------------------------------------------------------------------------------------------------


def test_a_map_is_read_and_its_faults_are_reported_with_their_places(tmp_path: Path) -> None:
    path = tmp_path / "map.json"
    good = '{"$schema": "x", "format": 1, "states": {"a": "b", "c": null}, "keys": {"k": null}, "values": {"n": [1]}}'
    path.write_text(good)
    map_ = load_map(path)
    assert map_.states == {"a": "b", "c": None} and map_.values == {"n": [1]}
    jsonschema.validate({"$schema": "x", **map_.written()}, map_schema())
    path.write_text('{"state": {}, "keys": {"k": 1}, "states": {"A": "b"}}')
    with pytest.raises(DefinitionError) as refused:
        load_map(path)
    assert {fault.place for fault in refused.value.faults} >= {"/state", "/keys/k"}


def test_a_final_that_was_reached_inside_may_have_another_name_and_no_other_end(tmp_path: Path) -> None:
    """The body has moved after 6 s and its head still waits; a period is half a second."""
    moving = {**DOCUMENT["states"]["work"]["parallel"]["body"]["states"]["moving"]}
    moving["transitions"] = [{"on": "succeeded", "to": "there"}]
    there, now = land(), changed((BODY, {"moving": moving, "there": {"final": "succeeded"}}))
    assert continued(moved(tmp_path, there, now, waits=7, states={"moved": "there"}), there, now) == Ended(
        "canceled", "'over' was reached"
    )
    now = changed((BODY, {"moving": moving, "there": {"final": "failed"}}))
    (tmp_path / "again").mkdir()
    with pytest.raises(DefinitionError, match="'there' is a final: a map ends no run"):
        moved(tmp_path / "again", land(), now, waits=7, states={"moved": "there"})
