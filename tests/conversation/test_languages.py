# SPDX-License-Identifier: Apache-2.0
"""What is spoken is data of the conversation's language: no file has a text that another lacks, and no code has one."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from string import Formatter
from typing import Any, get_args

import pytest

from rai_missions.conversation import Dialogue, Order, OrderEnd, Settings, Speech, StatusView, Utterance
from rai_missions.conversation.inputs import OrderResult, RefusalKind
from rai_missions.conversation.language.language import Language, language, languages
from rai_missions.conversation.view import EndKind
from rai_missions.mission.json_reader import read_json
from rai_missions.testing import play_conversation

PACKAGE = Path(__file__).parents[2] / "rai_missions"
SPEAK = sorted(
    [*(PACKAGE / "conversation").glob("*.py"), PACKAGE / "agents/text_to_speech.py"]
    + [PACKAGE / "voice" / name for name in ("speaker.py", "spoken_text.py")]
)
"""The files between an event and a voice, a page or a topic."""
FILES = sorted(PACKAGE.rglob("languages/*.json"))
WORDS = re.compile(r"[^\W\d_]{2,}[ ,:;]+[^\W\d_]|[^\W\d_]{2,}[,:;] ")
OF_A_KIND = re.compile("/(refused|end)_")
"""What may have the engine's sentence, which is English, or a text for its kind."""
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
    if file.name in ("phrases.py", "language_faults.py"):  # their sentences are for the author of a profile or language
        return
    assert {each for each in literals(file) if WORDS.search(each)} <= NOT_SPOKEN


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parents[1].name}-{file.name}")
def test_no_word_of_a_language_is_there_twice(file: Path) -> None:
    assert read_json(file)["language"] == file.stem


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
    assert {name for name in own if not OF_A_KIND.match(name) and slots(own[name]) != slots(english[name])} == set()
    if code != "en":
        bare = {name: re.sub(r"\{\w*\}", "", text) for name, text in own.items()}
        assert {name for name, text in bare.items() if WORDS.search(text) and own[name] == english[name]} == set()


def refused(code: str, kind: RefusalKind, why: str) -> str:
    """What is spoken of an order that is not carried out."""
    view = StatusView(run="r1", mode="running", mission="patrol")
    dialogue = Dialogue(Settings(language=code), view)
    outputs = dialogue.on_utterance(Utterance("pause", "operator", "terminal", at=1.0), view)
    number = next(each.number for each in outputs if isinstance(each, Order))
    ends = dialogue.on_order_end(OrderEnd(number, OrderResult(why, kind), 2.0))
    return next(each.text for each in ends if isinstance(each, Speech))


@pytest.mark.parametrize("code", languages())
@pytest.mark.parametrize("kind", get_args(RefusalKind))
def test_each_kind_of_refusal_is_spoken_in_the_conversations_language(code: str, kind: RefusalKind) -> None:
    english, own = refused("en", kind, "a reason"), refused(code, kind, "a reason")
    if code != "en":
        assert own.partition(": ")[2] != english.partition(": ")[2] and "a reason" not in own


@pytest.mark.parametrize("code", languages())
def test_only_english_has_the_engines_sentence_within_its_own(code: str) -> None:
    kinds = {name: text for name, text in texts(language(code).data["texts"]) if OF_A_KIND.match(name)}
    assert kinds.keys() == {f"/refused_{each or 'other'}" for each in get_args(RefusalKind)} | {
        f"/end_{each}" for each in get_args(EndKind) if each
    }
    may_have = {"state", "name"} | ({"why"} if code == "en" else set())
    assert {name for name, text in kinds.items() if not slots(text) <= may_have} == set()


def test_each_refusal_that_a_program_words_itself_has_a_kind() -> None:
    calls = [
        node
        for file in sorted(PACKAGE.rglob("*.py"))
        for node in ast.walk(ast.parse(file.read_text("utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "OrderResult"
    ]
    assert len(calls) > 5 and {len(node.args) for node in calls} == {0, 2}


def words_of(conversation: dict[str, Any]) -> Language:
    return language(conversation.get("settings", {}).get("language", "en"))


@pytest.mark.parametrize("conversation", STORED, ids=[each["name"] for each in STORED])
def test_a_models_words_are_marked_aloud_in_the_conversations_language(conversation: dict[str, Any]) -> None:
    words = words_of(conversation)
    for turn in play_conversation(conversation):
        for speech in (each for each in turn.outputs if isinstance(each, Speech)):
            marked = words.text("model_thinks", text=speech.text) if speech.way == "model" else ""
            assert speech.aloud == marked
