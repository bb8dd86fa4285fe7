# SPDX-License-Identifier: Apache-2.0
"""What a person is shown and asked, in words: a question, its options, and the parameters of the one chosen.

Rule: a typed word is turned into what the JSON Schema asks for or refused with what would be right, and costs no
attempt; whether the whole is valid is judged elsewhere.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.engine.decision import Offer, Question
from rai_missions.mission.option_parameters import parameter_faults
from rai_missions.plain_data import is_number, json_value, printable
from rai_missions.redaction import cut

__all__ = ("Blank", "blanks", "chosen", "question_lines")

NO_SCHEMA: Mapping[str, Any] = {}
TRUTHS = {"true": True, "yes": True, "y": True, "false": False, "no": False, "n": False}


def question_lines(question: Question, left_s: float) -> list[str]:
    """The question, what is known, and the numbered options."""
    left = "" if math.isinf(left_s) else f", {max(0.0, left_s):.0f} s left"
    width = max(len(offer.name) for offer in question.options) if question.options else 0
    return [
        printable(line)
        for line in (
            f"Question {question.number} of '{question.state}'{left}: {question.text}",
            *(f"  {evidence.words()}" for evidence in question.evidence),
            *(f"  refused before: {why}" for why in question.refused),
            *(f"  {n}  {offer.name:{width}}  {offer.about}".rstrip() for n, offer in enumerate(question.options, 1)),
        )
    ]


def chosen(typed: str, offers: Sequence[Offer]) -> Offer | None:
    """The offer that a line names, by its number or its name; None if it names none."""
    numbered = {str(number): offer for number, offer in enumerate(offers, 1)}
    named = {offer.name: offer for offer in offers}
    return named.get(typed.strip()) or numbered.get(typed.strip())


class Blank(NamedTuple):
    """One parameter that is asked for."""

    name: str
    schema: Mapping[str, Any]
    required: bool
    whole: Mapping[str, Any] = NO_SCHEMA
    """The option's `parameters`, into which its references lead."""

    def prompt(self) -> str:
        """`speed (number, 0 to 3, m/s; empty for 1.0): `."""
        kind = " or ".join(map(_shown, self.schema["enum"])) if "enum" in self.schema else _kind(self.schema)
        about = str(self.schema.get("description", ""))
        if "default" in self.schema:
            empty = f"empty for {_shown(self.schema['default'])}"
        else:
            empty = "" if self.required else "empty to leave it out"
        inside = ", ".join(part for part in (kind, _range(self.schema), about) if part)
        known = "; ".join(part for part in (inside, empty) if part)
        return printable(f"{self.name} ({known}): " if known else f"{self.name}: ")

    def value(self, typed: str) -> Any:
        """What a line means here.

        Raises:
            KeyError: The line is empty and the parameter stays out.
            ValueError: It is nothing of this kind; the text states what would be.
        """
        if not typed.strip():
            if "default" in self.schema:
                return self.schema["default"]
            if self.required:
                raise ValueError(f"'{self.name}' is needed")
            raise KeyError(self.name)
        if "enum" in self.schema:
            return _one_of(typed.strip(), self.schema["enum"])
        value = _converted(typed, _kind(self.schema))
        if why := self._misfit(value):
            raise ValueError(why)
        return value

    def _misfit(self, value: Any) -> str:
        """Why the schema takes no such value here, whatever the other parameters are; empty if it does."""
        alone = {word: self.whole[word] for word in ("properties", "$defs") if word in self.whole}
        return parameter_faults(alone, {self.name: value}).removeprefix("$.")


def blanks(offer: Offer) -> tuple[Blank, ...]:
    """The parameters of an option, in the order written."""
    schema = offer.parameters or {}
    properties, required = schema.get("properties", {}), schema.get("required", [])
    return tuple(
        Blank(name, field if isinstance(field, Mapping) else {}, name in required, schema)
        for name, field in properties.items()
    )


def _kind(schema: Mapping[str, Any]) -> str:
    kind = schema.get("type", "")
    return kind if isinstance(kind, str) else ""


def _range(schema: Mapping[str, Any]) -> str:
    """`1 to 9`, for a number with bounds."""
    least, most = schema.get("minimum"), schema.get("maximum")
    if least is None:
        return "" if most is None else f"at the most {most}"
    return f"{least} or more" if most is None else f"{least} to {most}"


def _shown(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _one_of(typed: str, values: Sequence[Any]) -> Any:
    for value in values:
        if typed == _shown(value):
            return value
    raise ValueError(f"'{cut(typed, 60)}' is none of {', '.join(map(_shown, values))}")


def _converted(typed: str, kind: str) -> Any:
    text = typed.strip()
    if kind == "string":
        return typed
    if kind == "boolean":
        if text.lower() not in TRUTHS:
            raise ValueError(f"'{cut(text, 60)}' is neither yes nor no")
        return TRUTHS[text.lower()]
    value = json_value(text, None if kind else text)
    if kind == "integer" and not (is_number(value) and float(value).is_integer()):
        raise ValueError(f"'{cut(text, 60)}' is no whole number")
    if kind == "number" and not is_number(value):
        raise ValueError(f"'{cut(text, 60)}' is no number")
    if kind in ("array", "object") and not isinstance(value, list if kind == "array" else dict):
        raise ValueError(f"'{cut(text, 60)}' is no JSON {kind}")
    return int(value) if kind == "integer" else value
