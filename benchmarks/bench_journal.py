# SPDX-License-Identifier: Apache-2.0
"""How many steps a journal takes a second, and how long one waits for it: `python -m benchmarks.bench_journal`.

Each step is durable against a killed process before the next is made. The peer is the plainest thing that could be
done with SQLite: one row, one commit, the step as `pickle` makes it, no hash, no one kept out.
"""

from __future__ import annotations

import pickle
import sqlite3
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.figures import figure
from rai_missions.engine.decision import Evidence, Offer, Question
from rai_missions.engine.step import Ask, CancelGoal, Handover, Move, Step
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.journal import Header, Journal, read, verify

STEPS = 20_000
WANTED_PER_S = 5_000

TICK = Step(1, 12.3, Event("tick", 12.3, {}, "tick"), wake_at=12.8)
MOVE = Step(
    1,
    12.345,
    Event("anomaly", 12.345, {"message": "STOPPED"}),
    moves=(Move(("/states/working/states/driving/transitions/0",), ("driving", "working"), ("assessing",), "anomaly"),),
    guards=(("/transitions/0", False), ("/states/driving/transitions/0", True)),
    writes=(("signals", 0),),
    effects=(CancelGoal(3, "drive_alleys"), Handover("agent")),
    wake_at=12.845,
)
QUIET = [("pose", {"x": 12.5, "y": -3.25, "z": 0.0, "yaw": 1.57, "frame": "map"}, 12.3), ("battery", 0.83, 12.1)]


def asked(number: int) -> Step:
    """A question with a fresh picture of 640 × 480."""
    picture = Image(f"camera@{number}", 640, 480, "rgb8", number.to_bytes(4, "big") * (640 * 480 * 3 // 4))
    options = (Offer("replan", "take the next alley"), Offer("abort", "stop here"))
    question = Question(number, "assessing", "agent", "What now?", options, (Evidence("camera", picture, 0.1, True),))
    return MOVE._replace(effects=(Ask(question),))


def times(write: Callable[[Step], object], make: Callable[[int], Step], count: int) -> list[float]:
    spent = []
    for number in range(1, count + 1):
        step = make(number)
        begin = time.perf_counter()
        write(step)
        spent.append(time.perf_counter() - begin)
    return sorted(spent)


def print_times(name: str, spent: list[float]) -> None:
    each = [spent[int(len(spent) * part)] for part in (0.5, 0.99, 0.999)]
    rest = "".join(f"{1e6 * took:>10.0f}" for took in (*each, spent[-1]))
    print(f"{name:<34}{1 / statistics.fmean(spent):>10,.0f}{rest}")
    figure(f"journal, wall: {name}", 1 / statistics.fmean(spent), "steps/s", larger_is_better=True)


def journaled(folder: Path) -> Path:
    path = folder / "steps"
    kinds: list[tuple[str, Callable[[int], Step], int]] = [
        ("a tick", lambda number: TICK._replace(seq=number), STEPS),
        ("a transition, two quiet writes", lambda number: MOVE._replace(seq=number), STEPS),
        ("a question with a picture", lambda number: asked(number)._replace(seq=number), 200),
    ]
    for name, make, count in kinds:
        path = folder / name.replace(" ", "_")
        with Journal.create(path, Header("{}")) as journal:
            print_times(name, times(lambda step, to=journal: to.write(step, since=12.3, quiet=QUIET), make, count))  # type: ignore[misc]
    return folder / "a_transition,_two_quiet_writes"


def plainest(folder: Path) -> None:
    database = sqlite3.connect(folder / "plainest", isolation_level=None)
    for pragma in ("journal_mode=WAL", "synchronous=NORMAL"):
        database.execute(f"PRAGMA {pragma}").fetchall()
    database.execute("CREATE TABLE steps (number INTEGER PRIMARY KEY, step BLOB)")
    insert = "INSERT INTO steps VALUES (?, ?)"
    spent = times(
        lambda step: database.execute(insert, (step.seq, pickle.dumps((step, QUIET)))),
        lambda number: MOVE._replace(seq=number),
        STEPS,
    )
    database.close()
    print_times("plainest SQLite: pickled, no hash", spent)


def main() -> None:
    print(f"{'':<34}{'steps/s':>10}{'median µs':>10}{'p99':>10}{'p99.9':>10}{'longest':>10}")
    with tempfile.TemporaryDirectory(dir=".") as name:
        path = journaled(Path(name))
        plainest(Path(name))
        for what, do in (("read, chain checked", lambda: read(path).close()), ("verified whole", lambda: verify(path))):
            begin = time.perf_counter()
            do()
            print(f"{what}: {STEPS / (time.perf_counter() - begin):,.0f} steps/s")
    print(f"wanted: {WANTED_PER_S:,} steps/s")


if __name__ == "__main__":
    main()
