# SPDX-License-Identifier: Apache-2.0
"""Measures the search in the identity folders of the shipped robots: hits, refusals and time, with and without vectors.

`python benchmarks/bench_recall.py [--missed]`: the questions are `tests/data/identity/questions.json`. A hit is a
passage among the first five that holds the answer. `--missed` lists each question that went wrong.
"""

from __future__ import annotations

import argparse
import json
import re
import statistics
import tempfile
import time
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.embodiment import Library
from rai_missions.embodiment.minilm import why_no_vectors

__all__ = ("ROBOTS", "Scores", "measure", "questions")

ROOT = Path(__file__).parents[1]
ROBOTS = ("tractor", "rosbot")
DEMANDS = {"hits": 0.8, "false_refusals": 0.1, "refused": 0.6}


class Scores(NamedTuple):
    """What came of a set of questions."""

    answerable: int
    hits: float
    """Of the questions that were answered, those with the answer among the first five passages."""
    false_refusals: float
    """Of the questions that have an answer, those that were refused."""
    refused: float
    """Of the questions that have none, those that were refused."""
    unanswerable: int
    milliseconds: float
    """Median of a question."""
    wrong: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether the demands are met."""
        return (
            self.hits >= DEMANDS["hits"]
            and self.false_refusals <= DEMANDS["false_refusals"]
            and self.refused >= DEMANDS["refused"]
        )


def questions() -> Mapping[str, Sequence[Mapping[str, Any]]]:
    """The questions: `answered` and `unanswerable`."""
    found: Mapping[str, Sequence[Mapping[str, Any]]] = json.loads(
        (ROOT / "tests/data/identity/questions.json").read_text(encoding="utf-8")
    )
    return found


def measure(libraries: Mapping[str, Library], *, second: bool | None = None) -> Scores:
    """Ask all questions, or those of one set."""
    asked = {
        kind: [each for each in questions()[kind] if second is None or each.get("second", False) is second]
        for kind in ("answered", "unanswerable")
    }
    times, wrong, hits, refusals, refused = list[float](), list[str](), 0, 0, 0
    for each in (*asked["answered"], *asked["unanswerable"]):
        began = time.perf_counter()
        found = libraries[each["robot"]].recall(each["ask"])
        times.append(1000 * (time.perf_counter() - began))
        holds = any(re.search(each.get("holds", "$^"), " ".join(one.text.split())) for one in found.passages)
        hits += holds
        if "holds" in each:
            refusals += not found.is_answered
        else:
            refused += not found.is_answered
        if "holds" in each and not holds:
            wrong.append(f"{'missed' if found.is_answered else 'refused'}: {each['ask']}")
        elif "holds" not in each and found.is_answered:
            wrong.append(f"answered: {each['ask']}")
    count, without = len(asked["answered"]), len(asked["unanswerable"])
    return Scores(
        count,
        hits / max(1, count - refusals),
        refusals / count,
        refused / without,
        without,
        statistics.median(times),
        tuple(wrong),
    )


def libraries(folder: Path, **words: Any) -> dict[str, Library]:
    """The documents of each robot, with an index of their own."""
    return {name: Library(ROOT / f"missions/{name}/identity", folder / name, **words) for name in ROBOTS}


class Nothing:
    """Finds nothing, so that the words alone count."""

    def fill(self, passages: Sequence[Any]) -> None:
        """Nothing is kept."""

    def nearest(self, question: str, count: int) -> Sequence[tuple[str, float]]:
        """Nothing."""
        return ()


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--missed", action="store_true")
    shows = parser.parse_args().missed
    kinds = {"words alone": {"nearest": Nothing()}} | ({} if why_no_vectors() else {"words and meaning": {}})
    print("search              set      hit at 5 of answered  false refusals  refused         ms")
    with tempfile.TemporaryDirectory() as made:
        opened = {kind: libraries(Path(made) / kind.replace(" ", "_"), **words) for kind, words in kinds.items()}
        for kind, (name, second) in product(kinds, (("first", False), ("second", True), ("all", None))):
            found = measure(opened[kind], second=second)
            print(
                f"{kind:19} {name:7} {found.hits:8.1%} of {found.answerable:4} {found.false_refusals:18.1%}"
                f" {found.refused:9.1%} of {found.unanswerable:3} {found.milliseconds:6.1f}"
                f" {'' if found.holds else '  FALLS SHORT'}"
            )
            if shows and second is not None:
                print("\n".join(f"    {each}" for each in found.wrong))
    print(why_no_vectors())


if __name__ == "__main__":
    main()
