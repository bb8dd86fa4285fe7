# SPDX-License-Identifier: Apache-2.0
"""Writes `docs/architecture.md`: the rooms from the packages' docstrings, the walks of `docs/walks.toml` from the code.

    python scripts/walks.py           # hold the page to the code: exit 1 where they differ
    python scripts/walks.py --write   # write the page

A walk is a list of stays: functions or classes. Each is reached from the stay before it, or from the one named `by`:

- *down*, by a call: the other's module names it, and may import it by the floors of `pyproject.toml`;
- `up`, by a callback, a queue or a protocol: its module names what it registers for or implements, which is on its own
  floor or below and knows nothing of it.

What is not so, such as a function that has another name now, is a fault.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
WALKS, PAGE = ROOT / "docs/walks.toml", ROOT / "docs/architecture.md"
RESERVED = "`conversation`, `voice`, `planning` and `campaign` are reserved for what is to come."


@dataclass(frozen=True)
class Stay:
    """A function on a walk."""

    name: str
    """Module and function: `rai_missions.engine.chart:Chart.send`."""
    what: str
    by: str = ""
    """The earlier stay from which it is reached, if that is not the one before."""
    up: bool = False

    @property
    def module(self) -> str:
        return self.name.partition(":")[0]

    @property
    def function(self) -> str:
        return self.name.partition(":")[2]

    @property
    def called(self) -> frozenset[str]:
        """What others name it: its class or itself."""
        return frozenset(self.function.split("."))

    @property
    def room(self) -> str:
        package, _, rest = self.module.partition(".")
        return rest.partition(".")[0] if package == "rai_missions" else package


@dataclass(frozen=True)
class Walk:
    title: str
    about: str
    stays: tuple[Stay, ...]

    def hops(self) -> Iterator[tuple[Stay, Stay]]:
        """Each stay but the first, behind the one from which it is reached."""
        known = {stay.name: stay for stay in self.stays}
        for before, stay in zip(self.stays, self.stays[1:], strict=False):
            yield known[stay.by] if stay.by else before, stay


def read_walks(path: Path = WALKS) -> tuple[Walk, ...]:
    written = tomllib.loads(path.read_text(encoding="utf-8"))
    return tuple(
        Walk(each["title"], each["about"], tuple(Stay(**stay) for stay in each["stay"])) for each in written["walk"]
    )


@cache
def floors() -> Mapping[str, int]:
    """Each room's floor, the lowest 0, by the layers of `pyproject.toml`; `visualize` reads journals."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    layers = next(each["layers"] for each in settings["contracts"] if each["id"] == "floors")
    found = {
        room.strip(" ()"): floor
        for floor, layer in enumerate(reversed(layers))
        for room in layer.replace(":", "|").split("|")
    }
    return {**found, "visualize": found["runtime"]}


@cache
def tree(module: str) -> ast.Module:
    path = ROOT.joinpath(*module.split("."))
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    return ast.parse(file.read_text(encoding="utf-8"))


def is_there(stay: Stay) -> bool:
    """Whether its module defines its function or class."""
    try:
        node: Any = tree(stay.module)
    except OSError:
        return False
    for part in stay.function.split("."):
        node = next((each for each in node.body if getattr(each, "name", None) == part), None)
        if node is None:
            return False
    return True


@cache
def names(module: str) -> frozenset[str]:
    """What the code of a module names: variables, attributes, functions, and what it imports; without a leading `_`."""
    used: set[str] = set()
    for each in ast.walk(tree(module)):
        if isinstance(each, ast.Name):
            used.add(each.id)
        elif isinstance(each, ast.Attribute):
            used.add(each.attr)
        elif isinstance(each, ast.alias | ast.FunctionDef):
            used.add(each.name)
    return frozenset(name.lstrip("_") for name in used)


