# SPDX-License-Identifier: Apache-2.0
"""Writes `docs/architecture.md`: the rooms from the packages' docstrings, the walks of `docs/walks.toml` from the code.

    python scripts/walks.py           # hold the page to the code: exit 1 where they differ
    python scripts/walks.py --write   # write the page

A walk is a list of stays: functions or classes. Each is reached from the stay before it, or from the one named `by`:

- *down*, by a call: the code of the other, with what it calls in its own module, names it, and the other's module
  imports its module, or what its package offers of it;
- `up`, by a callback, a queue or a protocol: the same the other way round, or its class has each method of the
  protocol. It is on the floor of what it registers for or implements, or above.

What is not so, such as a call that is somewhere else now, is a fault. So is a file of a `change` that is not there, or
a room without a door.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from pathlib import Path

ROOT = Path(__file__).parents[1]
WALKS, PAGE = ROOT / "docs/walks.toml", ROOT / "docs/architecture.md"


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


@dataclass(frozen=True)
class Change:
    """Where something is changed."""

    what: str
    files: tuple[str, ...]
    tests: tuple[str, ...]
    note: str


def read_changes(path: Path = WALKS) -> tuple[Change, ...]:
    written = tomllib.loads(path.read_text(encoding="utf-8"))
    return tuple(
        Change(each["what"], tuple(each["files"]), tuple(each["tests"]), each["note"].strip())
        for each in written["change"]
    )


def absent(changes: tuple[Change, ...]) -> Iterator[str]:
    """Files that are not there."""
    for change in changes:
        for name in (*change.files, *change.tests):
            if not (ROOT / name).exists():
                yield f"to change {change.what}: there is no {name}"


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


@cache
def definitions(module: str) -> Mapping[str, ast.AST]:
    """What a module defines at its top, and in its classes: name or `Class.name` → its code; empty if it is not there.

    What a class sets up, in `__init__` and outside its functions, is in the code of the class.
    """
    found: dict[str, ast.AST] = {}
    with suppress(OSError):
        for node in tree(module).body:
            if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                found[node.name] = node
            targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
            found |= {each.id: node for each in targets if isinstance(each, ast.Name)}
            if isinstance(node, ast.ClassDef):
                found |= {f"{node.name}.{each.name}": each for each in node.body if isinstance(each, ast.FunctionDef)}
    return found


def named(node: ast.AST) -> set[str]:
    """The variables, attributes and imports that code names."""
    parts = list(ast.walk(node))
    return (
        {each.id for each in parts if isinstance(each, ast.Name)}
        | {each.attr for each in parts if isinstance(each, ast.Attribute)}
        | {each.name for each in parts if isinstance(each, ast.alias)}
    )


def reached(stay: Stay) -> set[str]:
    """What a stay's code names, with all that it uses of its own module."""
    known = definitions(stay.module)
    waiting = [stay.function, f"{stay.function.partition('.')[0]}.__init__"]
    done, names = set[str](), set[str]()
    while waiting:
        each = waiting.pop()
        if each in known and each not in done:
            done.add(each)
            names |= named(known[each])
            waiting += [other for other in known if other.rpartition(".")[2] in names]
    return names


@cache
def imported(module: str) -> frozenset[str]:
    """The modules that a module imports, anywhere in it; of what a package offers, those that define it too."""
    found = set[str]()
    waiting = [
        (each.module, name.name)
        for each in ast.walk(tree(module))
        if isinstance(each, ast.ImportFrom) and each.module
        for name in each.names
    ]
    while waiting:
        source, name = waiting.pop()
        found |= {source, f"{source}.{name}"}
        if ROOT.joinpath(*source.split(".")).is_dir():
            waiting += [
                (each.module, name)
                for each in tree(source).body
                if isinstance(each, ast.ImportFrom) and each.module and name in [one.name for one in each.names]
            ]
    return frozenset(found)


def implements(user: Stay, used: Stay) -> bool:
    """Whether the class of one has each method of the protocol of the other."""
    protocol, one = used.function.partition(".")[0], user.function.partition(".")[0]
    own = {name.partition(".")[2] for name in definitions(user.module) if name.startswith(f"{one}.")}
    methods = [name for name in definitions(used.module) if name.startswith(f"{protocol}.")]
    is_protocol = "Protocol" in named(definitions(used.module)[protocol])
    return is_protocol and all(name.partition(".")[2] in own for name in methods)


def faults(walk: Walk) -> Iterator[str]:
    """What of a walk is not so in the code."""
    missing = [stay.name for stay in walk.stays if stay.function not in definitions(stay.module)]
    yield from (f"{walk.title}: there is no {name}" for name in missing)
    for one, other in walk.hops() if not missing else ():
        user, used = (other, one) if other.up else (one, other)
        if floors()[user.room] < floors()[used.room]:
            yield f"{walk.title}: {user.name} may not know {used.name}, which is on a higher floor"
        if other.up and implements(user, used):
            continue
        if used.module not in {user.module, *imported(user.module)}:
            yield f"{walk.title}: {user.module} does not import {used.module}"
        parts = used.function.split(".")
        if reached(user).isdisjoint(parts if other.up else parts[-1:]):
            yield f"{walk.title}: {user.name} does not name {used.function} of {used.module}"


