# SPDX-License-Identifier: Apache-2.0
"""Breaks the code in small ways, one at a time, and sees whether the tests of its part notice.

`python scripts/mutate.py --count 300 --seed 1`: draws so many mutants over the parts that `tests/mutants/parts.toml`
names, with Cosmic Ray's operators and one that deletes a statement. Each is tried in a copy of the checkout, with the
tests of its part that run the line. Results are kept in `out/mutants.jsonl`; the same seed continues where it was
stopped.

Exit status: 0 when at least 95 of 100 are found or listed in `tests/mutants/equivalent.toml`; else 1.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from queue import SimpleQueue
from typing import Any
from xml.etree import ElementTree

import parso
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator
from coverage import CoverageData

ROOT = Path(__file__).parent.parent
PARTS = ROOT / "tests/mutants/parts.toml"
EQUIVALENT = ROOT / "tests/mutants/equivalent.toml"
CHECKOUT = "checkout"
"""The name of a folder that is a copy of the checkout."""
ENOUGH = 0.95
"""The share of mutants that the tests must find."""
LIMIT_S, LIMIT_FACTOR = 60, 4
"""A mutant under which the tests take longer than so many seconds plus so many times their own is found."""
PAIRS = (
    "Eq_NotEq", "NotEq_Eq", "Lt_LtE", "Lt_GtE", "LtE_Lt", "LtE_Gt", "Gt_GtE", "Gt_LtE", "GtE_Gt", "GtE_Lt",
    "Is_IsNot", "IsNot_Is",
)  # fmt: skip
SIGNS = ("Add_Sub", "Sub_Add", "Mul_Div", "BitOr_BitAnd", "BitAnd_BitOr", "Mod_Mul")
OPERATORS = (
    *(f"core/ReplaceComparisonOperator_{each}" for each in PAIRS),
    *(f"core/ReplaceBinaryOperator_{each}" for each in SIGNS),
    *(f"core/Replace{each}" for each in ("AndWithOr", "OrWithAnd", "TrueWithFalse", "FalseWithTrue")),
    *(f"core/Replace{each}" for each in ("BreakWithContinue", "ContinueWithBreak", "UnaryOperator_Delete_Not")),
    "core/AddNot",
    "core/NumberReplacer",
    "core/ZeroIterationForLoop",
    "statement",
)


class StatementDeletion(Operator):  # type: ignore[misc, unused-ignore]
    """Replaces one statement of a line by `pass`; docstrings, imports and names are left."""

    def mutation_positions(self, node: Any) -> Iterator[tuple[Any, Any]]:
        if node.type == "simple_stmt" and node.children[0].type not in ("string", "import_name", "import_from", "name"):
            yield node.start_pos, node.end_pos

    def mutate(self, node: Any, index: int) -> Any:
        first = node.get_first_leaf()
        pass_ = parso.parse("pass\n").children[0]
        pass_.get_first_leaf().prefix = first.prefix
        return pass_

    @classmethod
    def examples(cls) -> Any:
        return ()


@dataclass(frozen=True)
class Mutant:
    part: str
    file: str
    operator: str
    occurrence: int
    line: int


def operator_of(name: str) -> Any:
    return StatementDeletion() if name == "statement" else get_operator(name)()


class _Left(ast.NodeVisitor):
    """Collects the lines of a module where no mutant is drawn: what only type checkers and readers use."""

    def __init__(self) -> None:
        self.spans: list[tuple[tuple[int, int], tuple[int, int]]] = []

    def _leave(self, node: ast.AST | None) -> None:
        if node is not None:
            begin, end = (node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset)  # type: ignore[attr-defined]
            self.spans.append((begin, end))

    def visit_arg(self, node: ast.arg) -> None:
        self._leave(node.annotation)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        self._leave(node.annotation if node.value else node)
        self.generic_visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self._leave(node.returns)
        self.generic_visit(node)

    def visit_Assert(self, node: ast.Assert) -> None:
        self._leave(node)

    def visit_If(self, node: ast.If) -> None:
        if ast.unparse(node.test) == "TYPE_CHECKING":
            self._leave(node)
        self.generic_visit(node)

    def visit_Assign(self, node: ast.Assign) -> None:
        if any(ast.unparse(target) in ("__all__", "__slots__") for target in node.targets):
            self._leave(node)
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        if ast.unparse(node.func) in ("TypeVar", "cast", "NewType"):
            self._leave(node)
        self.generic_visit(node)


@cache
def source_of(file: str) -> str:
    return (ROOT / file).read_text(encoding="utf-8")


def drawable(part: str, file: str) -> Iterator[tuple[tuple[int, int], Mutant]]:
    """Every mutant of a file with its place."""
    source = source_of(file)
    left = _Left()
    left.visit(ast.parse(source))
    nodes = list(ast_nodes(get_ast(source)))
    for name in OPERATORS:
        operator = operator_of(name)
        positions = (place for node in nodes for place, _ in operator.mutation_positions(node))
        for occurrence, place in enumerate(positions):
            if not any(begin <= tuple(place) < end for begin, end in left.spans):
                yield tuple(place), Mutant(part, file, name, occurrence, place[0])


def lines_of(mutant: Mutant) -> tuple[str, list[str], list[str]]:
    """The broken module, and the lines that it lost and gained."""
    source = source_of(mutant.file)
    broken = mutate_code(source, operator_of(mutant.operator), mutant.occurrence)
    assert broken is not None
    before, after = source.splitlines(), broken.splitlines()
    head = next(
        (i for i, (a, b) in enumerate(zip(before, after, strict=False)) if a != b), min(len(before), len(after))
    )
    tail = next((i for i, (a, b) in enumerate(zip(before[::-1], after[::-1], strict=False)) if a != b), 0)
    tail = min(tail, len(before) - head, len(after) - head)
    strip = [[line.strip() for line in each[head : len(each) - tail]] for each in (before, after)]
    return broken, strip[0], strip[1]


def function_at(file: str, line: int) -> range:
    """The lines of the function that begins at a line of a file; none where none does."""
    functions = [each for each in ast.walk(ast.parse(source_of(file))) if isinstance(each, ast.FunctionDef)]
    bodies = (
        range(each.body[0].lineno, (each.end_lineno or 0) + 1)
        for each in functions
        if each.lineno <= line < each.body[0].lineno
    )
    return next(bodies, range(0))


def draw(parts: dict[str, Any], count: int, seed: int) -> list[Mutant]:
    """So many mutants, spread over the parts by the places that they have; at most one a place."""
    places: dict[tuple[str, tuple[int, int]], list[Mutant]] = {}
    for part, file in ((part, file) for part, each in parts.items() for file in files_of(each)):
        for place, mutant in drawable(part, file):
            places.setdefault((file, place), []).append(mutant)
    chance = random.Random(seed)
    chosen = chance.sample(sorted(places), min(count, len(places)))
    return [chance.choice(places[place]) for place in chosen]


def environment_in(copy: Path) -> dict[str, str]:
    """What the tests in a copy of the checkout find around them."""
    own = {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1", "HYPOTHESIS_PROFILE": "first"}
    return {**os.environ, **own}


def files_of(part: dict[str, Any]) -> list[str]:
    """The files of a part, pattern by pattern."""
    paths = [path for pattern in part["files"] for path in sorted(ROOT.glob(pattern))]
    return [path.relative_to(ROOT).as_posix() for path in paths]


def tests_of(part: dict[str, Any]) -> list[str]:
    """What pytest is given for a part."""
    return [*part["tests"], *(f"--ignore={path}" for path in part.get("ignore", ()))]


class Covered:
    """Which tests run a line and how long they take: worked out once a commit, by one run under coverage.

    Args:
        folder: Where what was worked out is kept.
        parts: Name → its files and tests.
        jobs: Processes.
        copy: Where the tests are run: one that fails in a copy finds nothing.
    """

    def __init__(self, folder: Path, parts: dict[str, Any], jobs: int, copy: Path) -> None:
        commit = subprocess.run(
            ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True
        )
        path = folder / f"coverage-{commit.stdout.strip()}"
        report = path.with_suffix(".xml")
        if not report.exists():
            print("which tests run which lines", flush=True)
            tests = sorted({test for part in parts.values() for test in tests_of(part)})
            self._work_out(path.resolve(), report.resolve(), tests, jobs, copy)
        data = CoverageData(str(path))
        data.read()
        self._lines = {
            file.rpartition(f"/{CHECKOUT}/")[2]: data.contexts_by_lineno(file) for file in data.measured_files()
        }
        cases = ElementTree.parse(report).iter("testcase")
        self._seconds = {
            f"{case.get('classname')}::{case.get('name')}": float(case.get("time") or 0)
            for case in cases
            if all(each.tag not in ("failure", "error", "skipped") for each in case)
        }

    @staticmethod
    def _work_out(path: Path, report: Path, tests: list[str], jobs: int, copy: Path) -> None:
        subprocess.run(
            [
                sys.executable,
                "-m",
                "pytest",
                "-q",
                "-n",
                str(jobs),
                "--dist",
                "loadfile",
                "-p",
                "no:cacheprovider",
                "--cov=rai_missions",
                "--cov-context=test",
                "--cov-report=",
                f"--junitxml={report}",
                "--timeout=0",
                *tests,
            ],  # a time-out inside coverage's own lock would wait for ever
            cwd=copy,
            check=False,
            env={**environment_in(copy), "COVERAGE_FILE": str(path)},
            stdin=subprocess.DEVNULL,
        )

    def every(self) -> list[str]:
        """The tests of all lines."""
        contexts = (each for lines in self._lines.values() for line in lines.values() for each in line)
        return [name for _, name in self._timed(contexts)]

    def tests(self, mutant: Mutant) -> list[tuple[float, str]]:
        """The tests that pass and run the line of a mutant with their seconds, the quickest first.

        A line that is run as its module is loaded, or by no test, gets the tests of the function that it begins, or
        else all tests that run a line of its file.
        """
        lines = self._lines.get(mutant.file, {})
        for near in ([mutant.line], function_at(mutant.file, mutant.line), lines):
            contexts = [each for line in near for each in lines.get(line, []) if each]
            if contexts:
                break
        return self._timed(contexts)

    def _timed(self, contexts: Iterable[str]) -> list[tuple[float, str]]:
        """The tests of contexts that pass, with their seconds; a context is a test and its phase, `a.py::b|run`."""
        names = {context.rpartition("|")[0] for context in contexts if context}
        timed = ((self._seconds.get(_junit_name(name)), name) for name in names)
        return sorted((seconds, name) for seconds, name in timed if seconds is not None)


def _junit_name(test: str) -> str:
    """`a/b.py::C::d` as JUnit's report writes it: `a.b.C::d`."""
    path, _, rest = test.partition("::")
    *classes, name = _outside_brackets(rest)
    return ".".join((path.removesuffix(".py").replace("/", "."), *classes)) + f"::{name}"


