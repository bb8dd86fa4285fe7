# SPDX-License-Identifier: Apache-2.0
"""Conversations that are stored as data are played, and each turn is held to what it expects."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.errors import DefinitionError, UsageError
from rai_missions.testing import check_conversation, play_conversation

FOLDER = Path(__file__).parent / "data/conversations"
STORED = [
    each for path in sorted(FOLDER.glob("*.json")) for each in json.loads(path.read_text("utf-8"))["conversations"]
]


def test_there_are_enough_in_both_languages() -> None:
    assert len(STORED) >= 40
    assert sum(each.get("settings", {}).get("language") == "de" for each in STORED) >= 8


@pytest.mark.parametrize("conversation", STORED, ids=[each["name"] for each in STORED])
def test_a_conversation_goes_as_it_is_stored(conversation: dict[str, Any]) -> None:
    check_conversation(conversation)


def test_an_expectation_that_is_not_met_is_reported_with_its_turn() -> None:
    turn = {"at": 1, "person": "hello", "expect": [{"order": "stop"}]}
    with pytest.raises(AssertionError, match=r"at \{'at': 1, 'person': 'hello'\}: expected\n    \{'order': 'stop'\}"):
        check_conversation({"name": "wrong", "turns": [turn]})


HELLO = {"at": 1, "person": "hello"}


def test_a_turn_of_no_kind_is_refused_with_the_kinds() -> None:
    with pytest.raises(UsageError, match="a turn has one of person, status, model"):
        play_conversation({"turns": [{"at": 1, "role": "operator"}]})


@pytest.mark.parametrize(("data", "named"), [
    ({}, "/: 'turns' is missing"),
    ({"turns": 3}, "/turns: 3 is not a list"),
    ({"turns": [{"person": "hello"}]}, "/turns/0: 'at' is missing"),
    ({"turns": [{"at": "soon", "person": "hello"}]}, "/turns/0/at: 'soon'"),
    ({"turns": [{"at": 1, "persno": "hello"}]}, "/turns/0/persno: a turn has no 'persno'; did you mean 'person'?"),
    ({"turns": [{"at": 1, "person": 7}]}, "/turns/0/person: 7 is not text"),
    ({"turns": [HELLO | {"role": "boss"}]}, "/turns/0/role: no such choice: 'boss'"),
    ({"turns": [HELLO | {"expect": ["hello"]}]}, "/turns/0/expect/0: 'hello' is not an object"),
    ({"turns": [HELLO | {"expect": [{"speach": "hello"}]}]},
     "/turns/0/expect/0/speach: an output has no 'speach'; did you mean 'speech'?"),
    ({"view": {"mode": "redy"}, "turns": []}, "/view/mode: no such choice: 'redy'; did you mean 'ready'?"),
    ({"turns": [{"at": 1, "model": {"is_end": True}}]}, "/turns/0/model/is_end: a reply has no 'is_end'"),
    ({"turns": [{"at": 1, "status": {"question": {"text": "?"}}}]}, "/turns/0/status/question: 'options' is missing"),
    ({"view": {"keys": {"there": {}}}, "turns": []}, "/view/keys/there: 'type' is missing"),
    ({"view": {"progress": [{"of": "stops"}]}, "turns": []}, "/view/progress/0: 'done' is missing"),
    ({"settings": {"may": {"person": "ask"}}, "turns": []}, "/settings/may/person: 'ask' is not a list"),
    ({"settings": {"lateness": "queue"}, "turns": []}, "/settings/lateness: a profile has no 'lateness'"),
])  # fmt: skip
def test_a_conversation_that_is_at_fault_is_refused_with_the_place_and_the_words_that_there_are(
    data: dict[str, Any], named: str
) -> None:
    with pytest.raises(DefinitionError) as caught:
        play_conversation(data)
    assert named in str(caught.value)
