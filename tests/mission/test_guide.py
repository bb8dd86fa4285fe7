# SPDX-License-Identifier: Apache-2.0
"""What the guide to the format shows is the format: every JSON block is read as what it states it is."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from rai_missions.check import check
from rai_missions.guards import Guard
from rai_missions.keys import Key
from rai_missions.mission.mission import Mission
from rai_missions.mission.schema import mission_schema
from rai_missions.states import State, Transition
from rai_missions.states.effects import Effect

GUIDE = (Path(__file__).parents[2] / "docs/guide/format.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"(?:<!-- (?P<kind>\w+) -->\n)?```json\n(?P<text>.*?)```", re.DOTALL)
READ: dict[str, tuple[Any, str]] = {
    "key": (Key.model_validate, "Key"),
    "state": (State.read, "State"),
    "transition": (Transition.model_validate, "Transition"),
    "guard": (Guard.read, "Guard"),
    "effect": (Effect.read, "Effect"),
}


def values(text: str) -> Iterator[Any]:
    """The JSON values of a block, one after the other."""
    decoder = json.JSONDecoder()
    while text := text.lstrip():
        value, end = decoder.raw_decode(text)
        yield value
        text = text[end:]


@cache
def definitions() -> dict[str, Any]:
    """What the schema of a mission file defines."""
    return mission_schema()["$defs"]  # type: ignore[no-any-return]


SHOWN = [(block["kind"], value) for block in BLOCK.finditer(GUIDE) if block["kind"] for value in values(block["text"])]


@pytest.mark.parametrize(("kind", "given"), SHOWN, ids=[f"{kind}-{next(iter(value))}" for kind, value in SHOWN])
def test_every_value_of_the_guide_is_what_its_comment_names(kind: str, given: dict[str, Any]) -> None:
    read, definition = READ[kind]
    made = read(given)
    assert read(made.written()) == made
    jsonschema.Draft202012Validator({"$ref": f"#/$defs/{definition}", "$defs": definitions()}).validate(given)


def test_the_guide_shows_every_kind_there_is() -> None:
    for kind, family in (("state", State), ("guard", Guard), ("effect", Effect)):
        shown = {type(READ[kind][0](value)) for each, value in SHOWN if each == kind}
        history, negation = {family.kinds.get("history")}, {family.kinds.get("not")}
        assert set(family.kinds.values()) - shown <= history | negation


def test_the_guides_mission_passes_the_check() -> None:
    texts = [block["text"] for block in BLOCK.finditer(GUIDE) if not block["kind"]]
    mission = Mission.model_validate(json.loads(texts[0]))
    assert [str(finding) for finding in check(mission)] == []
