# SPDX-License-Identifier: Apache-2.0
"""What `make bench` writes: medians, spreads, ratios within a run, bounds that are missed, and a base in turn."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
BENCH = """
import os
from pathlib import Path
from benchmarks.figures import PACE as REFERENCE, figure
from rai_missions.pace import PACE

count = Path(os.environ["COUNT"])
runs = len(count.read_text()) if count.exists() else 0
count.write_text("x" * (runs + 1))
figure("an event", PACE + runs, "µs", peer=("a peer", 2.0), most=4.5)
figure("steps", 100.0, "steps/s", most=90.0, larger_is_better=True)
figure(REFERENCE, 628.0, "ms")
"""


def page(tree: Path, *words: str, status: int = 0) -> str:
    ran = subprocess.run(
        [sys.executable, tree / "scripts" / "bench.py", *words, "--page", tree / "page.md"],
        env={"PATH": "/usr/bin:/bin", "COUNT": str(tree / "count")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == status, ran.stderr
    return (tree / "page.md").read_text(encoding="utf-8")


def project(folder: Path) -> Path:
    """A project of one benchmark, with a commit in which an event costs 1 µs, and 3 µs since."""
    for name in ("scripts/bench.py", "benchmarks/figures.py"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes((ROOT / name).read_bytes())
    (folder / "rai_missions").mkdir()
    (folder / "rai_missions" / "__init__.py").touch()
    (folder / "benchmarks" / "bench_event.py").write_text(BENCH, encoding="utf-8")
    (folder / "rai_missions" / "pace.py").write_text("PACE = 1.0\n", encoding="utf-8")
    git = ["git", "-C", str(folder), "-c", "user.name=a", "-c", "user.email=a@example.org"]
    for command in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "first"]):
        subprocess.run([*git, *command], check=True)
    (folder / "rai_missions" / "pace.py").write_text("PACE = 3.0\n", encoding="utf-8")
    return folder


def test_the_median_its_spread_the_ratio_and_the_bound(tmp_path: Path) -> None:
    text = page(project(tmp_path))
    assert "| an event | 4 µs | 3–5 | a peer | 2× | ≤ 4.5: held |" in text
    assert "| steps | 100 steps/s | 100–100 |  |  | ≥ 90: held |" in text
    assert "- speed: 0.50 times that of the machine for which the bounds were set: import mujoco takes 628" in text


def test_a_base_takes_turns_with_the_tree(tmp_path: Path) -> None:
    """The runs count on: the tree first in rounds 1 and 3, the base in round 2."""
    text = page(project(tmp_path), "--base", "HEAD")
    assert "| an event | 6 µs | 3–7 | a peer | 3× | ≤ 4.5: **missed** | 3 µs | 2× |" in text
    listed = subprocess.run(["git", "-C", tmp_path, "worktree", "list"], capture_output=True, text=True, check=True)
    assert len(listed.stdout.splitlines()) == 1


def test_a_benchmark_that_breaks_off_is_named_and_the_others_are_kept(tmp_path: Path) -> None:
    tree = project(tmp_path)
    broken = "from benchmarks.figures import figure\nraise SystemExit(3)\n"
    (tree / "benchmarks" / "bench_broken.py").write_text(broken, encoding="utf-8")
    text = page(tree, "--rounds", "1", status=1)
    assert "Did not come to their end: broken." in text
    assert "| an event | 3 µs |" in text


def test_one_that_hands_no_figures_over_runs_where_it_is_named_alone(tmp_path: Path) -> None:
    tree = project(tmp_path)
    (tree / "benchmarks" / "bench_printed.py").write_text("raise SystemExit(3)\n", encoding="utf-8")
    assert "Written by `make bench ROUNDS=1`." in page(tree, "--rounds", "1")
    assert "Did not come to their end: printed." in page(tree, "printed", "--rounds", "1", status=1)
