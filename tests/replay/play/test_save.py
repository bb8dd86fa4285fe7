# SPDX-License-Identifier: Apache-2.0
"""A play as a journal: it is replayed like a run, and taken for none."""

from __future__ import annotations

import random
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.errors import DefinitionError, UsageError
from rai_missions.event import Tick
from rai_missions.journal import Header, Journal, Record, copied, read, verify
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.replay.migrate import Map, migrate
from rai_missions.replay.open_run import open_run
from rai_missions.replay.play import Play, save
from rai_missions.replay.replay import replay
from tests.strategies import missions

ROOT = Path(__file__).parents[3]


def walked(mission: Mission, seed: int, clicks: int = 10) -> Play:
    """A play that goes where chance leads."""
    chance, play = random.Random(seed), Play(mission)
    for _ in range(clicks):
        choices = play.choices()
        begins = [choice for choice in choices if choice.kind == "start"]
        if not choices:
            break
        play.do((begins or [chance.choice(choices)])[0].name)
    return play


@settings(suppress_health_check=list(HealthCheck), max_examples=3)
@given(mission=missions(), seed=st.integers(0, 10_000))
def test_a_saved_play_is_replayed_step_by_step(
    mission: Mission, seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    play, path = walked(mission, seed), tmp_path_factory.mktemp("play") / "p.journal"
    save(play, path)
    found = replay(path)
    assert found.difference == ""
    assert found.outcome == play.chart.outcome
    with read(path) as record:
        loud = [done.step for click in play.path for done in click.done if not done.is_quiet]
        steps = list(record.steps())
        assert steps[: len(loud)] == loud
        assert [step.event for step in steps[len(loud) :]] in ([], [Tick(play.chart.at)])


@pytest.fixture
def played(tmp_path: Path) -> Path:
    play = Play(load(ROOT / "missions/tractor/mission.json"))
    for name in ("readings", "start", "event anomaly", "time"):
        play.do(name)
    save(play, tmp_path / "p.journal")
    assert [path.name for path in tmp_path.iterdir()] == ["p.journal"]
    return tmp_path / "p.journal"


def test_row_0_states_that_it_was_played_and_a_run_s_does_not(played: Path) -> None:
    with read(played) as record:
        assert record.header.played
        _, _, content, _ = next(record.raw())
        assert '"played":true' in content
    with Journal.create(played.with_name("run.journal"), Header("{}")) as journal, Record(journal.path) as record:
        assert not record.header.played
        assert "played" not in next(record.raw())[2]


def test_who_takes_the_mark_away_breaks_the_chain(played: Path) -> None:
    with closing(sqlite3.connect(played)) as database, database:
        database.execute("UPDATE rows SET content = replace(content, '\"played\":true', '\"played\":false')")
    assert [fault.place for fault in verify(played)] == ["row 0"]


def test_a_copy_keeps_the_mark(played: Path, tmp_path: Path) -> None:
    with read(played) as record:
        copied(tmp_path / "copy.journal", [*record.raw(), *record.pictures()], "here")
    with read(tmp_path / "copy.journal") as record:
        assert record.header.played


def test_a_play_is_neither_resumed_nor_migrated(played: Path) -> None:
    with pytest.raises(UsageError, match="was played by a person"):
        open_run(played)
    with pytest.raises(UsageError, match="was played by a person"):
        migrate(played, load(ROOT / "missions/tractor/mission.json"), Map(), to=played.with_name("to.journal"))


def test_a_journal_of_that_name_is_moved_aside_and_another_file_is_left(played: Path) -> None:
    play = walked(load(ROOT / "missions/tractor/mission.json"), 1)
    aside = save(play, played)
    assert aside == played.with_name("p.1.journal")
    assert save(play, played, replaces=True) is None
    other = played.with_name("notes [1].txt")
    other.write_text("mine", encoding="utf-8")
    with pytest.raises(DefinitionError):
        save(play, other)
    assert other.read_text(encoding="utf-8") == "mine"
    assert sorted(path.name for path in played.parent.iterdir()) == ["notes [1].txt", "p.1.journal", "p.journal"]


def test_nothing_is_saved_of_a_play_that_has_not_begun(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="nothing has been played yet"):
        save(Play(load(ROOT / "missions/tractor/mission.json")), tmp_path / "p.journal")
    assert list(tmp_path.iterdir()) == []


def test_facts_that_enabled_nothing_are_in_the_journal_too(tmp_path: Path) -> None:
    play = Play(load(ROOT / "missions/tractor/mission.json"))
    play.do("readings")
    save(play, tmp_path / "p.journal")
    with read(tmp_path / "p.journal") as record:
        (row,) = record.entries()
        assert "battery" in {key for key, _, _ in row.before}
