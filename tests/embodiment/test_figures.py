# SPDX-License-Identifier: Apache-2.0
"""The search meets its figures on every question that is stored, with one setting for all."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.bench_recall import Nothing, libraries, measure, questions
from rai_missions.embodiment.minilm import why_no_vectors

REPORT = Path(__file__).parents[2] / "docs/testing/recall.md"


def test_there_are_enough_questions_and_each_is_there_once() -> None:
    asked = questions()
    assert len(asked["answered"]) >= 100 and len(asked["unanswerable"]) >= 40
    every = [(each["robot"], each["ask"]) for kind in ("answered", "unanswerable") for each in asked[kind]]
    assert len(every) == len(set(every))


@pytest.mark.parametrize("second", [False, True])
def test_the_words_alone_meet_the_figures(tmp_path: Path, second: bool) -> None:
    found = measure(libraries(tmp_path, nearest=Nothing()), second=second)
    assert found.holds, found
    shares = " | ".join(f"{100 * share:.1f} %" for share in (found.hits, found.false_refusals, found.refused))
    asked = f"{'second' if second else 'first'} ({found.answerable} + {found.unanswerable})"
    assert f"| words alone | {asked} | {shares} |" in REPORT.read_text(encoding="utf-8"), "the report is another run's"


@pytest.mark.drill
@pytest.mark.skipif(bool(why_no_vectors()), reason=why_no_vectors())
@pytest.mark.parametrize("second", [False, True])
def test_words_and_meaning_meet_the_figures(tmp_path: Path, second: bool) -> None:
    found = measure(libraries(tmp_path), second=second)
    assert found.holds and found.hits >= 0.9, found
