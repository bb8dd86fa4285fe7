# SPDX-License-Identifier: Apache-2.0
"""A simulated robot and its surroundings, as a connector's peer.

Rule: a world keeps no clock but its own simulated time, and the same seed and the same calls give the same run, to the
bit.
"""

from __future__ import annotations

import importlib
import inspect
import json
import math
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from types import UnionType
from typing import Any, Protocol, Union, get_args, get_origin, get_type_hints

from rai_missions.connectors.connector import Connector
from rai_missions.errors import UsageError, install_command, suggestion
from rai_missions.kinds import PackageOffer, known_names, offered
from rai_missions.worlds.options import check_names

__all__ = (
    "WORLDS",
    "World",
    "check_local",
    "check_world",
    "continued_options",
    "load_world",
    "open_world",
    "put_on",
    "world_offer",
)

GROUP = "rai_missions.worlds"
WORLDS: Mapping[str, str] = {
    "desk": "rai_missions.worlds.desk:Desk",
    "house": "rai_missions.worlds.house:House",
    "orchard": "rai_missions.worlds.orchard:Orchard",
}
"""Ours: name → module and class, imported when the world is opened."""


SORTS: Mapping[Any, tuple[tuple[type, ...], str]] = {
    bool: ((bool,), "true or false"),
    int: ((int,), "a whole number"),
    float: ((int, float), "a finite number"),
    str: ((str,), "text"),
}
"""Type of an option → what it takes, and what that is called."""


class World(Protocol):
    """A simulated robot and its surroundings: a profile names it, and the run's clock steps it."""

    period_s: float
    """How far one step goes: messages, services and control happen at this grain."""

    @property
    def at(self) -> float:
        """What its clock shows, simulated seconds: 0 at the start, or the option `start_s`."""

    def open(self, connector: Connector) -> None:
        """Put the robot's topics, services and actions on a connector."""

    def step(self) -> None:
        """Go one period on, publishing what happened."""

    def close(self) -> None:
        """Free what is held (renderers, windows)."""


def world_offer(name: str) -> PackageOffer | None:
    """Who has the world of a name; None where no package does.

    Raises:
        UsageError: Two packages do.
    """
    return offered(GROUP, name, WORLDS)


def check_world(name: str) -> PackageOffer:
    """Who has the world of a name.

    Raises:
        UsageError: No one, or two packages do.
    """
    offer = world_offer(name)
    if offer is None:
        raise UsageError(f"there is no world {name!r}{suggestion(name, known_names(GROUP, WORLDS))}")
    return offer


def open_world(name: str, **options: Any) -> World:
    """Make a world.

    Args:
        name: One of `WORLDS`, or of those that other packages offer.
        options: What the world's class takes, such as `seed=7`.

    Raises:
        UsageError: No such world or option, an option's value does not fit, the packages that the world needs are
            not installed, or another package makes something else than a world.
    """
    offer = check_world(name)
    make = _checked(name, _class_of(name, offer), options)
    try:
        with _opening(name, offer):
            made: World = offer.keeping(World, make(**options))
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise UsageError(f"{_not_opened(name, options)}: {error}") from error
    return made


def load_world(name: str) -> Any:
    """A world's class, or the function that makes it.

    Raises:
        UsageError: No such world, or the packages that it needs are not installed.
    """
    return _class_of(name, check_world(name))


def continued_options(name: str, options: Mapping[str, Any], at: float) -> dict[str, Any]:
    """The options of a world whose clock continues at this time, in which a run is resumed.

    Raises:
        UsageError: As `load_world`, or its clock always starts at 0.
    """
    if "start_s" not in inspect.signature(load_world(name)).parameters:
        raise UsageError(
            f"{check_world(name)} takes no option 'start_s', at which its clock would continue: a run in it is not "
            "resumed; start a new one"
        )
    return {**options, "start_s": at}


def put_on(connector: Connector, name: str, world: World) -> None:
    """Have the world of a name put its robot on a connector.

    Raises:
        UsageError: One of another package has raised.
    """
    with _opening(name, check_world(name)):
        world.open(connector)


