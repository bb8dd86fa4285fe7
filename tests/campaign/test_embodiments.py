# SPDX-License-Identifier: Apache-2.0
"""What each embodiment shows a model: more than the one before, and nothing that the identity does not hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rai_missions.answerers.model.prompt import messages_of
from rai_missions.campaign.asking import shown_question
from rai_missions.campaign.embodiments import EMBODIMENTS, RobotView, embodied
from rai_missions.embodiment import Identity
from rai_missions.engine.decision import Evidence, Offer, Question
from rai_missions.errors import UsageError
from rai_missions.image import Image, png

FOLDER = Path(__file__).parents[2] / "missions" / "tractor" / "identity"
ASKED = "Something blocks the alley. What may the tractor drive over, and what harms it?"
CAMERA = Image.of_file("camera@1.000", png(8, 8, bytes(192)))


@pytest.fixture(scope="module")
def bodies() -> dict[str, RobotView]:
    return {name: embodied(name, FOLDER, ASKED) for name in EMBODIMENTS}


def content(body: RobotView) -> tuple[str, int]:
    """The text that a model is shown, and how many pictures."""
    question = Question(
        1,
        "assessing",
        "agent",
        ASKED,
        (Offer("drive_over"), Offer("replan")),
        (Evidence("camera", CAMERA, 0.1, True),),
        until=9.0,
    )
    messages = messages_of(
        shown_question(question, body, "written"), body.identity, mode="json_schema", images=body.pictures
    )
    parts: list[Any] = [part for each in messages for part in (each.content if isinstance(each.content, list) else [])]
    return "\n".join(each.text for each in messages), sum(part["type"] == "image" for part in parts)


@pytest.mark.long
def test_each_embodiment_shows_what_the_one_before_shows_and_more(bodies: dict[str, RobotView]) -> None:
    identity = Identity.read(FOLDER)
    texts, pictures = zip(*(content(bodies[name]) for name in EMBODIMENTS), strict=True)
    description = identity.description.strip()
    assert [description in text for text in texts] == [False, True, True, True]
    assert identity.body is not None
    build = identity.body.words().splitlines()[0][:40]
    assert [build in text for text in texts] == [False, False, True, True]
    assert [bool(bodies[name].documents) for name in EMBODIMENTS] == [False, False, True, True]
    assert all(quote.split(":")[0] in texts[2] for quote in bodies["documents"].documents)
    assert pictures == (0, 0, 0, 2)
    assert "<facts>" in texts[0] and "(you are not shown it)" in texts[2] and "(you are not shown it)" not in texts[3]


def test_quotations_name_their_source_and_are_facts_not_instructions(bodies: dict[str, RobotView]) -> None:
    text, _ = content(bodies["documents"])
    inside = text.rpartition("<facts>")[2].rpartition("</facts>")[0]
    for quote in bodies["documents"].documents:
        assert quote.partition(":")[0] in inside


def test_what_is_not_there_is_refused_with_what_would_be_right() -> None:
    with pytest.raises(UsageError, match="did you mean 'description'"):
        embodied("descripton", FOLDER)
    with pytest.raises(UsageError, match="its profile names none"):
        embodied("pictures", None)
    assert embodied("none", None) == RobotView()
