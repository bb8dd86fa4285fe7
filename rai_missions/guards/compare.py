# SPDX-License-Identifier: Apache-2.0
"""A key against a value or another key: `{"key": "battery", "<": 0.15}`."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Self

from pydantic import Field, model_validator

from rai_missions.guards.guard import Guard, Operand, Site, Test, Truth, View
from rai_missions.model import Json, Path, fault

__all__ = ("Compare",)

OPERATORS: Mapping[str, Callable[[Any, Any], Any]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "in": lambda left, right: left in right,
}
SAID = {"==": "is", "!=": "is not", "<": "<", "<=": "≤", ">": ">", ">=": "≥", "in": "is one of"}


class Compare(Guard, word="key"):
    """A comparison; unknown where a side is missing, stale or of another type."""

    key: Path
    equal: Json = Field(default=None, alias="==")
    unequal: Json = Field(default=None, alias="!=")
    less: Json = Field(default=None, alias="<")
    at_most: Json = Field(default=None, alias="<=")
    greater: Json = Field(default=None, alias=">")
    at_least: Json = Field(default=None, alias=">=")
    within: Json = Field(default=None, alias="in")

    WORDS: ClassVar[Mapping[str, str]] = {
        "==": "equal", "!=": "unequal", "<": "less", "<=": "at_most", ">": "greater", ">=": "at_least", "in": "within",
    }  # fmt: skip

    @model_validator(mode="after")
    def _one_operator(self) -> Self:
        given = [word for word, field in self.WORDS.items() if getattr(self, field) is not None]
        if len(given) != 1:
            raise fault(
                "operator",
                f"a comparison has one of {', '.join(self.WORDS)}, this has {', '.join(given) if given else 'none'}",
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
        if isinstance(operand, Mapping) and len(operand) == 1:
            path = operand.get("key", operand.get("from"))
            return path if isinstance(path, str) else None
        return None

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

    def words(self) -> str:
        operand = self.other or _said(self.operand)
        return f"{self.key} {SAID[self.op]} {operand}"


def _said(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return ", ".join(_said(item) for item in value)
    return str(value)


def _plain(key: str, apply: Callable[[Any, Any], Any], value: Any, *, equality: bool) -> Test:
    """The common case made short: a whole key that never goes stale, against a value."""
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


def truth(apply: Callable[[Any, Any], Any], left: Any, right: Any, *, equality: bool) -> Truth:
    """What a comparison says; unknown where the two cannot be compared."""
    if left is None or right is None or left != left or right != right:
        return None
    if equality and isinstance(left, bool) is not isinstance(right, bool):
        return None
    try:
        return bool(apply(left, right))
    except TypeError:
        return None
