# SPDX-License-Identifier: Apache-2.0
"""A profile states how its robot talks: who may order what beyond what each role may anyway."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rai_missions.errors import DefinitionError
from rai_missions.profile import GRANTED, ORDERS, ConversationPolicy, parse_profile
from tests.profile.profiles import PROFILE, altered


def policy(**words: Any) -> ConversationPolicy | None:
    return parse_profile(json.dumps(altered(PROFILE, {"conversation": words}))).conversation


def test_a_person_may_stop_and_nothing_else_unless_the_profile_grants_it() -> None:
    plain = policy()
    assert plain is not None
    assert plain.granted() == {"operator": frozenset(ORDERS), "viewer": frozenset(), "person": frozenset({"stop"})}
    more = policy(may={"person": ["answer"]})
    assert more is not None and more.granted()["person"] == {"stop", "answer"}
    assert more.granted()["viewer"] == frozenset(GRANTED["viewer"])


def test_a_profile_comes_back_with_what_it_states_of_talk() -> None:
    words = {"may": {"person": ["answer", "pause"]}, "requests": "refuse", "while_answering": "last",
             "language": "de", "begins": "ready", "phrases": {"find {object}": {"task": "find"}},
             "names": {"place": {"living room": "living_room"}}, "results": ["report"], "hri": True}  # fmt: skip
    read = policy(**words)
    assert read is not None and read.written() == words


@pytest.mark.parametrize(
    ("words", "place", "sentence"),
    [
        (
            {"hri_below": "alpha/"},
            "/conversation/hri_below",
            "'alpha/' is no beginning of a topic's name; write it like '/alpha'",
        ),
        (
            {"may": {"persn": ["stop"]}},
            "/conversation/may/persn",
            "no role 'persn'; there is: operator, viewer, person",
        ),
        ({"may": {"person": ["fly"]}}, "/conversation/may/person/0", "fly"),
        ({"requests": "drop"}, "/conversation/requests", "drop"),
        ({"while_answering": "never"}, "/conversation/while_answering", "never"),
        ({"begins": "now"}, "/conversation/begins", "now"),
        ({"begin": "ready"}, "/conversation/begin", "begins"),
    ],
)
def test_what_is_wrong_is_named_with_its_place(words: dict[str, Any], place: str, sentence: str) -> None:
    with pytest.raises(DefinitionError) as error:
        policy(**words)
    faults = [str(each) for each in error.value.faults]
    assert any(each.startswith(f"{place}: ") and sentence in each for each in faults), faults