def _opening(name: str, offer: PackageOffer) -> AbstractContextManager[None]:
    """Opens a world inside; what ours raises is for its caller."""
    return offer.opening() if name not in WORLDS else nullcontext()


def check_local(options: Mapping[str, Any]) -> None:
    """Check what a profile states of a connector of kind `local` besides its kind; a world of ours is made for it.

    What the packages of this machine do not let load is not checked; nor is, of a world of another package, what an
    object or a list holds.

    Raises:
        UsageError: No such world or option, or an option's value does not fit.
    """
    given = dict(options)
    name = given.pop("world", None)
    if name is None:
        check_names("connector", given, ("world",), called="option")
        return
    offer = check_world(str(name))
    try:
        world = _class_of(str(name), offer)
    except UsageError:
        return
    _checked(str(name), world, given)
    if name in WORLDS:
        open_world(str(name), **{**given, "camera": False}).close()


def _class_of(name: str, offer: PackageOffer) -> Any:
    """A world's class, or the function that makes it.

    Raises:
        UsageError: It does not load.
    """
    return offer.load() if name not in WORLDS else _ours(name)


def _checked(name: str, world: Any, options: Mapping[str, Any]) -> Any:
    """The class of a world, once its options exist and have values of their types.

    Raises:
        UsageError: One has not.
    """
    known = list(inspect.signature(world).parameters)
    unknown = sorted(set(options) - set(known))
    if unknown:
        raise UsageError(f"the world {name!r} has no option {unknown[0]!r}; there are: {', '.join(known)}")
    _check_sorts(name, world, options)
    return world


def _ours(name: str) -> Any:
    """The class of one of our own worlds.

    Raises:
        UsageError: The packages that it needs are not installed, or nothing can be drawn.
    """
    module, _, class_name = WORLDS[name].partition(":")
    try:
        return getattr(importlib.import_module(module), class_name)
    except ModuleNotFoundError as fault:
        raise UsageError(
            f"the world {name!r} needs the package {fault.name!r} (Python 3.11 or newer): {install_command('sim')}"
        ) from fault
    except (ImportError, AttributeError, OSError, RuntimeError) as fault:
        raise UsageError(
            f"the world {name!r} cannot be drawn without a display ({fault}): install EGL (Debian: apt-get install "
            "libegl1 libgl1 libgl1-mesa-dri), or do without pictures: MUJOCO_GL=disabled and camera=False"
        ) from fault


def _check_sorts(name: str, world: Any, options: Mapping[str, Any]) -> None:
    """Whether each option has a value of its type; what an object or a list holds is the world's affair.

    Raises:
        UsageError: One has not; all such are reported at once.
    """
    takes = get_type_hints(world.__init__)
    wrong = [
        f"{option} takes {why}" for option, value in options.items() if (why := _mismatch(takes.get(option), value))
    ]
    if wrong:
        raise UsageError(f"{_not_opened(name, options)}: {', '.join(wrong)}")


def _not_opened(name: str, options: Mapping[str, Any]) -> str:
    given = ", ".join(f"{option}={json.dumps(value, default=repr)}" for option, value in options.items())
    return f"the world {name!r} cannot be opened with {given}"


def _mismatch(taken: Any, value: Any) -> str:
    """What an option takes, if that is not a value of this type; else empty."""
    kinds = get_args(taken) if get_origin(taken) in (Union, UnionType) else (taken,)
    sorts = [get_origin(each) or each for each in kinds]
    if len(sorts) == 1 and sorts[0] in SORTS:
        fitting, called = SORTS[sorts[0]]
        fits = isinstance(value, fitting) and (sorts[0] is bool or not isinstance(value, bool))
        return "" if fits and not (isinstance(value, float) and not math.isfinite(value)) else called
    is_taken = type(value) in sorts or Sequence in sorts
    is_object = Mapping in sorts and isinstance(value, str | int | float) and not is_taken
    return "an object" if is_object else ""
