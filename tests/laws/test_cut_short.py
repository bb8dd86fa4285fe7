# SPDX-License-Identifier: Apache-2.0
"""A run that is cut short anywhere is where it was: in another process, from its journal, under other names."""

from __future__ import annotations

import json
import random
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rai_missions import load
from rai_missions.engine import Chart
from rai_missions.engine.semantics import macrostep as microsteps
from rai_missions.engine.semantics import timing as instants
from rai_missions.engine.snapshot_json import packed, unpacked
from rai_missions.engine.step import Step
from rai_missions.errors import DefinitionError
from rai_missions.event import Event, Tick
from rai_missions.journal import Header, Journal, read
from rai_missions.journal.json_values import from_json, to_json
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, dump_profile
from rai_missions.profile import robot_facts as terms_of
from rai_missions.replay.migrate import migrate
from rai_missions.replay.resume import resumption
from tests.laws.drawn import EVENTS, KEYS, DrawnEvent, document, happenings, is_far, robot_facts
from tests.laws.test_included import including
from tests.laws.test_instants import AFTER_S, PASSING
from tests.replay.test_renamed import TWO, otherwise
from tests.rigs.charts import ScriptedRobot
from tests.rigs.journals import assert_whole

Json = dict[str, Any]
NAMED = {"is_far": is_far}
TRIGGER = "std_srvs/srv/Trigger"


def is_far_by_new_names(known: Mapping[str, Any], margin: int) -> bool | None:
    return is_far({name.removesuffix(TWO): known[name] for name in known}, margin)


@pytest.fixture(autouse=True)
def _ended_sooner(monkeypatch: pytest.MonkeyPatch) -> None:
    """What goes round for ever is found sooner."""
    for module in (microsteps, instants):
        monkeypatch.setattr(module, "MOST_MICROSTEPS", 100)


def profile(rng: random.Random, mission: Mission, suffix: str = "") -> Robot:
    """A robot on the terms that a number draws, for a mission whose keys have a suffix."""
    facts = robot_facts(rng)

    def guard(given: Any) -> Json:
        written = json.dumps(given.written())
        made: Json = json.loads(written.replace('"count"', f'"count{suffix}"').replace('"fact"', f'"fact{suffix}"'))
        return made

    def action(name: str) -> Json:
        uses = {"uses": sorted(facts.uses.get(name) or ())}
        if name in facts.succeeded:
            ends = {"succeeded": guard(facts.succeeded[name]), "failed": guard(facts.failed[name])}
            return {"start": f"/{name}", "cancel": f"/{name}_stop", **ends, **uses}
        return {"action": f"/{name}", "type": "x/action/X", "keep": name in facts.keep, **uses}

    read_from = {"topic": "/fact", "type": "std_msgs/msg/String", "json": True}
    return Robot.model_validate(
        {
            "name": "drawn",
            "actions": {name: action(name) for name in ("drive", "turn", "composed")},
            "blackboard": {name: read_from for name, key in mission.blackboard.items() if key.source == "robot"},
            "services": {"horn": {"service": "/horn", "type": TRIGGER}},
            "topics": {"lamp": {"topic": "/lamp", "type": "std_msgs/msg/String"}},
            "events": {name: {"posted": True} for name in mission.events},
            "control": {who: f"/to_{who}" for who in ("agent", "autonomy", "operator", "nobody")},
        }
    )


def drawn(rng: random.Random, folder: Path, made: Json, *, is_included: bool) -> tuple[Mission, frozenset[str]]:
    """The mission that was drawn, or one that includes it; and what is private in that one."""
    if not is_included:
        return Mission.model_validate(made), frozenset()
    made.pop("on_cancel", None)  # that of the outermost mission counts
    outer = including(rng)
    for name, each in (("inner", made), ("outer", outer)):
        (folder / f"{name}.json").write_text(json.dumps({"format": 1, **each}))
    return load(folder / "outer.json"), frozenset({*KEYS, *EVENTS} - outer["states"]["part"]["with"].keys())


