# SPDX-License-Identifier: Apache-2.0
"""The word list finds its words in names and in sentences, and leaves alone what the subject needs."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]
LIST = """
files = ["*.py", "*.md"]
skipped = ["old/*"]

[[word]]
pattern = "whisper(?:s|ed)?"
instead = "publish"

[[word]]
pattern = "walks on"
instead = "continue"

[[word]]
pattern = "grim"
instead = "severity"
is_name = true

[[word]]
pattern = "shelf"
instead = "transition"
paths = ["engine/*"]

[[allowed]]
pattern = "whispered aloud"
"""


@pytest.fixture(scope="module")
def words() -> ModuleType:
    spec = importlib.util.spec_from_file_location("words", ROOT / "scripts/words.py")
    assert spec is not None and spec.loader is not None
    module = sys.modules["words"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("The clock whispers.", [(1, "whispers")]),
        ("def whisper_all(): ...\n\nclass NotWhispered: ...\n", [(1, "whisper"), (3, "Whispered")]),
        ("# it walks\n# on and WALKS_ON = 1", [(1, "walks\n# on"), (2, "WALKS_ON")]),
        ("whispering = unwhispered = sleepwalks_on = 1", []),
        ("what was whispered aloud", []),
        ("grim = 'grim'  # grim", [(1, "grim")]),
        ("the shelf", []),
    ],
)
def test_a_word_is_found_in_names_and_sentences_and_in_one_sense(
    words: ModuleType, text: str, found: list[object]
) -> None:
    got = words.findings_in("a.py", text, words.read_words(LIST))
    assert [(each.line, each.word) for each in got] == found


def test_a_word_of_one_room_is_avoided_in_that_room(words: ModuleType) -> None:
    (found,) = words.findings_in("engine/a.md", "the shelf", words.read_words(LIST))
    assert str(found) == "engine/a.md:1: 'shelf'; write: transition"


def test_each_word_of_the_list_is_found(words: ModuleType) -> None:
    listed = words.read_words((ROOT / words.WORDS).read_text())
    for sample in (
        "is told",
        "it_says",
        "isHeard",
        "stands",
        "taken up",
        "goes on",
        "whoever",
        "beside",
        "anew",
        "lest",
    ):
        assert words.findings_in("a.md", sample, listed), sample
    assert words.findings_in("rai_missions/engine/a.py", "the rows", listed)
    assert not words.findings_in("rai_missions/journal/a.py", "the rows", listed)
