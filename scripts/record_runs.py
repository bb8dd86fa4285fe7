# SPDX-License-Identifier: Apache-2.0
"""Records the runs of tests/data/runs again, which hold what the engine makes of events.

`python scripts/record_runs.py` records all of them, `python scripts/record_runs.py tractor trees/03` those whose names
begin so.

Rule: record again only where a run is meant to be another; what no change should alter, no change records again.
"""

from __future__ import annotations

import logging
import sqlite3
import sys
from contextlib import closing
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from rai_missions.replay.replay import replay  # noqa: E402
from tests.recorded.generated import generated  # noqa: E402
from tests.recorded.shipped import shipped  # noqa: E402
from tests.recorded.small import small  # noqa: E402

FOLDER = ROOT / "tests/data/runs"
PAGE_BYTES = 512


def main(beginnings: tuple[str, ...]) -> None:
    """Record the runs whose names begin so, in place of those that are there."""
    logging.disable(logging.CRITICAL)  # runs are killed here, and answerers fail
    for path in FOLDER.rglob("*.journal"):
        if path.relative_to(FOLDER).as_posix().startswith(beginnings):
            path.unlink()
    for runs in (small, generated, shipped):
        for name, record in runs():
            if not name.startswith(beginnings):
                continue
            path = FOLDER / f"{name}.journal"
            path.parent.mkdir(parents=True, exist_ok=True)
            record(path)
            make_small(path)
            again = replay(path)
            if not (again.holds and again.steps):
                sys.exit(f"{name} cannot be replayed: {again.difference or 'it has no step'}")
            print(f"{name}: {again.steps} steps, {path.stat().st_size} bytes; {again.outcome}: {again.why}", flush=True)


def make_small(path: Path) -> None:
    """Take out the pictures and the empty space, and leave one file; the rows and their hashes stay as written."""
    with closing(sqlite3.connect(path)) as database:
        database.execute("DELETE FROM blobs")
        database.commit()
        for pragma in ("journal_mode=DELETE", f"page_size={PAGE_BYTES}"):
            database.execute(f"PRAGMA {pragma}").fetchall()
        database.execute("VACUUM")


if __name__ == "__main__":
    main(tuple(sys.argv[1:]) or ("",))