def faults(walk: Walk) -> Iterator[str]:
    """What of a walk is not so in the code."""
    missing = [stay.name for stay in walk.stays if not is_there(stay)]
    yield from (f"{walk.title}: there is no {name}" for name in missing)
    for one, other in walk.hops() if not missing else ():
        user, used = (other, one) if other.up else (one, other)
        if user.module != used.module and used.called.isdisjoint(names(user.module)):
            yield f"{walk.title}: {user.module} does not name {used.function} of {used.module}"
        if floors()[user.room] < floors()[used.room]:
            yield f"{walk.title}: {user.name} may not know {used.name}, which is on a higher floor"


def rooms() -> Iterator[str]:
    """Each room with the first paragraph of its docstring, floor by floor from the top."""
    known = floors()
    packages = {name for name in known if (ROOT / "rai_missions" / name / "__init__.py").exists()}
    for floor in sorted({known[name] for name in packages}, reverse=True):
        for name in sorted(each for each in packages if known[each] == floor):
            text = (ast.get_docstring(tree(f"rai_missions.{name}")) or "").partition("\n\n")[0]
            yield f"- {floor}: `{name}`. {' '.join(text.split())}"
    text = (ast.get_docstring(tree("visualize")) or "").partition("\n\n")[0]
    yield f"- `visualize`, a package of its own. {' '.join(text.split())}"


def picture(walk: Walk) -> Iterator[str]:
    """A walk in Mermaid: a frame for the stays that follow in one room, a solid arrow down, a dotted one up."""
    number = {stay.name: f"s{each}" for each, stay in enumerate(walk.stays, 1)}
    yield "```mermaid"
    yield "flowchart TB"
    for each, (room, stays) in enumerate(groupby(walk.stays, lambda stay: stay.room)):
        yield f'    subgraph r{each} ["{room}"]'
        yield from (f'        {number[stay.name]}["{stay.function}"]' for stay in stays)
        yield "    end"
    for one, other in walk.hops():
        yield f"    {number[one.name]} {'-.->' if other.up else '-->'} {number[other.name]}"
    yield "```"


def table(walk: Walk) -> Iterator[str]:
    number = {stay.name: str(each) for each, stay in enumerate(walk.stays, 1)}
    for stay in walk.stays:
        from_where = f" (from {number[stay.by]})" if stay.by else ""
        module = stay.module.removeprefix("rai_missions.")
        yield f"{number[stay.name]}. `{module}`: `{stay.function}`{from_where}. {stay.what}"


def wrapped(lines: Iterator[str]) -> Iterator[str]:
    """Paragraphs and list items at 118 characters; words in code stay whole."""
    for line in lines:
        head = marker[0] if (marker := re.match(r"- |\d+\. ", line)) else ""
        indent, rest = " " * len(head), line.removeprefix(head).split(" ")
        row = head + rest[0]
        for word in rest[1:]:
            if len(row) + 1 + len(word) > 118:
                yield row
                row = indent + word
            else:
                row += f" {word}"
        yield row


def page(walks: tuple[Walk, ...]) -> str:
    text = [
        "# Architecture",
        "",
        "<!-- Written by scripts/walks.py from the packages' docstrings and docs/walks.toml; do not edit. -->",
        "",
        *wrapped(iter([tomllib.loads(WALKS.read_text(encoding="utf-8"))["about"]])),
        "",
        "## The rooms",
        "",
        "Imports point down: a package imports what has a lower number. The modules of the root have the number 0.",
        "",
        *wrapped(rooms()),
        "",
        RESERVED,
    ]
    for walk in walks:
        text += ["", f"## {walk.title}", "", *wrapped(iter([walk.about])), "", *picture(walk), ""]
        text += wrapped(table(walk))
    return "\n".join(text) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write the page")
    given = parser.parse_args()
    walks = read_walks()
    if wrong := [fault for walk in walks for fault in faults(walk)]:
        print(*wrong, sep="\n", file=sys.stderr)
        return 1
    if given.write:
        PAGE.write_text(page(walks), encoding="utf-8")
    elif PAGE.read_text(encoding="utf-8") != page(walks):
        print("docs/architecture.md is not what scripts/walks.py writes; run it with --write", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
