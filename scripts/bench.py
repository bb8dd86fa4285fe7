#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Run the benchmarks in rounds, and write what they measured: `scripts/bench.py [NAME …] [--base COMMIT]`.

Each benchmark is a process of its own, alone on the machine. With a base, that commit is checked out next to this tree,
today's benchmarks run on both, and the two alternate round by round, so that a slow minute of the machine meets both.
A figure is the median of its rounds; the spread is the least and the largest of them.
"""

from __future__ import annotations

import argparse
import datetime
import importlib.metadata
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks.figures import PACE, PACE_AT_BOUNDS_MS, VARIABLE, Figure, figures_in  # noqa: E402

PAGE = ROOT / "docs" / "performance.md"
PACKAGES = ("pydantic", "py-trees", "transitions", "langchain-core", "mujoco", "rclpy")
"""Whose versions the page names."""

Measured = dict[str, list[Figure]]
"""Name of a figure → what each round found, in the order of the rounds."""


def main() -> int:
    """Measure; exit status 1 where a benchmark did not come to its end."""
    given = arguments()
    failed: list[str] = []
    with based(given.base) as base:
        trees = [ROOT, *([base] if base else [])]
        found: dict[Path, Measured] = {tree: {} for tree in trees}
        for name, number, tree in turns(given.names, given.rounds, trees):
            what = name if tree == ROOT else f"{name} of {given.base}"
            print(f"== {what}, round {number} of {given.rounds}", flush=True)
            ran, figures = run(name, tree)
            for each in figures:
                found[tree].setdefault(each.name, []).append(each)
            if not ran and what not in failed:
                failed.append(what)
        page = written(found[ROOT], found[base] if base else None, given, failed)
    given.page.write_text(page, encoding="utf-8")
    print(f"wrote {given.page}")
    if failed:
        print(f"these did not come to their end: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def turns(names: Sequence[str], rounds: int, trees: Sequence[Path]) -> Iterator[tuple[str, int, Path]]:
    """Benchmark, number of the round, and tree; each round begins with the tree with which the one before ended."""
    for name in names:
        for number in range(1, rounds + 1):
            for tree in trees if number % 2 else trees[::-1]:
                yield name, number, tree


def benchmarks() -> dict[str, bool]:
    """Each benchmark by name, and whether it hands figures over for the page; the others print theirs."""
    files = sorted((ROOT / "benchmarks").glob("bench_*.py"))
    return {
        path.stem.removeprefix("bench_"): "benchmarks.figures import" in path.read_text(encoding="utf-8")
        for path in files
    }


def arguments() -> argparse.Namespace:
    known = benchmarks()
    on_page = [name for name, has_figures in known.items() if has_figures]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "names",
        nargs="*",
        default=on_page,
        metavar="NAME",
        help=f"of {', '.join(known)}; default: {', '.join(on_page)}",
    )
    parser.add_argument("--base", default="", metavar="COMMIT", help="measure this commit too, in turn with the tree")
    parser.add_argument("--rounds", type=int, default=3, help="how often each is run (default: 3)")
    parser.add_argument("--page", type=Path, default=PAGE, help="where the figures are written")
    given = parser.parse_args()
    if unknown := sorted(set(given.names) - set(known)):
        parser.error(f"there is no benchmark {unknown[0]!r}; there are {', '.join(known)}")
    if given.rounds < 1:
        parser.error("--rounds: at least 1")
    return given


@contextmanager
def based(commit: str) -> Iterator[Path | None]:
    """A checkout of a commit with today's benchmarks in it, gone at the end; None for no commit."""
    if not commit:
        yield None
        return
    with tempfile.TemporaryDirectory(prefix="bench-base-") as folder:
        tree = Path(folder) / "tree"
        subprocess.run(["git", "-C", ROOT, "worktree", "add", "--quiet", "--detach", tree, commit], check=True)
        try:
            shutil.rmtree(tree / "benchmarks", ignore_errors=True)
            shutil.copytree(ROOT / "benchmarks", tree / "benchmarks")
            if (ROOT / "tests" / "oracles" / "node_modules").exists():
                (tree / "tests" / "oracles" / "node_modules").symlink_to(ROOT / "tests" / "oracles" / "node_modules")
            yield tree
        finally:
            subprocess.run(["git", "-C", ROOT, "worktree", "remove", "--force", tree], check=True)


