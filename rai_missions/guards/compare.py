# SPDX-License-Identifier: Apache-2.0
"""A key against a value or another key: `{"key": "battery", "<": 0.15}`."""

from __future__ import annotations

import json
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, NamedTuple, Self

from pydantic import Field, model_validator

from rai_missions.errors import suggestion
from rai_missions.guards.analysis import Distinctions, Sources, TypeFault, Types
from rai_missions.guards.at_once import asked_at_once
from rai_missions.guards.expression import SIGNS
from rai_missions.guards.form import Atom, Form
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Operand, Site, Test, Truth, View
from rai_missions.model import Json, KeyPath, Path, Value, fault
from rai_missions.model.references import OPERAND, OPERAND_WORDS, reference_word
from rai_missions.plain_data import is_numeric
from rai_missions.redaction import clipped

__all__ = ("OPERATORS", "OPPOSITES", "ORDERED", "Compare", "Operator", "comparable", "holds")

OperandValue = Annotated[Json, OPERAND]


def _is_one_of(value: Any, listed: Any) -> bool:
    """Whether a list has a value, as `==` has it: true is not 1.

    Raises:
        TypeError: It is no list; a text has parts, and an object names, which are no items.
    """
    if not isinstance(listed, list | tuple):
        raise TypeError(listed)
    return value in listed and any(_equal(value, item) for item in listed)


def _equal(one: Any, other: Any) -> bool:
    return isinstance(one, bool) is isinstance(other, bool) and bool(one == other)


class Operator(NamedTuple):
    """How a key is compared: all that there is to one word of `{"key": …}`, next to its field in `Compare`."""

    field: str
    """Its field in `Compare`."""
    symbol: str
    """As a picture has it."""
    opposite: str
    """The operator of a form that is true exactly where this one is false, of values that are known."""
    apply: Callable[[Any, Any], Any]
    orders: bool = False
    """It takes values that have an order."""
    takes_list: bool = False
    """Its operand is a list, or a key that holds one."""


