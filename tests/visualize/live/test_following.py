# SPDX-License-Identifier: Apache-2.0
"""A run of another process, followed by its journal: while it is written, after its end, and where it is damaged."""

from __future__ import annotations

import json
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rai_missions.errors import DefinitionError, UsageError
from rai_missions.journal import MIGRATED, Header, Journal
from rai_missions.journal.lock import Lock
from rai_missions.mission.mission import Mission
from tests.visualize.live.stage import Run, Viewer, ask, until
from tests.visualize.live.test_scene import play
from tests.visualize.page.reading import answered, journal_of
from tests.visualize.runs import ROOT, tractor
from visualize.live import JournalFeed, LivePage, PageAddress


@pytest.fixture
def page() -> Iterator[LivePage]:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    made = LivePage(PageAddress(port=0))
    yield made
    made.stop()


def test_a_journal_that_grows_is_followed(tmp_path: Path, page: LivePage) -> None:
    run, path = Run(tractor()), tmp_path / "a.journal"
    with Journal.create(path, Header(json.dumps(tractor().written()))) as journal:
        feed = JournalFeed(path)
        page.start(feed.mission, feed)
        viewer = Viewer(page)
        journal.write(run.start(), since=0.0)
        for act in ("obstacle", "anomaly", "agent", "replan", "pause", "resume", "kill"):
            play(run, act)
            journal.write(run.steps[-1], since=run.chart.at)
        wanted = {name: item for name, item in run.whole.items() if name != "board"}
        until(lambda: viewer.sees(**wanted), f"{viewer.seen} becomes {wanted}")
    assert viewer.sees(outcome="aborted", why="e-stop by x", faults=[])
    assert viewer.seen["board"]["obstacle"] == run.whole["board"]["obstacle"]
    viewer.cut()


def test_a_run_that_continues_in_another_mission_names_its_journal(tmp_path: Path, page: LivePage) -> None:
    run, path = Run(tractor()), tmp_path / "a.journal"
    with Journal.create(path, Header(json.dumps(tractor().written()))) as journal:
        journal.write(run.start(), since=0.0)
        journal.note(MIGRATED, {"journal": "a-migrated.journal", "seal": "0" * 64})
    feed = JournalFeed(path)
    page.start(feed.mission, feed)
    viewer = Viewer(page)
    until(lambda: "a-migrated.journal" in viewer.seen.get("cut", ""), f"{viewer.seen.get('cut')} names it")
    viewer.cut()


def test_goals_that_may_still_move_the_robot_are_seen(tmp_path: Path, page: LivePage) -> None:
    run, path = Run(tractor()), tmp_path / "a.journal"
    loose = [{"number": 3, "action": "drive_alleys", "owner": "driving", "reason": "refused"}]
    with Journal.create(path, Header(json.dumps(tractor().written()))) as journal:
        journal.write(run.start(), since=0.0)
        journal.note("the robot may still move", {"open_goals": loose})
    feed = JournalFeed(path)
    page.start(feed.mission, feed)
    viewer = Viewer(page)
    until(lambda: viewer.sees(open_goals=loose), "the goal is named")
    viewer.cut()


def test_values_that_travelled_with_a_row_are_seen(tmp_path: Path, page: LivePage) -> None:
    run, path = Run(tractor()), tmp_path / "a.journal"
    with Journal.create(path, Header(json.dumps(tractor().written()), arguments={"alleys": 3})) as journal:
        journal.write(run.start(), since=0.0, quiet=[("battery", 0.4, 1.5)])
    feed = JournalFeed(path)
    page.start(feed.mission, feed)
    viewer = Viewer(page)
    until(lambda: viewer.seen.get("board", {}).get("battery") == [0.4, 1.5], "the value is seen")
    assert viewer.seen["board"]["alleys"][0] == 3
    viewer.cut()


def test_a_run_that_has_ended_is_shown_as_it_ended_and_takes_no_orders(tmp_path: Path, page: LivePage) -> None:
    path = journal_of(tmp_path / "a.journal", tractor(), answered(tractor()))
    feed = JournalFeed(path)
    page.start(feed.mission, feed)
    viewer = Viewer(page)
    until(lambda: viewer.sees(mode="aborted", outcome="aborted"), f"{viewer.seen}")
    assert ask(page, "POST", "/orders", b'{"command": "e_stop"}')[0] == 403
    viewer.cut()


