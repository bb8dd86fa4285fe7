# SPDX-License-Identifier: Apache-2.0
"""What is spoken is data of the conversation's language: no file has a text that another lacks, and no code has one."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from string import Formatter
from typing import Any

import pytest

from rai_missions.conversation import Speech
from rai_missions.conversation.language import Language, language, languages
from rai_missions.testing import play_conversation

PACKAGE = Path(__file__).parents[2] / "rai_missions"
SPEAK = sorted(
    [*(PACKAGE / "conversation").glob("*.py"), PACKAGE / "agents/text_to_speech.py"]
    + [PACKAGE / "voice" / name for name in ("speaker.py", "spoken_text.py")]
)
"""The files between an event and a voice, a page or a topic."""
WORDS = re.compile(r"[^\W\d_]{2,}[ ,:;]+[^\W\d_]|[^\W\d_]{2,}[,:;] ")
NOT_SPOKEN = {
    "by hand",  # a word of a stored conversation
    "no reply in time",  # a note of the journal
    "watch over the speaker",  # the name of a thread
}
STORED = [
    each
    for path in sorted((Path(__file__).parent / "data/conversations").glob("*.json"))
    for each in json.loads(path.read_text("utf-8"))["conversations"]
]


def literals(file: Path) -> Iterator[str]:
    """The texts in a file that are no docstring, no type's values and no fault of an author's."""
    tree = ast.parse(file.read_text("utf-8"))
    docs = (node for node in ast.walk(tree) if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))
    apart = [*docs, *(node for node in ast.walk(tree) if isinstance(node, ast.Raise | ast.Subscript))]
    skipped = {id(inner) for node in apart for inner in ast.walk(node)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in skipped:
            yield node.value


@pytest.mark.parametrize("file", SPEAK, ids=lambda file: file.name)
def test_no_sentence_is_written_in_code(file: Path) -> None:
    if file.name == "phrases.py":  # its sentences are about a profile's phrases, for whom they are checked
        return
    assert {each for each in literals(file) if WORDS.search(each)} <= NOT_SPOKEN


def texts(table: Mapping[str, Any], place: str = "") -> Iterator[tuple[str, str]]:
    """The templates of a language, each with its place."""
    for name, value in table.items():
        if isinstance(value, str):
            yield f"{place}/{name}", value
        else:
            yield from texts(value, f"{place}/{name}")


def slots(text: str) -> set[str]:
    return {name for _, name, _, _ in Formatter().parse(text) if name}


@pytest.mark.parametrize("code", languages())
def test_each_language_has_every_text_in_its_own_words(code: str) -> None:
    own, english = (dict(texts(language(each).data["texts"])) for each in (code, "en"))
    assert own.keys() == english.keys()
    assert {name for name in own if slots(own[name]) != slots(english[name])} == set()
    if code != "en":
        bare = {name: re.sub(r"\{\w*\}", "", text) for name, text in own.items()}
        assert {name for name, text in bare.items() if WORDS.search(text) and own[name] == english[name]} == set()


def words_of(conversation: dict[str, Any]) -> Language:
    return language(conversation.get("settings", {}).get("language", "en"))


@pytest.mark.parametrize("conversation", STORED, ids=[each["name"] for each in STORED])
def test_a_models_words_are_marked_aloud_in_the_conversations_language(conversation: dict[str, Any]) -> None:
    words = words_of(conversation)
    for turn in play_conversation(conversation):
        for speech in (each for each in turn.outputs if isinstance(each, Speech)):
            marked = words.text("model_thinks", text=speech.text) if speech.way == "model" else ""
            assert speech.aloud == marked