def packages() -> list[str]:
    """The rooms that are packages, floor by floor from the top."""
    known = floors()
    found = [name for name in known if (ROOT / "rai_missions" / name / "__init__.py").exists()]
    return sorted(found, key=lambda name: (-known[name], name))


def read_doors(path: Path = WALKS) -> Mapping[str, tuple[str, ...]]:
    """Room → where to begin to read it: module and name."""
    return {room: tuple(names) for room, names in tomllib.loads(path.read_text(encoding="utf-8"))["doors"].items()}


def closed(doors: Mapping[str, tuple[str, ...]]) -> Iterator[str]:
    """Rooms without a door, and doors that are not there."""
    yield from (f"the room {room} has no door" for room in (*packages(), "visualize") if not doors.get(room))
    for room, names in doors.items():
        for name in names:
            module, _, what = name.partition(":")
            if what not in definitions(module):
                yield f"the door of {room}: there is no {name}"


def role(module: str) -> str:
    """The first paragraph of a module's docstring, in a line."""
    return " ".join((ast.get_docstring(tree(module)) or "").partition("\n\n")[0].split())


def rooms(doors: Mapping[str, tuple[str, ...]]) -> Iterator[str]:
    """Each room with its role and its doors, floor by floor from the top; then what is in `visualize`."""
    for name in packages():
        yield f"- {floors()[name]}: `{name}`. {role(f'rai_missions.{name}')} Door: {door_words(doors[name])}."
    text = role("visualize")
    yield f"- `visualize`, a package of its own. {text} Door: {door_words(doors['visualize'])}."
    for path in sorted((ROOT / "visualize").glob("*/__init__.py")):
        yield f"- `visualize/{path.parent.name}`. {role(f'visualize.{path.parent.name}')}"


def door_words(names: tuple[str, ...]) -> str:
    """`Chart` in `engine/chart.py`."""
    parts = (name.partition(":") for name in names)
    return ", ".join(f"`{what}` in `{file_of(module)}`" for module, _, what in parts)


def file_of(module: str) -> str:
    """Its file, below `rai_missions` without that name."""
    path = module.removeprefix("rai_missions.").replace(".", "/")
    return f"{path}/__init__.py" if ROOT.joinpath(*module.split(".")).is_dir() else f"{path}.py"


def root_modules() -> Iterator[str]:
    """The modules of the root, each with its role."""
    for path in sorted((ROOT / "rai_missions").glob("[!_]*.py")):
        yield f"- `{path.stem}`. {role(f'rai_missions.{path.stem}')}"


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


def changes_text(changes: tuple[Change, ...]) -> Iterator[str]:
    """A paragraph for each change; the files below `rai_missions` without it."""
    for change in changes:
        files = ", ".join(f"`{name.removeprefix('rai_missions/')}`" for name in change.files)
        tests = ", ".join(f"`{name}`" for name in change.tests)
        yield f"- **{change.what[0].upper()}{change.what[1:]}**: {files}. {change.note} Tests: {tests}."


def page(walks: tuple[Walk, ...], changes: tuple[Change, ...], doors: Mapping[str, tuple[str, ...]]) -> str:
    text = [
        "# Architecture",
        "",
        "<!-- Written by scripts/walks.py from the packages' docstrings and docs/walks.toml; do not edit. -->",
        "",
        *wrapped(iter([tomllib.loads(WALKS.read_text(encoding="utf-8"))["about"]])),
        "",
        "## The rooms",
        "",
        "Imports point down: a package imports what has a lower number. The modules of the root have the number 0. A",
        "door is where to begin to read a room; its file imports what is behind it.",
        "",
        *wrapped(rooms(doors)),
        "",
        "### The modules of the root",
        "",
        *wrapped(root_modules()),
        "",
        "## Where to change what",
        "",
        "The files, in the order in which one leads to the next; those of `rai_missions` without its name. All are",
        "held to be there. Narrow tests of each come last: the whole suite takes long.",
        "",
        *wrapped(changes_text(changes)),
    ]
    for walk in walks:
        text += ["", f"## {walk.title}", "", *wrapped(iter([walk.about])), "", *picture(walk), ""]
        text += wrapped(table(walk))
    return "\n".join(text) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write the page")
    given = parser.parse_args()
    walks, changes, doors = read_walks(), read_changes(), read_doors()
    if wrong := [*closed(doors), *absent(changes), *(fault for walk in walks for fault in faults(walk))]:
        print(*wrong, sep="\n", file=sys.stderr)
        return 1
    if given.write:
        PAGE.write_text(page(walks, changes, doors), encoding="utf-8")
    elif PAGE.read_text(encoding="utf-8") != page(walks, changes, doors):
        print("docs/architecture.md is not what scripts/walks.py writes; run it with --write", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
