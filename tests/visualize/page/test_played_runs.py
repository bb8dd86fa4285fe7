# SPDX-License-Identifier: Apache-2.0
"""The page plays a journal as the run was: with pauses, holds, questions, trees, inclusions, and quiet writes."""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.errors import DefinitionError
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import plain
from rai_missions.profile import dump_profile
from tests.laws.drawn import document, happenings
from tests.laws.test_cut_short import NAMED, Written, drawn, private_as, profile, terms_of
from tests.rigs.charts import ScriptedRobot
from tests.rigs.turns import sooner_ended
from tests.visualize.page.reading import data_of, folded
from visualize import picture
from visualize.page import review


def written(mission: Mission, events: Any, path: Path, rng: random.Random) -> dict[int, tuple[Any, Any]]:
    """Write a run down; step → what was active and known after it, a value with its stamp."""
    robot, answers, truth = profile(rng, mission), ScriptedRobot("agent"), {}
    chart = Chart(mission, robot_facts=terms_of(robot), named=NAMED)
    with Journal.create(path, Header(dump(mission), dump_profile(robot))) as journal:
        scribe, happened = Written(chart, journal), iter([None, *events])
        while chart.outcome is None and (happening := next(happened, "over")) != "over":
            event = happening if happening is None else happening(answers)
            step = scribe.step(lambda event=event: chart.start(0.0) if event is None else chart.send(event))
            answers.follow(step)
            board = {name: (plain(entry.value), entry.at) for name, entry in chart.view.board.items()}
            truth[step.seq] = (chart.active, board)
    return truth


@sooner_ended()
def agree(seed: int, folder: Path) -> str:
    """Write a run down, and read it from its page; `same`, or why it was not compared."""
    rng = random.Random(seed)
    made, script = document(rng, wishes=seed % 7 == 0, trees=seed % 5 == 0), happenings(rng)
    try:
        mission, private = drawn(rng, folder, made, is_included=seed % 3 == 0)
    except DefinitionError:
        return "it cannot be included"

    def event(happening: Any) -> Any:
        return lambda answers: private_as(answers.event(*happening), private)

    path = folder / "run.journal"
    truth = written(mission, map(event, script), path, rng)
    data = data_of(review(mission, [path]))
    with read(path) as record:
        rows = list(record.entries())
    assert data["runs"][0]["faults"] == []
    for row, (active, known) in zip(rows, folded(data["runs"][0], data["chart"]["keys"]), strict=True):
        truly_active, board = truth[row.step.seq]
        assert active == truly_active, (seed, row.step)
        assert {name: value for name, (value, _) in known.items()} == {n: v for n, (v, _) in board.items()}, seed
    moves = [move for row in rows for move in row.step.moves]
    assert data["coverage"]["states"] == {n: [c] for n, c in Counter(n for m in moves for n in m.entered).items()}
    assert data["coverage"]["transitions"] == {n: [c] for n, c in Counter(n for m in moves for n in m.taken).items()}
    if (last := truth[rows[-1].step.seq][0]) and rows[-1].step.outcome is None:
        around = {parent for parent in last if set(mission.state(parent).children()) & last}
        shown = picture(mission, (row.step for row in rows)).nodes
        assert {node.name for node in shown if node.ended_here} == last - around, seed
    return "same"


@given(seed=st.integers(0, 2**32))
@settings(max_examples=12)
def test_a_page_plays_a_journal_as_the_run_was(seed: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    agree(seed, tmp_path_factory.mktemp("played"))


@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_pages_play_two_thousand_journals_as_the_runs_were(tmp_path: Path) -> None:
    found = Counter[str]()
    for seed in range(2_000):
        folder = tmp_path / str(seed)
        folder.mkdir()
        found[agree(seed, folder)] += 1
    assert found["same"] > 1_500
