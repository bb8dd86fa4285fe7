# SPDX-License-Identifier: Apache-2.0
"""A key against a value or another key: `{"key": "battery", "<": 0.15}`."""

from __future__ import annotations

import json
import operator
from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from rai_missions.guards.expression import SIGNS
from rai_missions.guards.form import Atom, Form
from rai_missions.guards.guard import Distinctions, Guard, Operand, Site, Sources, Test, Truth, TypeFault, Types, View
from rai_missions.kinds import OPERAND, OPERAND_WORDS, reference_word
from rai_missions.model import Json, KeyPath, Path, Value, fault
from rai_missions.redaction import clipped

__all__ = ("NEGATED", "Compare", "comparable", "holds", "json_text")

OperandValue = Annotated[Json, OPERAND]
OPERATORS: Mapping[str, Callable[[Any, Any], Any]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "in": lambda left, right: left in right,
}
NEGATED = {"==": "!=", "!=": "==", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}
SYMBOLS = {"==": "is", "!=": "is not", "<": "<", "<=": "≤", ">": ">", ">=": "≥", "in": "is one of"}


class Compare(Guard, word="key"):
    """A comparison; unknown where a side is missing, stale or of another type."""

    key: Path
    """The value that is compared: a key, or a field of one."""
    equal: OperandValue = Field(default=None, alias="==")
    """It is equal to this value or key."""
    unequal: OperandValue = Field(default=None, alias="!=")
    """It differs from this value or key."""
    less: OperandValue = Field(default=None, alias="<")
    """It is less than this number or key."""
    at_most: OperandValue = Field(default=None, alias="<=")
    """It is this number or key, or less."""
    greater: OperandValue = Field(default=None, alias=">")
    """It is more than this number or key."""
    at_least: OperandValue = Field(default=None, alias=">=")
    """It is this number or key, or more."""
    within: OperandValue = Field(default=None, alias="in")
    """It is one of this list, or of the list that this key holds."""

    example: ClassVar[str] = '{"key": "battery", "%s": 0.3}'
    meant: ClassVar[Mapping[str, str]] = SIGNS
    WORDS: ClassVar[Mapping[str, str]] = {
        "==": "equal", "!=": "unequal", "<": "less", "<=": "at_most", ">": "greater", ">=": "at_least", "in": "within",
    }  # fmt: skip

    def __init__(
        self, key: KeyPath, *, equal: Value = None, unequal: Value = None, less: Value = None, at_most: Value = None,
        greater: Value = None, at_least: Value = None, within: Value = None,
    ) -> None: ...  # fmt: skip

    @model_validator(mode="after")
    def _one_operator(self) -> Self:
        given = [word for word, field in self.WORDS.items() if getattr(self, field) is not None]
        if len(given) != 1:
            raise fault(
                "operator",
                f"a comparison has one of {', '.join(self.WORDS)}, this has {', '.join(given) if given else 'none'};"
                f" write it like {self.example % '<'}",
            )
        if given == ["in"] and not isinstance(self.within, list | Mapping):
            raise fault("operator", f"'in' takes a list of values or a key that holds one, not {self.within!r}")
        return self

    @property
    def op(self) -> str:
        """The operator as it is written."""
        return next(word for word, field in self.WORDS.items() if getattr(self, field) is not None)

    @property
    def operand(self) -> Any:
        """What the key is compared with: a JSON value, or the path of `other`."""
        return getattr(self, self.WORDS[self.op])

    @property
    def other(self) -> str | None:
        """The path of the other key, where it is compared with one."""
        operand = self.operand
        word = reference_word(operand, OPERAND_WORDS)
        return None if word is None else str(operand[word])

    def compile(self, site: Site) -> Test:
        left, apply, other = Operand(self.key, site), OPERATORS[self.op], self.other
        equality = self.op in ("==", "!=")
        if other is not None:
            right = Operand(other, site)
            return lambda view: truth(apply, left.read(view), right.read(view), equality=equality)
        value = self.operand
        if not left.fields and not left.passing and left.max_age_s is None:
            return _plain(left.key, apply, value, equality=equality)
        return lambda view: truth(apply, left.read(view), value, equality=equality)

    def type_faults(self, types: Types) -> Iterator[TypeFault]:
        kind = types.kind(self.key)
        if kind is not None and (sentence := self._misfit(kind, types)):
            yield TypeFault("/key", sentence)
            return
        other = types.kind(self.other) if kind is not None and self.other is not None and self.op == "in" else None
        if other not in (None, "list"):
            yield TypeFault("/in", f"'in' takes a list, and '{self.other}' is of type '{other}'; compare with ==")

    def _misfit(self, kind: str, types: Types) -> str:
        """Why it cannot be evaluated for a value of a type; empty if it can."""
        path, op = self.key, self.op
        if kind == "image":
            remedy = f'ask for {{"fresh": "{path}"}}, or compare a key that holds what is seen'
            return f"'{path}' is an image, which cannot be compared; {remedy}"
        if op in ("<", "<=", ">", ">=") and kind not in ("number", "integer", "string"):
            return f"'{path}' is of type '{kind}', which has no order; compare it with == or !="
        if self.other is not None:
            other = types.kind(self.other)
            if op != "in" and other is not None and not comparable(kind, other):
                return f"'{path}' is of type '{kind}' and '{self.other}' of type '{other}'; compare keys of one type"
            return ""
        if op == "in":
            wrong = [item for item in self.operand if not _can_be(kind, item)]
            given = json_text(wrong[0]) if wrong else ""
            return f"'{path}' is of type '{kind}' and never {given}; list values of that type" if wrong else ""
        if not _can_be(kind, self.operand):
            given = f"{json_text(self.operand)} is of type '{_type_of(self.operand)}'"
            return f"'{path}' is of type '{kind}', and {given}; compare with a value of its type"
        return ""

    def form(self, wanted: bool, depth: int) -> Form:
        op, operand = self.op, self.operand
        if not wanted and op == "in":
            return Atom("compare", self.key, "not in", _hashable(operand), self.other)
        if not wanted:
            op = NEGATED[op]
        if isinstance(operand, bool) and op == "!=":
            op, operand = "==", not operand  # a boolean that is not the one is the other, or unknown
        return Atom("compare", self.key, op, _hashable(operand), self.other)

    def rests(self, sources: Sources, *, wanted: bool = True) -> bool:
        """It does if none of the author's own constants would do."""
        if self.other == self.key:
            return False
        if any(sources.is_robots(path) for path in self.paths()):
            return True
        values = sources.constants(self.key)
        if values is None:
            return False
        operands = [self.operand] if self.other is None else sources.known(self.other)
        return not any(holds(value, self.op, operand) is wanted for value in values for operand in operands)

    def distinguish(self, by: Distinctions) -> None:
        if self.other is not None:
            by.join(self.key, self.other, self.op)
        elif self.op == "in":
            for item in self.operand:
                by.compare(self.key, "==", item)
        else:
            by.compare(self.key, self.op, self.operand)

    def words(self) -> str:
        operand = self.other or _in_words(self.operand)
        return f"{self.key} {SYMBOLS[self.op]} {operand}"


