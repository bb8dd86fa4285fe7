# SPDX-License-Identifier: Apache-2.0
"""All, any and not, in Kleene's logic: unknown stays unknown unless the rest decides.

Source: S. C. Kleene, Introduction to Metamathematics (1952), section 64, the strong three-valued connectives.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Annotated, ClassVar

from pydantic import AfterValidator, Field

from rai_missions.guards.analysis import Sources
from rai_missions.guards.at_once import asked_at_once
from rai_missions.guards.form import Form, Junction
from rai_missions.guards.guard import Guard, GuardOrKey, form_of, made
from rai_missions.guards.implication import never
from rai_missions.guards.view import Site, Test, Truth, View
from rai_missions.model import AnyOf

__all__ = ("All", "Any_", "Not")


def _flat(word: str) -> AfterValidator:
    """A validator that puts the members of a nested guard of the same kind in its place, once each was read."""

    def flatten(given: tuple[Guard, ...]) -> tuple[Guard, ...]:
        return tuple(each for guard in given for each in (guard.inner() if guard.word == word else (guard,)))

    return AfterValidator(flatten)


GUARD = AnyOf[Guard]


class _Junction(Guard):
    """Guards of which one value decides."""

    deciding: ClassVar[bool]
    """The value of one part that decides the whole."""
    empty: ClassVar[str]
    """How one without parts is called."""

    def compile(self, site: Site) -> Test:
        counts = self.counts_inside(site.counts)
        if self.looked_into() in site.keys:
            test = conjunction([guard.compiled(site) for guard in self.inner()], deciding=self.deciding)
            return asked_at_once(self, test, site, counts)
        return conjunction([guard.compiled(site, counts) for guard in self._by_key(site)], deciding=self.deciding)

    def _by_key(self, site: Site) -> Iterator[Guard]:
        """The parts of this guard; those that look into one key are joined into one."""
        found: dict[str, list[Guard]] = {}
        for at, guard in enumerate(self.inner()):
            key = guard.looked_into()
            found.setdefault(key if key in site.keys else f"#{at}", []).append(guard)
        return (parts[0] if len(parts) == 1 else made(self.word, **{self.word: parts}) for parts in found.values())

    def looked_into(self) -> str:
        keys = {guard.looked_into() for guard in self.inner()}
        return keys.pop() if len(keys) == 1 else ""

    def counts_inside(self, counts: Truth) -> Truth:
        return counts

    def words(self) -> str:
        joined = f" {'or' if self.deciding else 'and'} ".join(_wrapped(guard) for guard in self.inner())
        return joined or self.empty

    def form(self, wanted: bool, depth: int) -> Form:
        parts = tuple(form_of(part, wanted, depth) for part in self.inner())
        return parts[0] if len(parts) == 1 else Junction("any" if self.deciding is wanted else "all", parts)

    def rests(self, sources: Sources, *, wanted: bool = True) -> bool:
        if never(self.form(not wanted, 0)):
            return False  # what is so in any case is reported by no one
        parts = (part.rests(sources, wanted=wanted) for part in self.inner())
        return all(parts) if self.deciding is wanted else any(parts)

    def noticed(self, *, wanted: bool = True) -> frozenset[str]:
        return frozenset[str]().union(*(part.noticed(wanted=wanted) for part in self.inner()))

    def after_jump(self, active: Callable[[str], Truth], *, restarted: bool) -> Truth:
        values = [part.after_jump(active, restarted=restarted) for part in self.inner()]
        return self.deciding if self.deciding in values else None if None in values else not self.deciding


class All(_Junction, word="all"):
    """True where each is true, false where one is false, else unknown. An empty one is true."""

    deciding: ClassVar = False
    empty: ClassVar = "always"

    all: Annotated[tuple[GUARD, ...], _flat("all")]
    """The guards of which each must be true."""

    def __init__(self, all: Sequence[GuardOrKey]) -> None: ...


class Any_(_Junction, word="any"):  # noqa: N801 - `Any` is typing's
    """True where one is true, false where each is false, else unknown. An empty one is false."""

    deciding: ClassVar = True
    empty: ClassVar = "never"

    any: Annotated[tuple[GUARD, ...], _flat("any")]
    """The guards of which one must be true."""

    def __init__(self, any: Sequence[GuardOrKey]) -> None: ...


class Not(Guard, word="not"):
    """True where the guard is false, false where it is true, else unknown."""

    guard: GUARD = Field(alias="not")
    """The guard that must be false."""

    def __init__(self, guard: GuardOrKey) -> None: ...

    def compile(self, site: Site) -> Test:
        inner = self.guard.compiled(site, self.counts_inside(site.counts))

        def test(view: View) -> Truth:
            value = inner(view)
            return None if value is None else not value

        return test

    def looked_into(self) -> str:
        return self.guard.looked_into()

    def counts_inside(self, counts: Truth) -> Truth:
        return None if counts is None else not counts

    def words(self) -> str:
        return f"not {_wrapped(self.guard)}"

    def form(self, wanted: bool, depth: int) -> Form:
        return form_of(self.guard, not wanted, depth)

    def rests(self, sources: Sources, *, wanted: bool = True) -> bool:
        return self.guard.rests(sources, wanted=not wanted)

    def noticed(self, *, wanted: bool = True) -> frozenset[str]:
        return self.guard.noticed(wanted=not wanted)

    def after_jump(self, active: Callable[[str], Truth], *, restarted: bool) -> Truth:
        value = self.guard.after_jump(active, restarted=restarted)
        return None if value is None else not value


def _wrapped(guard: Guard) -> str:
    return f"({guard.words()})" if isinstance(guard, _Junction) else guard.words()


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
