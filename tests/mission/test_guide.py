# SPDX-License-Identifier: Apache-2.0
"""What the guide to the format shows is the format: every JSON block is read as what it says it is."""

from __future__ import annotations

import json
import re
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
BLOCK = re.compile(r"(?:<!-- (?P<kind>\w+), one a line -->\n)?```json\n(?P<text>.*?)```", re.DOTALL)
READ: dict[str, tuple[Any, str]] = {
    "key": (Key.model_validate, "Key"),
    "state": (State.read, "State"),
    "row": (Transition.model_validate, "Transition"),
    "guard": (Guard.read, "Guard"),
    "effect": (Effect.read, "Effect"),
}
LINES = [
    (block["kind"], line) for block in BLOCK.finditer(GUIDE) if block["kind"] for line in block["text"].splitlines()
]


@pytest.mark.parametrize(("kind", "line"), LINES)
def test_every_line_of_the_guide_is_what_it_says(kind: str, line: str) -> None:
    read, definition = READ[kind]
    given = json.loads(line)
    made = read(given)
    assert read(made.written()) == made
    schema = mission_schema()
    jsonschema.Draft202012Validator({"$ref": f"#/$defs/{definition}", "$defs": schema["$defs"]}).validate(given)


def test_the_guide_shows_every_kind_there_is() -> None:
    for kind, family in (("state", State), ("guard", Guard), ("effect", Effect)):
        shown = {type(READ[kind][0](json.loads(line))) for each, line in LINES if each == kind}
        history, negation = {family.kinds.get("history")}, {family.kinds.get("not")}
        assert set(family.kinds.values()) - shown <= history | negation


def test_the_guides_mission_passes_the_check() -> None:
    texts = [block["text"] for block in BLOCK.finditer(GUIDE) if not block["kind"]]
    mission = Mission.model_validate(json.loads(texts[0]))
    assert [str(finding) for finding in check(mission)] == []
