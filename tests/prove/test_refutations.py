# SPDX-License-Identifier: Apache-2.0
"""What is reported of a refutation's journal is what is in it, for missions with trees, lists, regions and time."""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.semantics import macrostep, timing
from rai_missions.journal import Header, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.prove import TraceStep, prove, record
from rai_missions.replay.rebuild import JournalReplayer
from rai_missions.replay.replay import replay
from tests.laws.drawn import document
from tests.prove.walks import walkable


@pytest.fixture(autouse=True)
def _ended_sooner(monkeypatch: pytest.MonkeyPatch) -> None:
    """What goes round for ever is found sooner, though after more rounds than the explorer goes."""
    for module in (macrostep, timing):
        monkeypatch.setattr(module, "MOST_MICROSTEPS", 1_000)


def drawn(seed: int) -> list[Mission]:
    """One with every kind of guard, state and effect, and a small one that comes round."""
    made = document(random.Random(seed), trees=seed % 3 == 0)
    return [Mission.model_validate(each) for each in (made, walkable(seed))]


def last_chart(path: Path, mission: Mission) -> Chart:
    """The chart at the end of a journal."""
    with read(path) as written:
        replayer = JournalReplayer(written, mission)
        for row in written.entries():
            replayer.again(row)
    return replayer.chart


def shows(chart: Chart, scene: TraceStep) -> bool:
    """Whether a run has come to what a scene ends with: these states, this end, a circle or a broken invariant."""
    if chart.outcome is None or scene.outcome is None:
        return (chart.outcome, chart.active) == (scene.outcome, scene.active)
    broken = f"invariant '{chart.false_invariant}'" if chart.cause == "invariant" else ""
    circle = "a cycle without end: " if chart.cause == "cycle" else ""
    return chart.outcome == scene.outcome and scene.why.startswith(circle or broken or chart.why)


def found(seeds: range, folder: Path) -> Counter[str]:
    """Each refutation of these missions, written, and held against its journal."""
    count = Counter[str]()
    for number, mission in [(seed, mission) for seed in seeds for mission in drawn(seed)]:
        for claim, run in prove(mission, most=150, work=2_000).ways.items():
            path = folder / f"{mission.name} {number} {claim}.journal"
            is_shown = record(path, Header(dump(mission)), mission, run)
            assert replay(path).holds, path.name
            assert is_shown is shows(last_chart(path, mission), run[-1]), path.name
            count["shown" if is_shown else "of another order of timers"] += 1
    return count


def test_of_two_shortest_runs_the_one_in_which_reports_come_before_time_is_printed(tmp_path: Path) -> None:
    """The call can succeed as long as the timer runs, and no longer. Regions that look at each other are one part."""
    left = {
        "call": "horn",
        "timeout_s": 1,
        "transitions": [
            {"on": "succeeded", "do": [{"set": "n", "value": 1}]},
            {"on": ["failed", "rejected", "timed_out"], "to": "over"},
        ],
    }
    right = {"transitions": [{"after_s": 1, "when": {"in": "x0"}, "do": [{"set": "m", "value": 1}]}]}
    regions = {"y": {"initial": "y0", "states": {"y0": right}}, "x": {"initial": "x0", "states": {"x0": left}}}
    both = {"all": [{"key": "n", "==": 1}, {"key": "m", "==": 1}]}
    mission = Mission.model_validate({
        "name": "both", "initial": "a", "blackboard": {name: {"type": "integer", "initial": 0} for name in "nm"},
        "states": {"a": {"parallel": regions}, "over": {"final": "aborted"}}, "invariants": {"few": {"not": both}},
    })  # fmt: skip
    run = prove(mission).ways["invariants"]
    assert run[1].words == "the call of 'x0': succeeded"
    assert record(tmp_path / "both.journal", Header(dump(mission)), mission, run)


def test_what_is_reported_of_a_refutation_s_journal_is_what_is_in_it(tmp_path: Path) -> None:
    count = found(range(7, 14), tmp_path)
    assert count["shown"] > 4 * count["of another order of timers"]


@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_what_is_reported_of_many_refutations_journals_is_what_is_in_them(tmp_path: Path) -> None:
    count = found(range(14, 750), tmp_path)
    assert count["shown"] > 4 * count["of another order of timers"]
