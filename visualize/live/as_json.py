# SPDX-License-Identifier: Apache-2.0
"""Steps, values and questions as the live page shows them: plain data of bounded size.

Rule: nothing that a robot or a model reports makes a message long; what is cut states it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rai_missions.engine.decision import Question
from rai_missions.engine.description import step_json
from rai_missions.engine.step import Step
from rai_missions.image import Image
from rai_missions.plain_data import plain
from rai_missions.states import answerer_words
from visualize.page.as_json import Json, without_empty

__all__ = ("LONGEST", "bounded", "line", "question_data")

LONGEST = 400
"""Characters of a text, and ten times the items of a list or object."""
DEEPEST = 6


def bounded(value: Any, depth: int = 0) -> Any:
    """A value as plain data; long texts and lists are cut, deep ones left out."""
    if isinstance(value, str):
        return value if len(value) <= LONGEST else f"{value[:LONGEST]}… ({len(value)} characters)"
    if isinstance(value, Image) or not isinstance(value, Mapping | list | tuple):
        return plain(value)
    if depth >= DEEPEST:
        return "…"
    most = LONGEST // 10
    if isinstance(value, Mapping):
        kept = {str(name)[:LONGEST]: bounded(item, depth + 1) for name, item in list(value.items())[:most]}
        return kept | ({"…": f"{len(value)} in all"} if len(value) > most else {})
    items = [bounded(item, depth + 1) for item in value[:most]]
    return [*items, f"… {len(value)} in all"] if len(value) > most else items


def line(step: Step) -> Json | None:
    """A step as the journal's tail shows it; None where it changed nothing but the blackboard and the clock."""
    if step.ignored and not (step.why and step.event.kind != "write"):
        return None
    found = step_json(step, without=("guards",))
    found["event"]["data"].pop("request", None)
    if step.event.kind == "proposal":
        found["event"]["who"] = answerer_words(step.event.name)
    texts = {name: [bounded(each) for each in found[name]] for name in ("effects", "verdicts", "notes")}
    short = {"event": bounded(found["event"], -1), "why": bounded(found["why"]), **texts}
    return without_empty(found | short) | {"seq": step.seq, "at": round(step.at, 3)}


def question_data(question: Question) -> Json:
    """A question that is open."""
    evidence = [
        without_empty({"key": shown.key, "fresh": shown.fresh, "picture": isinstance(shown.value, Image)})
        | {"value": bounded(shown.value), "age_s": plain(shown.age_s)}
        for shown in question.evidence
    ]
    options = [
        without_empty({"name": offer.name, "about": bounded(offer.about), "parameters": plain(offer.parameters)})
        for offer in question.options
    ]
    return {
        "number": question.number,
        "state": question.state,
        "asked": question.asked,
        "who": answerer_words(question.asked),
        "text": bounded(question.text),
        "attempt": question.attempt,
        "options": options,
        "evidence": evidence,
        "refused": [bounded(why) for why in question.refused],
        "at": question.at,
        "until": question.until if math.isfinite(question.until) else None,
    }
