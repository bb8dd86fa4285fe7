# SPDX-License-Identifier: Apache-2.0
"""What a person writes for a world, checked: names that there are, and numbers within bounds."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from rai_missions.errors import UsageError, suggestion
from rai_missions.plain_data import is_number

__all__ = ("check_detector_options", "check_names", "check_number", "check_numbers", "is_down")


def check_names(what: str, given: Iterable[Any], known: Collection[str], *, called: str = "field") -> None:
    """Check that what is named exists.

    Args:
        what: The option that holds the names.
        given: The names.
        known: Those that there are.
        called: What one of them is.

    Raises:
        UsageError: One does not exist.
    """
    for name in given:
        if name not in known:
            raise UsageError(f"{what}: no {called} {name!r}{suggestion(str(name), known)}")


def check_number(place: str, value: Any, least: float, most: float) -> None:
    """Check that a value is a number within bounds.

    Raises:
        UsageError: It is none.
    """
    if not is_number(value) or not least <= value <= most:
        raise UsageError(f"{place} takes a number from {least:.9g} to {most:.9g}, not {value!r}")


def check_numbers(what: str, options: Mapping[str, Any], most: Mapping[str, float]) -> None:
    """Check options that are numbers from 0 on.

    Args:
        what: Whose options.
        options: Option → value.
        most: The options that there are → the largest value of each.

    Raises:
        UsageError: An option does not exist or is out of range.
    """
    check_names(what, options, most, called="option")
    for name, value in options.items():
        check_number(f"{what}: {name}", value, 0, most[name])


def check_detector_options(options: Mapping[str, Any], most: Mapping[str, float]) -> None:
    """Check the options of a simulated detector, given as plain data.

    Args:
        options: Option → value; `down` is when the detector is silent, two seconds from and until.
        most: The numeric options → the largest value of each; the least is 0.

    Raises:
        UsageError: An option does not exist or is out of range.
    """
    check_names("detector", options, (*most, "down"), called="option")
    check_numbers("detector", {name: value for name, value in options.items() if name != "down"}, most)
    down = options.get("down", (0, 0))
    if not (isinstance(down, list | tuple) and len(down) == 2 and down[0] <= down[1]):
        raise UsageError(f"detector: down takes when it begins and ends, as in [20, 60], not {down!r}")


def is_down(down: tuple[float, float] | None, since_s: float) -> bool:
    """Whether a detector is silent so long after the start; see `check_detector_options`."""
    return down is not None and down[0] <= since_s < down[1]
