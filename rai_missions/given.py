# SPDX-License-Identifier: Apache-2.0
"""What a function is given: what is of no kind that it takes is refused in a sentence for its caller."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from functools import cache
from inspect import iscoroutinefunction
from pathlib import Path
from typing import Any

from typing_extensions import get_protocol_members, is_protocol

from rai_missions.errors import UsageError, uncalled
from rai_missions.event import Event
from rai_missions.redaction import shown

__all__ = ("check_event", "check_function", "check_given", "check_seconds", "given_names", "given_path")


def check_given(given: object, kinds: type | tuple[type, ...], taker: str, wanted: str, remedy: str = "") -> None:
    """Refuse what is of no kind that a function takes.

    True is no number, and a class is no instance of the protocol whose methods it has. No method of a protocol is an
    `async def`: nothing awaits it.

    Args:
        given: What a program gave.
        kinds: The classes that it may be of.
        taker: The function, or its argument, for the sentence: `load`.
        wanted: What it takes, in words: `the path of a file`.
        remedy: How one is made, for the end of the sentence.

    Raises:
        UsageError: It is of none.
    """
    kinds = kinds if isinstance(kinds, tuple) else (kinds,)
    if given.__class__ in kinds:  # as most are; a chart looks at each event that is not quick
        return
    if not _is_of(given, kinds):
        what = f"; {remedy}" if remedy else uncalled(given) or _lacking(given, kinds)
        raise UsageError(f"{taker} takes {wanted}, not {shown(given)}{what}")
    if name := _async_member(given, kinds):
        where = f"{type(given).__name__}.{name}"
        raise UsageError(
            f"{taker} takes {wanted} whose calls are not awaited: write `def`, not `async def`, for {where}"
        )


def check_function(given: object, taker: str, wanted: str, remedy: str = "") -> None:
    """Refuse what cannot be called; see `check_given`.

    Raises:
        UsageError: It cannot.
    """
    check_given(given, Callable, taker, wanted, remedy)  # type: ignore[arg-type]


def _is_of(given: object, kinds: tuple[type, ...]) -> bool:
    if isinstance(given, bool):
        return bool in kinds
    return any(_has_members(given, each) if _members(each) else isinstance(given, each) for each in kinds)


@cache
def _members(kind: type) -> tuple[str, ...]:
    """What a protocol names, sorted; empty for any other class."""
    return tuple(sorted(get_protocol_members(kind))) if is_protocol(kind) else ()


def _has_members(given: object, protocol: type) -> bool:
    """Whether an instance has what a protocol names; `isinstance` looks past a `__getattr__` from Python 3.12 on."""
    return not isinstance(given, type) and all(hasattr(given, name) for name in _members(protocol))


def _lacking(given: object, kinds: tuple[type, ...]) -> str:
    """`; it has no start, stop` for an object of a program that has some of a protocol; empty for all else."""
    asked = (name for each in kinds for name in _members(each))
    lacks = sorted(name for name in asked if not hasattr(given, name))
    return f"; it has no {', '.join(lacks)}" if lacks and hasattr(given, "__dict__") else ""


def _async_member(given: object, kinds: tuple[type, ...]) -> str:
    """The first method of a protocol that an object has as an `async def`; empty for none."""
    asked = (name for each in kinds for name in _members(each))
    return next((name for name in asked if iscoroutinefunction(getattr(given, name, None))), "")


def check_seconds(given: object, taker: str) -> None:
    """Refuse what is no instant on a run's clock; see `check_given`.

    Raises:
        UsageError: It is no number, or none that a clock shows.
    """
    check_given(given, (int, float), taker, "seconds, as a number")
    assert isinstance(given, int | float)
    if not abs(given) <= sys.float_info.max:
        raise UsageError(f"{taker} takes a finite number of seconds, not {shown(given)}")


def check_event(given: object, taker: str) -> None:
    """Refuse what is no event, or one whose fields are of other types; see `check_given`.

    Raises:
        UsageError: It is none, or a field of it is at fault.
    """
    if not isinstance(given, Event):
        raise UsageError(f"{taker} is sent an Event, not {shown(given)}; write Event('go', at=3.2)")
    check_given(given.name, str, "the name of an event", "text")
    check_seconds(given.at, f"the time of '{given.name}'")
    check_given(given.data, Mapping, "the data of an event", "a mapping of fields to values")
    if given.kind == "write" and "stamp" in given.data:
        check_seconds(given.data["stamp"], f"the stamp of '{given.name}'")
    check_given(given.kind, str, "the kind of an event", "text")
    check_given(given.number, int, "the number of an event", "a whole number")


def given_path(given: Any, taker: str) -> Path:
    """A path; see `check_given`.

    Raises:
        UsageError: It is none.
    """
    check_given(given, (str, os.PathLike), taker, "the path of a file")
    return Path(given)


def given_names(given: Any, taker: str, of: str) -> Mapping[str, Any]:
    """A mapping of names to what they name; see `check_given`.

    Args:
        given: What was given.
        taker: The function, or its argument.
        of: What the names are mapped to: `values`.

    Raises:
        UsageError: It is none, or a key of it is no text.
    """
    check_given(given, Mapping, taker, f"a mapping of names to {of}")
    for name in given:
        check_given(name, str, f"a key of {taker}", "a name, as text")
    names: Mapping[str, Any] = given
    return names