OPERATORS: Mapping[str, Operator] = {
    "==": Operator("equal", "is", "!=", operator.eq),
    "!=": Operator("unequal", "is not", "==", operator.ne),
    "<": Operator("less", "<", ">=", operator.lt, orders=True),
    "<=": Operator("at_most", "≤", ">", operator.le, orders=True),
    ">": Operator("greater", ">", "<=", operator.gt, orders=True),
    ">=": Operator("at_least", "≥", "<", operator.ge, orders=True),
    "in": Operator("within", "is one of", "not in", _is_one_of, takes_list=True),
}
ORDERED = frozenset(word for word, each in OPERATORS.items() if each.orders)
OPPOSITES = {word: each.opposite for word, each in OPERATORS.items()} | {"not in": "in"}
"""Operator → its opposite, of forms: those have `not in` too."""


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

    def __init__(
        self,
        key: KeyPath,
        *,
        equal: Value = None,
        unequal: Value = None,
        less: Value = None,
        at_most: Value = None,
        greater: Value = None,
        at_least: Value = None,
        within: Value = None,
    ) -> None: ...

    @model_validator(mode="after")
    def _one_operator(self) -> Self:
        given = [word for word, each in OPERATORS.items() if getattr(self, each.field) is not None]
        if len(given) != 1:
            raise fault(
                "operator",
                f"a comparison has one of {', '.join(OPERATORS)}, this has {', '.join(given) if given else 'none'};"
                f" write it like {self.example % '<'}",
            )
        if self._operator.takes_list and self.other is None and not isinstance(self.operand, list):
            raise fault("operator", f"'{self.op}' takes a list of values or a key that holds one, not {self.operand!r}")
        return self

    @property
    def op(self) -> str:
        """The operator as it is written."""
        return next(word for word, each in OPERATORS.items() if getattr(self, each.field) is not None)

    @property
    def _operator(self) -> Operator:
        return OPERATORS[self.op]

    @property
    def operand(self) -> Any:
        """What the key is compared with: a JSON value, or the path of `other`."""
        return getattr(self, self._operator.field)

    @property
    def other(self) -> str | None:
        """The path of the other key, where it is compared with one."""
        operand = self.operand
        word = reference_word(operand, OPERAND_WORDS)
        return None if word is None else str(operand[word])

    def compile(self, site: Site) -> Test:
        left, apply, other = Operand(self.key, site), self._operator.apply, self.other
        equality = self.op in ("==", "!=")
        if other is not None:
            right = Operand(other, site)
            return self._at_once(lambda view: truth(apply, left.read(view), right.read(view), equality=equality), site)
        value = self.operand
        if not left.fields and not left.passing and left.max_age_s is None:
            return _plain(left.key, apply, value, equality=equality)
        return self._at_once(lambda view: truth(apply, left.read(view), value, equality=equality), site)

    def _at_once(self, test: Test, site: Site) -> Test:
        """Where each value counts, a field is asked for instead: then its answer is known to other guards, too."""
        return test if site.counts is None else asked_at_once(self, test, site, site.counts)

    def looked_into(self) -> str:
        key, _, field = self.key.partition(".")
        return key if field and (self.other is None or self.other.startswith(f"{key}.")) else ""

    def type_faults(self, types: Types) -> Iterator[TypeFault]:
        kind = types.kind(self.key)
        if kind is not None and (sentence := self._misfit(kind, types)):
            yield TypeFault("/key", sentence)
            return
        if kind is None or self.other is None or not self._operator.takes_list:
            return
        if (other := types.kind(self.other)) not in (None, "list"):
            sentence = f"'{self.op}' takes a list, and '{self.other}' is of type '{other}'; compare with =="
            yield TypeFault(f"/{self.op}", sentence)

    def _misfit(self, kind: str, types: Types) -> str:
        """Why it cannot be evaluated for a value of a type; empty if it can."""
        path, op = self.key, self._operator
        if kind == "image":
            remedy = f'ask for {{"fresh": "{path}"}}, or compare a key that holds what is seen'
            return f"'{path}' is an image, which cannot be compared; {remedy}"
        if op.orders and kind not in ("number", "integer", "string"):
            return f"'{path}' is of type '{kind}', which has no order; compare it with == or !="
        if self.other is not None:
            other = types.kind(self.other)
            if not op.takes_list and other is not None and not comparable(kind, other):
                return f"'{path}' is of type '{kind}' and '{self.other}' of type '{other}'; compare keys of one type"
            return ""
        if op.takes_list:
            wrong = [item for item in self.operand if not _can_be(kind, item)]
            if not wrong:
                return self._unlisted(types.listed(path))
            return f"'{path}' is of type '{kind}' and never {json_text(wrong[0])}; list values of that type"
        if not _can_be(kind, self.operand):
            given = f"{json_text(self.operand)} is of type '{_type_of(self.operand)}'"
            return f"'{path}' is of type '{kind}', and {given}; compare with a value of its type"
        return "" if op.orders else self._unlisted(types.listed(path))

    def _unlisted(self, listed: Sequence[str] | None) -> str:
        """Why the value is none that the argument takes; empty if it is one."""
        values = self.operand if self._operator.takes_list else [self.operand]
        if listed is None or not (wrong := [each for each in values if each not in listed]):
            return ""
        return f"'{self.key}' is never {json_text(wrong[0])}{suggestion(str(wrong[0]), listed)}"

    def form(self, wanted: bool, depth: int) -> Form:
        op, operand = self.op if wanted else OPPOSITES[self.op], self.operand
        if isinstance(operand, bool) and op == "!=":
            op, operand = "==", not operand  # a boolean that is not the one is the other, or unknown
        return Atom("compare", self.key, op, _hashable(operand), self.other)

    def rests(self, sources: Sources, *, wanted: bool = True) -> bool:
        """Whether the guard rests on the robot: it does if no constant of the author would make it hold."""
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
        else:
            by.compare(self.key, self.op, self.operand)

    def words(self) -> str:
        operand = self.other or _in_words(self.operand)
        return f"{self.key} {self._operator.symbol} {operand}"


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
    if type(value) is int or type(value) is float:
        return _number(key, apply, value, equality=equality)

    def test(view: View) -> Truth:
        board = view.board
        return truth(apply, board[key][0], value, equality=equality) if key in board else None

    return test


def _number(key: str, apply: Callable[[Any, Any], Any], value: float, *, equality: bool) -> Test:
    """The test of a comparison with a number."""

    def test(view: View) -> Truth:
        board = view.board
        if key not in board:
            return None
        left = board[key][0]
        kind = type(left)
        if kind is int or kind is float:
            return apply(left, value)  # type: ignore[no-any-return]
        return truth(apply, left, value, equality=equality)

    return test


def _is_flag(key: str, value: bool) -> Test:
    """The test of a boolean key against true or false."""

    def test(view: View) -> Truth:
        board = view.board
        if key not in board:
            return None
        left = board[key][0]
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
        return is_numeric(value)
    if kind in ("object", "pose"):
        return isinstance(value, dict)
    return _type_of(value) == kind


def _hashable(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(_hashable(item) for item in value)
    return json.dumps(value, sort_keys=True, default=str) if isinstance(value, dict) else value


def holds(value: Any, op: str, operand: Any) -> bool:
    """Whether a comparison of two constants is true."""
    if op in ("==", "!="):
        return isinstance(value, bool) is isinstance(operand, bool) and _equal(value, operand) is (op == "==")
    try:
        if op == "not in":
            return not _is_one_of(value, operand)
        return bool(OPERATORS[op].apply(value, operand))
    except TypeError:
        return False