def test_a_chain_that_is_broken_is_reported_and_the_rest_is_shown(tmp_path: Path, page: LivePage) -> None:
    path = journal_of(tmp_path / "a.journal", tractor(), answered(tractor()))
    database = sqlite3.connect(path)
    with database:
        database.execute("UPDATE rows SET content = replace(content, '0.5', '0.4') WHERE number = 2")
        database.execute("UPDATE rows SET content = 'nonsense' WHERE number = 3")
    database.close()
    feed = JournalFeed(path)
    page.start(feed.mission, feed)
    viewer = Viewer(page)
    until(lambda: viewer.sees(outcome="aborted"), f"{viewer.seen}")
    faults = "\n".join(viewer.seen["faults"])
    assert "row 2: it does not follow from the row before; the journal was altered" in faults
    assert "row 3" in faults
    viewer.cut()


def test_what_is_no_journal_or_has_no_mission_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="there is no such file"):
        JournalFeed(tmp_path / "no.journal")
    (tmp_path / "text").write_text("my notes")
    with pytest.raises(DefinitionError, match="no journal"):
        JournalFeed(tmp_path / "text")
    Journal.create(tmp_path / "a.journal", Header("")).close()
    with pytest.raises(DefinitionError, match="behaviours in Python"):
        JournalFeed(tmp_path / "a.journal")
    Journal.create(tmp_path / "b.journal", Header('{"name": 1}')).close()
    with pytest.raises(DefinitionError, match="row 0: no mission can be read here"):
        JournalFeed(tmp_path / "b.journal")


def test_a_journal_that_disappears_is_reported(tmp_path: Path, page: LivePage) -> None:
    path = journal_of(tmp_path / "a.journal", tractor(), answered(tractor())[:3])
    feed = JournalFeed(path)
    page.start(Mission.model_validate(feed.mission.written()), feed)
    viewer = Viewer(page)
    until(lambda: viewer.sees(mode="running"), f"{viewer.seen}")
    path.unlink()
    until(lambda: "there is no such file" in "".join(viewer.seen["faults"]), "it is reported")
    viewer.cut()


WRITES = """
import json, sys
from rai_missions.journal import Header, Journal
from tests.visualize.live.stage import Run
from tests.visualize.runs import ROOT, tractor
journal = Journal.create(sys.argv[1], Header(json.dumps(tractor().written())))
journal.write(Run(tractor()).start(), since=0.0)
print("written", flush=True)
sys.stdin.read()
"""


def test_a_run_whose_process_is_dead_was_cut_short(tmp_path: Path, page: LivePage) -> None:
    path = tmp_path / "a.journal"
    words = [sys.executable, "-c", WRITES, str(path)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=ROOT) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == b"written\n"
        feed = JournalFeed(path)
        page.start(feed.mission, feed)
        viewer = Viewer(page)
        until(lambda: viewer.sees(mode="running", cut=""), f"{viewer.seen}")
        writer.kill()
    until(lambda: "no process writes" in viewer.seen["cut"], f"{viewer.seen}")
    assert feed.now() == feed.now() == feed._scene.at
    late = Viewer(page)
    until(lambda: "no process writes" in late.seen.get("cut", ""), f"{late.seen}")
    viewer.cut()
    late.cut()


def test_a_run_that_has_ended_was_not_cut_short(tmp_path: Path) -> None:
    path = journal_of(tmp_path / "a.journal", tractor(), answered(tractor()))
    feed = JournalFeed(path)
    assert feed._read()
    assert (feed._scene.outcome, feed._scene.cut) == ("aborted", "")


def test_a_journal_that_is_written_again_continues(tmp_path: Path) -> None:
    path = journal_of(tmp_path / "a.journal", tractor(), answered(tractor())[:3])
    feed = JournalFeed(path)
    assert feed._read()
    assert feed._scene.cut
    lock = Lock(path, new=False)
    assert feed._read()
    assert feed._scene.cut == ""
    lock.release()