def private_as(event: Event, private: frozenset[str]) -> Event:
    """An event as the mission that includes another knows it; of what is private in that one."""
    is_private = event.kind in ("event", "write") and event.name in private
    return event._replace(name=f"part/{event.name}") if is_private else event


def plain(value: Any) -> Any:
    """A value with its old names, in an order of its own."""
    if isinstance(value, Mapping):
        return {repr(plain(key)): plain(value[key]) for key in sorted(value, key=repr)}
    if isinstance(value, set | frozenset):
        return sorted(map(plain, value), key=repr)
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return type(value).__name__, plain(value._asdict())
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return value.replace(TWO, "") if isinstance(value, str) else value


def remembered(chart: Chart) -> Any:
    return plain({name: value for name, value in chart.snapshot().items() if name not in PASSING})


def through_json(chart: Chart) -> Json:
    """What a chart remembers, written and read."""
    written = json.loads(json.dumps(to_json(packed(dict(chart.snapshot())))))
    found: Json = unpacked(from_json(written, lambda ref, digest: b""))
    return found


class Written:
    """A chart whose steps are written as a run writes them: what only wrote the blackboard travels with the next."""

    def __init__(self, chart: Chart, journal: Journal) -> None:
        self._chart, self._journal = chart, journal
        self._carried: dict[str, tuple[str, Any, float]] = {}

    def step(self, make: Callable[[], Step]) -> Step:
        since, step = self._chart.at, make()
        if self._chart.quiet and step.event.kind in ("write", "tick"):
            self._carried |= {key: (key, value, step.stamp_of(key)) for key, value in step.writes}
        else:
            self._journal.write(step, since=since, quiet=tuple(self._carried.values()))
            self._carried.clear()
        return step

    def flush(self) -> None:
        """As a run does once it has written nothing for a second."""
        step = self._chart.send(Tick(self._chart.at))
        self._journal.write(step, since=self._chart.at, quiet=tuple(self._carried.values()))


def agree(folder: Path, seed: int, *, is_included: bool = False, wishes: bool = False) -> str:
    """Cut a run short; what continues in any way must do what the run would have done, step by step.

    Args:
        folder: For what is written.
        seed: The seed of the mission and of what happens.
        is_included: The mission is a part of another.
        wishes: It reads requests.

    Returns:
        `same`, or why there was nothing to compare.
    """
    rng = random.Random(seed)
    made, script, state = document(rng, wishes=wishes), happenings(rng, wishes=wishes), rng.getstate()
    try:
        mission, private = drawn(rng, folder, made, is_included=is_included)
    except DefinitionError:
        return "it cannot be included"
    now, map_ = otherwise(mission)
    rng.setstate(state)
    robot = profile(rng, mission)
    rng.setstate(state)
    new_robot, facts = profile(rng, now, TWO), terms_of(robot)
    assert Mission.model_validate_json(dump(mission)) == mission

    def happened(happening: DrawnEvent) -> Event:
        return private_as(answers.event(*happening), private)

    cut = rng.randint(0, len(script))
    whole, answers = Chart(mission, robot_facts=facts, named=NAMED), ScriptedRobot("agent")
    path, new = folder / "run.journal", folder / "new.journal"
    with Journal.create(path, Header(dump(mission), dump_profile(robot))) as journal:
        written = Written(whole, journal)
        answers.follow(written.step(lambda: whole.start(0.0)))
        for happening in script[:cut]:
            if whole.outcome is None:
                event = happened(happening)
                answers.follow(written.step(lambda event=event: whole.send(event)))
        written.flush()
    assert_whole(path)
    if whole.outcome is not None:
        return "it had ended"
    with read(path) as record:
        resumed = resumption(record, mission, named=NAMED).chart
    assert remembered(resumed) == remembered(whole)
    by_new_names = {"is_far": is_far_by_new_names}
    assert migrate(path, now, map_, to=new, robot=new_robot, named=by_new_names).notes == ()
    assert_whole(new)
    with read(new) as record:
        migrated = resumption(record, now, named=by_new_names).chart
    whole.settle_holds()
    assert remembered(migrated) == remembered(whole)
    for happening in [*script[cut:], DrawnEvent(("tick",), script[-1].at + AFTER_S)]:
        other = Chart.restore(mission, through_json(whole), robot_facts=facts, named=NAMED)
        event = happened(happening)
        step = answers.follow(whole.send(event))
        is_known = event.kind == "write" or (event.kind == "event" and event.name in mission.events)
        in_new_names = event._replace(name=event.name + TWO) if is_known else event
        again = other.send(event), migrated.send(in_new_names)
        if whole.cause == "cycle":  # the states of one are named in the order of the alphabet
            return "it went round for ever"
        assert done(again[0]) == done(again[1]) == done(step)
        assert remembered(other) == remembered(migrated) == remembered(whole)
    return "same"


