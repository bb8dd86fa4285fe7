# SPDX-License-Identifier: Apache-2.0
"""Many journals in a process: what each costs, and a folder of runs that is killed and continued in part."""

from __future__ import annotations

import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import pytest

from rai_missions.event import Event
from rai_missions.journal import Journal, read, verify
from rai_missions.mission.mission import Mission
from rai_missions.replay.resume import resumption
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner

MOST_KB = 150
"""What an open journal may take after 300 rows: about 90 were measured, and 215 with the memory SQLite takes itself."""
MISSION = Mission.model_validate(
    {
        "name": "many", "initial": "work", "events": ["go", "end"],
        "states": {
            "work": {"transitions": [{"on": "go", "to": "work"}, {"on": "end", "to": "over"}]},
            "over": {"final": "succeeded"},
        },
    }
)  # fmt: skip
FLEET = """
import random, sys, threading
from pathlib import Path
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner
from tests.journal.test_many import MISSION

folder, count = Path(sys.argv[1]), int(sys.argv[2])
lock, runners = threading.Lock(), []

def notified(number):
    def on_step(step):
        with lock:
            print(number, step.seq, flush=True)
    return RunObserver(on_step)

for number in range(count):
    journal = Journal.create(folder / str(number), Header(dump(MISSION)))
    runners.append(Runner(MISSION, journal=journal, observer=notified(number)))
    threading.Thread(target=runners[-1].run, daemon=True).start()
chance = random.Random(1)
while True:
    runner = chance.choice(runners)
    if runner.view.mode == "running":
        runner.post(Event("go", runner.view.now()))
"""


def killed_fleet(folder: Path, count: int, steps: int) -> dict[int, int]:
    """Kill a process in which so many missions have made so many steps; the last step of each that was reported."""
    reported: dict[int, int] = {}
    arguments = [sys.executable, "-c", FLEET, str(folder), str(count)]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[2]) as process:
        assert process.stdout is not None
        for made, line in enumerate(process.stdout):
            number, seq = map(int, line.split())
            reported[number] = seq
            if made >= steps and len(reported) == count:
                break
        process.kill()
        rest, _ = process.communicate()
    for line in rest.split("\n")[:-1]:
        number, seq = map(int, line.split())
        reported[number] = seq
    return reported


def check_fleet(folder: Path, count: int, steps: int) -> None:
    reported = killed_fleet(folder, count, steps)
    assert sorted(reported) == list(range(count))
    for number, seq in reported.items():
        with read(folder / str(number)) as record:
            made = [step.seq for step in record.steps()]
        assert made == list(range(1, len(made) + 1)) and len(made) >= seq, f"{number}: {len(made)} of {seq} steps"
        assert verify(folder / str(number)) == ()
    share = range(0, count, 4)
    before = {number: (folder / str(number)).read_bytes() for number in range(count) if number not in share}
    continued, threads, ends = [], [], {}

    def run(number: int, runner: Runner) -> None:
        ends[number] = runner.run().outcome

    for number in share:
        path, begun = folder / str(number), threading.Event()
        with read(path) as record:
            begin, seal = resumption(record, MISSION), record.seal
        journal = Journal.open(path, seal=seal)
        runner = Runner(MISSION, journal=journal, begin=begin, observer=RunObserver(lambda _, it=begun: it.set()))
        threads.append(threading.Thread(target=run, args=(number, runner)))
        threads[-1].start()
        continued.append((runner, journal, begun))
    for runner, _, begun in continued:
        runner.post(Event("go", runner.view.now()))
        assert begun.wait(60)
        runner.post(Event("end", runner.view.now()))
    for thread, (_, journal, _) in zip(threads, continued, strict=True):
        thread.join()
        journal.close()
    assert ends == dict.fromkeys(share, "succeeded")
    for number in share:
        assert verify(folder / str(number)) == ()
        with read(folder / str(number)) as record:
            assert [step.event.name for step in record.steps()][-2:] == ["go", "end"]
            assert len(list(record.steps())) >= reported[number] + 2
    assert before == {number: (folder / str(number)).read_bytes() for number in before}, "the others are as they were"


def test_a_folder_of_runs_that_was_killed_is_continued_in_part(tmp_path: Path) -> None:
    check_fleet(tmp_path, 12, 200)


@pytest.mark.drill
def test_a_folder_of_a_thousand_runs_that_was_killed_is_continued_in_part(tmp_path: Path) -> None:
    check_fleet(tmp_path, 1000, 20_000)


def program(text: str, folder: Path) -> str:
    arguments = [sys.executable, "-c", textwrap.dedent(text), str(folder)]
    return subprocess.run(arguments, capture_output=True, text=True, check=True).stdout


def test_an_open_journal_does_not_grow_with_its_rows(tmp_path: Path) -> None:
    printed = program(
        """
        import os, sys
        from rai_missions.engine.step import Step
        from rai_missions.event import Event
        from rai_missions.journal import Header, Journal

        def resident_kb():
            with open("/proc/self/statm") as file:
                return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024

        def written(number):
            journal = Journal.create(f"{sys.argv[1]}/{number}", Header("{}"))
            for seq in range(1, 301):
                journal.write(Step(seq, float(seq), Event("anomaly", float(seq), {"text": "x" * 200})), since=0.0)
            return journal

        first = [written(number) for number in range(5)]
        before = resident_kb()
        others = [written(number) for number in range(5, 35)]
        print((resident_kb() - before) / len(others))
        """,
        tmp_path,
    )
    assert float(printed) < MOST_KB


def test_a_process_that_may_open_no_more_files_reports_the_cure(tmp_path: Path) -> None:
    printed = program(
        """
        import resource, sys
        from rai_missions.errors import UsageError
        from rai_missions.journal import Header, Journal

        resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
        journals = []
        try:
            for number in range(64):
                journals.append(Journal.create(f"{sys.argv[1]}/{number}", Header("{}")))
        except UsageError as fault:
            print(len(journals) > 32, str(fault).partition(": ")[2])
        """,
        tmp_path,
    )
    assert printed == "True this process may open 64 files, and a journal takes one to three; raise `ulimit -n`\n"