def _outside_brackets(rest: str) -> list[str]:
    head, bracket, parameters = rest.partition("[")
    *classes, name = head.split("::")
    return [*classes, name + bracket + parameters]


def rounds_of(tests: list[tuple[float, str]]) -> Iterator[list[tuple[float, str]]]:
    """The tests in rounds of 20 s, 60 s, 180 s, …, in the order given."""
    chosen: list[tuple[float, str]] = []
    spent, budget = 0.0, 20.0
    for each in tests:
        if chosen and spent + each[0] > budget:
            yield chosen
            chosen, spent, budget = [], 0.0, budget * 3
        chosen.append(each)
        spent += each[0]
    if chosen:
        yield chosen


@dataclass(frozen=True)
class Tried:
    """How a mutant came out.

    Args:
        result: `found`, `found: time`, `not found` or `equivalent`.
        by: The test that failed.
        seconds: How long it took.
    """

    result: str
    by: str = ""
    seconds: float = 0.0


class Copies:
    """Copies of the checkout, one for each mutant that is tried at the same time."""

    def __init__(self, count: int) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="mutants-"))
        self.free: SimpleQueue[Path] = SimpleQueue()
        files = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True).stdout.decode()
        for number in range(count):
            copy = self.folder / str(number) / CHECKOUT
            for name in filter(None, files.split("\0")):
                if (ROOT / name).is_file():
                    (copy / name).parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy2(ROOT / name, copy / name)
            self.free.put(copy)

    def try_in_rounds(self, mutant: Mutant, tests: list[tuple[float, str]]) -> Tried:
        """Tries a mutant with its quick tests, then with the others."""
        tried, began = Tried("not found"), time.monotonic()
        for chosen in rounds_of(tests):
            limit_s = LIMIT_S + LIMIT_FACTOR * sum(seconds for seconds, _ in chosen)
            tried = self.try_one(mutant, [name for _, name in chosen], limit_s)
            if tried.result != "not found":
                break
        return replace(tried, seconds=round(time.monotonic() - began, 1))

    def try_one(self, mutant: Mutant, tests: list[str], limit_s: float) -> Tried:
        """Tries a mutant with these tests."""
        copy = self.free.get()
        target = copy / mutant.file
        whole = target.read_text(encoding="utf-8")
        target.write_text(lines_of(mutant)[0], encoding="utf-8")
        try:
            status, output = self.run(copy, tests, limit_s)
        finally:
            target.write_text(whole, encoding="utf-8")
            self.free.put(copy)
        failed = (re.match(r"(?:FAILED|ERROR) (.*?)(?: - |$)", line) for line in output.splitlines())
        by = next((match[1] for match in failed if match), "")
        return Tried({None: "found: time", 0: "not found"}.get(status, "found"), by)

    @staticmethod
    def run(copy: Path, tests: list[str], limit_s: float) -> tuple[int | None, str]:
        """The exit status of the tests in a copy, None where they are not over in time; and what they print."""
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-x",
            "-q",
            "-n",
            "0",
            "-p",
            "no:cacheprovider",
            "--timeout",
            "120",
            *tests,
        ]
        with tempfile.TemporaryFile("w+", errors="replace") as output:
            process = subprocess.Popen(
                command,
                cwd=copy,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
                env=environment_in(copy),
            )
            status: int | None = None
            with suppress(subprocess.TimeoutExpired):
                status = process.wait(limit_s)
            subprocess.run(["pkill", "-9", "-s", str(process.pid)], check=False)
            process.wait()
            output.seek(0)
            return status, output.read()