def done(step: Step) -> Any:
    """What a step did, but for the instant at which to wake: a chart may wake too early, never too late."""
    without: Any = {"seq": 0, "event": Event("", 0.0), "wake_at": None}
    return plain(step._replace(**without))


@pytest.mark.parametrize("is_included", [False, True])
@given(seed=st.integers(0, 2**32))
@settings(max_examples=8)
def test_a_run_that_is_cut_short_is_where_it_was_and_does_what_it_would_have_done(
    seed: int, tmp_path_factory: pytest.TempPathFactory, *, is_included: bool
) -> None:
    assume(agree(tmp_path_factory.mktemp("cut"), seed, is_included=is_included) == "same")


@pytest.mark.drill
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("is_included", [False, True])
def test_three_thousand_runs_that_are_cut_short_do_what_they_would_have_done(
    tmp_path: Path, *, is_included: bool
) -> None:
    found = Counter[str]()
    for seed in range(3_000):
        folder = tmp_path / str(seed)
        folder.mkdir()
        found[agree(folder, seed, is_included=is_included)] += 1
    assert found["same"] > 1_500


def test_a_predicate_that_no_guard_names_makes_no_difference() -> None:
    """So a run with a file of them is done again from its journal, which asks for those alone that are named."""
    for seed in range(30):
        rng = random.Random(seed)
        mission, script = Mission.model_validate(document(rng)), happenings(rng)
        asked = NAMED if "is_far" in dump(mission) else {}
        charts = [Chart(mission, named=given) for given in (asked, NAMED | {"is_odd": is_far})]
        answers = ScriptedRobot("agent")
        answers.follow(charts[0].start(0.0))
        charts[1].start(0.0)
        for happening in script:
            event = answers.event(*happening)
            one, other = (chart.send(event) for chart in charts)
            assert answers.follow(one) == other, seed


IS_OK = Event("ok", 1.0, {"value": True}, "write")


@pytest.mark.parametrize(("event", "outcome"), [(Tick(3.0), "failed"), (IS_OK, "canceled")])
def test_a_region_whose_final_has_settled_is_written_down(event: Event, outcome: str) -> None:
    """What the facts become later must not decide it again in a run that is resumed."""
    done = {"final": "succeeded", "requires": {"key": "ok", "==": True}, "settle_s": 2}
    waits = {"initial": "wait", "states": {"wait": {"transitions": [{"on": "go", "to": "went"}]},
                                           "went": {"final": "succeeded"}}}  # fmt: skip
    ends = [{"on": "succeeded", "to": "good"}, {"on": "unverified", "to": "bad"}]
    mission = Mission.model_validate({
        "name": "settling", "initial": "work", "events": ["go"],
        "blackboard": {"ok": {"type": "boolean", "source": "robot", "optional": True}},
        "states": {"work": {"parallel": {"one": done, "other": waits}, "transitions": ends},
                   "good": {"final": "canceled"}, "bad": {"final": "failed"}},
    })  # fmt: skip
    chart = Chart(mission)
    chart.start(0.0)
    chart.send(event)
    assert not chart.quiet
    chart.send(Event("ok", 4.0, {"value": outcome == "failed"}, "write"))
    chart.send(Event("go", 5.0))
    assert chart.outcome == outcome
