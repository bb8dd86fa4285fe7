# SPDX-License-Identifier: Apache-2.0
"""Conversations that are stored as data are played, and each turn is held to what it expects."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.errors import UsageError
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


def test_a_turn_of_no_kind_is_refused_with_the_kinds() -> None:
    with pytest.raises(UsageError, match="a turn has one of person, status, model"):
        play_conversation({"turns": [{"at": 1, "persno": "hello"}]})