def run(name: str, tree: Path) -> tuple[bool, list[Figure]]:
    """One benchmark over the code of a tree: whether it came to its end, and what it handed over."""
    with tempfile.TemporaryDirectory(prefix="bench-") as folder:
        kept = Path(folder) / "figures"
        surroundings = {
            **os.environ,
            VARIABLE: str(kept),
            "PYTHONPATH": str(tree),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        }
        command = [sys.executable, "-m", f"benchmarks.bench_{name}"]
        ended = subprocess.run(command, cwd=tree, env=surroundings, check=False)
        return ended.returncode == 0, figures_in(kept)


def written(own: Measured, base: Measured | None, given: argparse.Namespace, failed: Sequence[str]) -> str:
    """The page: where, when and over what it was measured, then a line a figure."""
    lines = [
        "# Performance",
        "",
        f"Written by `{command_of(given)}`.",
        f"A figure is the median of {given.rounds} round{'s' if given.rounds > 1 else ''}, next to their spread.",
        "Times are CPU times unless a name has another word. A ratio compares two values of the same run.",
        "",
        *(f"- {what}: {value}" for what, value in {**about(given.base), **speed_of(own)}.items()),
        "",
    ]
    heads = ["what", "median", "spread", "peer", "times the peer", "bound"]
    heads += [f"at {given.base}", "times that"] if base is not None else []
    lines += ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    lines += [cells(rounds, base) for rounds in own.values()]
    if failed:
        lines += ["", "Did not come to their end: " + ", ".join(failed) + "."]
    return "\n".join(lines) + "\n"


def command_of(given: argparse.Namespace) -> str:
    everything = sorted(given.names) == [name for name, has_figures in benchmarks().items() if has_figures]
    words = ["make bench", *([] if everything else [f'ONLY="{" ".join(given.names)}"'])]
    words += [f"BASE={given.base}"] if given.base else []
    words += [f"ROUNDS={given.rounds}"] if given.rounds != 3 else []
    return " ".join(words)


def cells(rounds: Sequence[Figure], base: Measured | None) -> str:
    last = rounds[-1]
    middle = statistics.median(each.value for each in rounds)
    spread = f"{short(min(each.value for each in rounds))}–{short(max(each.value for each in rounds))}"
    ratios = [each.value / each.peer_value for each in rounds if each.peer_value]
    relation = f"{short(statistics.median(ratios))}×" if ratios else ""
    bound = ""
    if last.most is not None:
        held = middle >= last.most if last.larger_is_better else middle <= last.most
        bound = f"{'≥' if last.larger_is_better else '≤'} {short(last.most)}: {'held' if held else '**missed**'}"
    out = [last.name, f"{short(middle)} {last.unit}", spread, last.peer, relation, bound]
    if base is not None:
        before = [each.value for each in base.get(last.name, ())]
        was = statistics.median(before) if before else None
        out += [
            f"{short(was)} {last.unit}" if was is not None else "unmeasured",
            f"{short(middle / was)}×" if was else "",
        ]
    return "| " + " | ".join(out) + " |"


def short(value: float) -> str:
    """Three digits that count."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def about(base: str) -> Mapping[str, str]:
    """Machine, commit and versions."""
    commit = output("git", "-C", str(ROOT), "rev-parse", "--short", "HEAD")
    changed = " with changes" if output("git", "-C", str(ROOT), "status", "--porcelain", "-uno") else ""
    return {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "commit": f"{commit}{changed}" + (f", in turn with {base}" if base else ""),
        "machine": f"{processor()}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}",
        "load at the end": f"{os.getloadavg()[0]:.1f} processes over the last minute",
        "Python": f"{platform.python_implementation()} {platform.python_version()}",
        "packages": ", ".join(versions(PACKAGES)),
    }


def speed_of(own: Measured) -> Mapping[str, str]:
    """How fast the machine was, next to the one for which the bounds were set; nothing where that was not measured."""
    if PACE not in own:
        return {}
    found = statistics.median(each.value for each in own[PACE])
    share = f"{PACE_AT_BOUNDS_MS / found:.2f} times that of the machine for which the bounds were set"
    return {"speed": f"{share}: {PACE} takes {short(found)} instead of {PACE_AT_BOUNDS_MS} ms"}


def processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else ():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor() or "an unnamed processor"


def versions(packages: Iterable[str]) -> Iterator[str]:
    for package in packages:
        try:
            yield f"{package} {importlib.metadata.version(package)}"
        except importlib.metadata.PackageNotFoundError:
            yield f"no {package}"


def output(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


if __name__ == "__main__":
    sys.exit(main())