class Trial:
    """The mutants that are tried, each once, and what came of them in rows as they are kept.

    Args:
        results: The file of the rows; those that it has are not tried again.
        copies: Where mutants are tried.
        covered: Which tests run a line.
        count: How many mutants there are.
    """

    def __init__(self, results: Path, copies: Copies, covered: Covered, count: int) -> None:
        self._results, self._copies, self._covered, self._count = results, copies, covered, count
        known = tomllib.loads(EQUIVALENT.read_text())["mutant"] if EQUIVALENT.exists() else []
        self._equivalent = {(each["file"], each["before"].strip(), each["after"].strip()) for each in known}
        lines = results.read_text().splitlines() if results.exists() else []
        self._done = {(row["file"], tuple(row["before"]), tuple(row["after"])): row for row in map(json.loads, lines)}
        self.rows: list[dict[str, Any]] = []

    def add(self, mutant: Mutant) -> None:
        """Try a mutant, from any thread."""
        _, before, after = lines_of(mutant)
        row = self._done.get((mutant.file, tuple(before), tuple(after)))
        if row is None:
            if (mutant.file, "\n".join(before).strip(), "\n".join(after).strip()) in self._equivalent:
                tried = Tried("equivalent")
            else:
                tried = self._copies.try_in_rounds(mutant, self._covered.tests(mutant))
            row = {**asdict(mutant), "before": before, "after": after, **asdict(tried)}
            with self._results.open("a") as file:
                file.write(json.dumps(row) + "\n")
        self.rows.append(row)
        outcome = f"{row['result']:<11} {row['seconds']:6.1f} s  {mutant.file}:{mutant.line}  {row['by']}"
        print(f"{len(self.rows)}/{self._count} {outcome}", flush=True)


