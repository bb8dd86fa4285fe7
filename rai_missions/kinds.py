# SPDX-License-Identifier: Apache-2.0
"""Where kinds are found: this package's own in its folders, those of other packages by entry points.

Rule: nothing of another package is loaded before a file or an option names it.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, NamedTuple

from rai_missions.errors import MissionError, UsageError, raised_text
from rai_missions.redaction import shown

if TYPE_CHECKING:
    from importlib.metadata import Distribution

__all__ = ("PackageOffer", "known_names", "lacking", "load_kinds", "named", "offered", "offers")

OURS = "rai-missions"


def load_kinds(package: str, folders: Iterable[str]) -> None:
    """Import every module of a package: a file with a kind in it need not be listed anywhere."""
    for module in iter_modules(folders):
        import_module(f"{package}.{module.name}")


class PackageOffer(NamedTuple):
    """Something that a package offers under a name, by an entry point."""

    group: str
    """`rai_missions.guards`, `.activities`, `.connectors`, `.worlds`, `.answerers`, `.exporters` and others."""
    name: str
    package: str
    version: str
    value: str
    """`module:attribute`."""

    def __str__(self) -> str:
        return f"the {_sort(self.group)} '{self.name}' of {self.package} {self.version}"

    def keeping(self, protocol: type[Any], made: Any) -> Any:
        """What it opened, which has every member of its protocol.

        Raises:
            UsageError: One is missing; with name and package.
        """
        members = (*protocol.__annotations__, *(each for each in vars(protocol) if not each.startswith("_")))
        if absent := next((each for each in members if not hasattr(made, each)), ""):
            sort = _sort(self.group)
            raise UsageError(f"{self} opens {shown(made)}, which is no {sort}: it lacks '{absent}'")
        return made

    def load(self) -> Any:
        """What is offered.

        Raises:
            UsageError: It does not load.
        """
        from importlib.metadata import EntryPoint

        try:
            return EntryPoint(self.name, self.value, self.group).load()
        except (Exception, SystemExit) as error:
            raise UsageError(f"{self} does not load ({raised_text(error)})") from error

    @contextmanager
    def opening(self) -> Iterator[None]:
        """Opens it inside: what its code raises refuses it by its name and package.

        Raises:
            UsageError: Its code has raised; a `MissionError` of its own is passed on as it is.
        """
        try:
            yield
        except MissionError:
            raise
        except (Exception, SystemExit) as error:
            raise UsageError(f"{self} cannot be opened ({raised_text(error)})") from error


def _sort(group: str) -> str:
    """What a group offers, in a word."""
    word = group.partition(".")[2]
    return "activity" if word == "activities" else word.removesuffix("s")


def offered(group: str, name: str, ours: Mapping[str, str]) -> PackageOffer | None:
    """Who offers a name: this package itself, which no other can shadow, else an installed one; None if none does.

    Args:
        group: Of entry points.
        name: What a file or an option names.
        ours: Name → `module:attribute`, of this package's own.

    Raises:
        UsageError: Two packages offer it.
    """
    if name in ours:
        return PackageOffer(group, name, OURS, "", ours[name])
    found = [each for each in offers(group) if each.name == name]
    if len(found) > 1:
        both = " and ".join(sorted(f"{each.package} {each.version}" for each in found))
        raise UsageError(f"the {_sort(group)} '{name}' is offered by {both}; uninstall one of them")
    return found[0] if found else None


def offers(group: str) -> tuple[PackageOffer, ...]:
    """What installed packages offer in a group; nothing of it is loaded."""
    return tuple(each for each in _offers(_places()) if each.group == group)


def known_names(group: str, ours: Iterable[str]) -> tuple[str, ...]:
    """The names that a file or an option may give, this package's own and those of installed ones; none is loaded."""
    return tuple(sorted({*ours, *(each.name for each in offers(group))}))


def _places() -> tuple[str, ...]:
    """Where packages are installed: the working directory is no such place."""
    return tuple(each for each in sys.path if each and not _is_here(each))


def _is_here(folder: str) -> bool:
    try:
        return os.path.samefile(folder, ".")  # also where the working directory was removed
    except OSError:
        return False


@cache
def _offers(path: tuple[str, ...]) -> tuple[PackageOffer, ...]:
    return tuple(
        PackageOffer(entry.group, entry.name, name, distribution.version, entry.value)
        for name, distribution in _installed(path).items()
        for entry in distribution.entry_points
        if entry.group.startswith("rai_missions.") and name != OURS
    )


@cache
def _installed(path: tuple[str, ...]) -> Mapping[str, Distribution]:
    """Package → its metadata."""
    from importlib.metadata import distributions  # slow to import

    found: dict[str, Distribution] = {}
    for distribution in distributions(path=list(path)):
        name = distribution.metadata["Name"]
        if name:
            found.setdefault(_normal(name), distribution)  # as with modules, the first on the path counts
    return found


def _normal(name: str) -> str:
    """A package's name as names are compared (PEP 503)."""
    return re.sub(r"[-_.]+", "-", name).lower()


def named(requirement: str) -> str:
    """The package that a requirement names, as packages are compared."""
    return _normal(re.split(r"[^A-Za-z0-9._-]", requirement, maxsplit=1)[0])


def lacking(requirement: str) -> str:
    """Why a requirement, `package>=1`, is not met here; empty if it is."""
    from packaging.requirements import InvalidRequirement, Requirement

    try:
        wanted = Requirement(requirement)
    except InvalidRequirement:
        return f"'{requirement}' names no package; write 'package' or 'package>=1'"
    if wanted.url or wanted.marker or wanted.extras:
        return f"'{requirement}' has more than a package and its version; write 'package>=1'"
    there = _installed(_places()).get(_normal(wanted.name))
    if there is None:
        return f"the package '{wanted.name}' is not installed; pip install '{requirement}'"
    if not wanted.specifier.contains(there.version, prereleases=True):
        return f"the package '{wanted.name}' is installed in version {there.version}, and {wanted.specifier} is needed"
    return ""