def _in_words(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return ", ".join(_in_words(item) for item in value)
    return str(value)


def _plain(key: str, apply: Callable[[Any, Any], Any], value: Any, *, equality: bool) -> Test:
    """The common case made short: a whole key that never goes stale, against a value."""
    if value.__class__ is bool and apply is operator.eq:
        return _is_flag(key, value)
    number = isinstance(value, int | float) and not isinstance(value, bool)

    def test(view: View) -> Truth:
        entry = view.board.get(key)
        if entry is None:
            return None
        left = entry[0]
        if number and (left.__class__ is int or left.__class__ is float):
            return apply(left, value)  # type: ignore[no-any-return]
        return truth(apply, left, value, equality=equality)

    return test


def _is_flag(key: str, value: bool) -> Test:
    """The same for a key that is a boolean, and nothing else."""

    def test(view: View) -> Truth:
        entry = view.board.get(key)
        if entry is None:
            return None
        left = entry[0]
        return left is value if left is True or left is False else None

    return test


def truth(apply: Callable[[Any, Any], Any], left: Any, right: Any, *, equality: bool) -> Truth:
    """The truth of a comparison; unknown where the two cannot be compared."""
    if left is None or right is None or left != left or right != right:
        return None
    if equality and isinstance(left, bool) is not isinstance(right, bool):
        return None
    try:
        return bool(apply(left, right))
    except TypeError:
        return None


NUMBERS = ("number", "integer")


def comparable(one: str, other: str) -> bool:
    """Whether values of two types can be equal."""
    return one == other or (one in NUMBERS and other in NUMBERS)


def json_text(value: Any) -> str:
    """A value as JSON has it, cut short."""
    return clipped(json.dumps(value, ensure_ascii=False, default=str), 80)


def _type_of(value: Any) -> str:
    if isinstance(value, bool):
        return "boolean"
    named = {int: "integer", float: "number", str: "string", list: "list", dict: "object"}
    return named.get(type(value), "value")


def _can_be(kind: str, value: Any) -> bool:
    """Whether a value can be compared with one of a type."""
    if kind in NUMBERS:
        return isinstance(value, int | float) and not isinstance(value, bool)
    if kind in ("object", "pose"):
        return isinstance(value, dict)
    return _type_of(value) == kind


def _hashable(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(_hashable(item) for item in value)
    return json.dumps(value, sort_keys=True, default=str) if isinstance(value, dict) else value


def holds(value: Any, op: str, operand: Any) -> bool:
    """Whether a comparison of two constants is true."""
    if op == "in":
        return isinstance(operand, list | tuple) and any(_equal(value, item) for item in operand)
    if op == "not in":
        return isinstance(operand, list | tuple) and value not in operand  # as the engine has it: 1 is in [true]
    if op in ("==", "!="):
        return isinstance(value, bool) is isinstance(operand, bool) and _equal(value, operand) is (op == "==")
    try:
        return bool(OPERATORS[op](value, operand))
    except TypeError:
        return False


def _equal(one: Any, other: Any) -> bool:
    return isinstance(one, bool) is isinstance(other, bool) and bool(one == other)
