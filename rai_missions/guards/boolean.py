# SPDX-License-Identifier: Apache-2.0
"""All, any and not, in Kleene's logic: unknown stays unknown unless the rest decides.

Source: S. C. Kleene, Introduction to Metamathematics (1952), section 64, the strong three-valued connectives.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from rai_missions.guards.guard import Guard, Site, Test, Truth, View
from rai_missions.model import OneOf

__all__ = ("All", "Any_", "Not")


def _flat(word: str) -> BeforeValidator:
    """Takes a list of guards; a nested one of the same kind counts as its members."""

    def flatten(given: Any) -> Any:
        if not isinstance(given, list | tuple):
            return given
        flat: list[Any] = []
        for item in given:
            if isinstance(item, dict) and set(item) == {word} and isinstance(item[word], list):
                flat += flatten(item[word])
            elif isinstance(item, Guard) and item.word == word:
                flat += item.inner()
            else:
                flat.append(item)
        return tuple(flat)

    return BeforeValidator(flatten)


GUARD = OneOf[Guard]


class All(Guard, word="all"):
    """True where each is true, false where one is false, else unknown. An empty one is true."""

    positional: ClassVar = ("all",)

    all: Annotated[tuple[GUARD, ...], _flat("all")]

    def compile(self, site: Site) -> Test:
        return conjunction([guard.compile(site) for guard in self.all], deciding=False)

    def inner(self) -> Iterator[Guard]:
        yield from self.all

    def words(self) -> str:
        return " and ".join(_wrapped(guard) for guard in self.all) or "always"


class Any_(Guard, word="any"):  # noqa: N801 - `Any` is typing's
    """True where one is true, false where each is false, else unknown. An empty one is false."""

    positional: ClassVar = ("any",)

    any: Annotated[tuple[GUARD, ...], _flat("any")]

    def compile(self, site: Site) -> Test:
        return conjunction([guard.compile(site) for guard in self.any], deciding=True)

    def inner(self) -> Iterator[Guard]:
        yield from self.any

    def words(self) -> str:
        return " or ".join(_wrapped(guard) for guard in self.any) or "never"


class Not(Guard, word="not"):
    """True where the guard is false, false where it is true, else unknown."""

    positional: ClassVar = ("guard",)

    guard: GUARD = Field(alias="not")

    def compile(self, site: Site) -> Test:
        inner = self.guard.compile(site)

        def test(view: View) -> Truth:
            value = inner(view)
            return None if value is None else not value

        return test

    def inner(self) -> Iterator[Guard]:
        yield self.guard

    def words(self) -> str:
        return f"not {_wrapped(self.guard)}"


def _wrapped(guard: Guard) -> str:
    return f"({guard.words()})" if isinstance(guard, All | Any_) else guard.words()


def conjunction(tests: list[Test], *, deciding: bool) -> Test:
    """The strong connective in which one value decides: false for `all`, true for `any`."""

    def test(view: View) -> Truth:
        unknown = False
        for each in tests:
            value = each(view)
            if value is deciding:
                return deciding
            unknown = unknown or value is None
        return None if unknown else not deciding

    return test