def share_found(rows: list[dict[str, Any]]) -> float:
    """The share of the mutants that were found, of those that can be; prints the others."""
    missed = [row for row in rows if row["result"] == "not found"]
    for row in missed:
        print(f"\n{row['file']}:{row['line']} ({row['operator']})")
        print(*(f"  - {line}" for line in row["before"]), *(f"  + {line}" for line in row["after"]), sep="\n")
    real = [row for row in rows if row["result"] != "equivalent"]
    share = 1 - len(missed) / max(1, len(real))
    print(f"\n{len(real) - len(missed)} of {len(real)} found ({100 * share:.1f} %); {len(rows) - len(real)} equivalent")
    return share


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--part", action="append", help="only these parts")
    parser.add_argument("--results", type=Path, default=ROOT / "out/mutants.jsonl")
    given = parser.parse_args()

    every = tomllib.loads(PARTS.read_text())
    parts = {name: each for name, each in every.items() if not given.part or name in given.part}
    given.results.parent.mkdir(parents=True, exist_ok=True)
    copies = Copies(given.jobs)
    try:
        first = copies.folder / "0" / CHECKOUT
        covered = Covered(given.results.parent, parts, given.jobs, first)
        if copies.run(first, ["--collect-only", *covered.every()], 300)[0]:
            print("pytest does not find the tests by their names", file=sys.stderr)
            return 2
        mutants = draw(parts, given.count, given.seed)
        trial = Trial(given.results, copies, covered, len(mutants))
        with ThreadPoolExecutor(given.jobs) as pool:
            list(pool.map(trial.add, mutants))
    finally:
        shutil.rmtree(copies.folder, ignore_errors=True)
    return 0 if share_found(trial.rows) >= ENOUGH else 1


if __name__ == "__main__":
    sys.exit(main())
