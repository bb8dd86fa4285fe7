# SPDX-License-Identifier: Apache-2.0
"""Runs laws again and again, each time with examples drawn afresh, and sees that each run holds and ends in time.

`python scripts/repeat.py --runs 200 --seed 1`: the laws that explore; or `python scripts/repeat.py TEST…`. Each run has
a seed of its own, with which `HYPOTHESIS_PROFILE=fresh pytest --hypothesis-seed` draws the same again.

Exit status: 0 when each run held and was over in time; else 1.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).parent.parent
EXPLORING = ("tests/prove/test_laws.py", "tests/prove/test_hold.py", "tests/prove/test_loops.py")
"""The laws that explore what a generated mission can do."""


def run(tests: list[str], seed: int, limit_s: float) -> tuple[list[str], float, str]:
    """Run the tests once; which failed, the longest seconds, and of which test."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        done = subprocess.run(
            [
                sys.executable,
                "-m",
                "pytest",
                "-q",
                "-n",
                "0",
                "-p",
                "no:cacheprovider",
                f"--junitxml={report}",
                f"--timeout={limit_s:g}",
                f"--hypothesis-seed={seed}",
                *tests,
            ],
            cwd=ROOT,
            env={**os.environ, "HYPOTHESIS_PROFILE": "fresh"},
            capture_output=True,
            text=True,
            check=False,
        )
        if not report.exists():
            return [done.stdout + done.stderr], 0.0, ""
        cases = list(ElementTree.parse(report).iter("testcase"))
    failed = [str(case.get("name")) for case in cases if any(each.tag in ("failure", "error") for each in case)]
    slowest = max(cases, key=lambda case: float(case.get("time") or 0))
    return failed, float(slowest.get("time") or 0), str(slowest.get("name"))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tests", nargs="*", default=list(EXPLORING), help="what pytest is given")
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1, help="of the first run")
    parser.add_argument("--limit", type=float, default=120.0, help="seconds within which each test must end")
    chosen = parser.parse_args()

    began, faults, longest = time.monotonic(), 0, 0.0
    for seed in range(chosen.seed, chosen.seed + chosen.runs):
        failed, seconds, name = run(chosen.tests, seed, chosen.limit)
        faults, longest = faults + bool(failed), max(longest, seconds)
        print(f"seed {seed}: {'; '.join(failed) or 'held'}; the longest took {seconds:.1f} s: {name}", flush=True)
    spent_s = time.monotonic() - began
    print(f"{chosen.runs} runs, {faults} with faults, {spent_s:.0f} s; the longest test took {longest:.1f} s")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
