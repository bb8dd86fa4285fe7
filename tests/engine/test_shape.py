# SPDX-License-Identifier: Apache-2.0
"""The engine is functions over two objects: no tower of classes, and one list of what a run remembers."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rai_missions.engine.state import FIELD_KINDS, TABLE
from tests.rigs.sources import nodes, parsed

ROOT = Path(__file__).parents[2]
PACKAGES = ("rai_missions.engine", "rai_missions.prove")
MOST_CLASSES = 3
MOST_FIELDS = 6
"""Fewer fields than this may be named together: a step, or an end, has some."""


# -- classes ----------------------------------------------------------------------------------------------------------


def classes(package: str) -> Iterator[type[Any]]:
    """Every class that is defined in a package."""
    found = importlib.import_module(package)
    names = [package, *(each.name for each in pkgutil.walk_packages(found.__path__, f"{package}."))]
    for name in names:
        for _, kind in inspect.getmembers(importlib.import_module(name), inspect.isclass):
            if kind.__module__ == name:
                yield kind


def own(kind: type[Any]) -> list[type[Any]]:
    """The classes of ours among a class and its bases."""
    return [each for each in kind.__mro__ if each.__module__.startswith("rai_missions")]


@pytest.mark.parametrize("package", PACKAGES)
def test_no_class_is_on_a_tower(package: str) -> None:
    towers = {kind.__qualname__: len(own(kind)) for kind in classes(package) if len(own(kind)) > MOST_CLASSES}
    assert towers == {}


def written(kind: type[Any]) -> tuple[ast.AST, ...]:
    """What the definition of a class is made of."""
    source = Path(str(inspect.getsourcefile(kind))).read_text(encoding="utf-8")
    (found,) = [each for each in nodes(parsed(source)) if isinstance(each, ast.ClassDef) and each.name == kind.__name__]
    return nodes(found)


def used(kind: type[Any]) -> frozenset[str]:
    """The attributes of `self` that a class uses."""
    return frozenset(
        node.attr
        for node in written(kind)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self"
    )


def borrowed(kind: type[Any], bases: list[type[Any]]) -> list[str]:
    """What a class lends to bases of it that have no such method."""
    return [
        f"{base.__qualname__} uses {name} of {kind.__qualname__}"
        for base in bases
        for name in sorted(used(base))
        if not hasattr(base, name) and callable(getattr(kind, name, None))
    ]


@pytest.mark.parametrize("package", PACKAGES)
def test_no_base_uses_what_only_its_descendants_have(package: str) -> None:
    assert [fault for kind in classes(package) for fault in borrowed(kind, own(kind)[1:])] == []


def left_to_descendants(kind: type[Any]) -> list[str]:
    """The methods that a class uses and leaves to its descendants: abstract ones, and those that raise."""
    methods = (node for node in written(kind) if isinstance(node, ast.FunctionDef))
    unfilled = {
        method.name
        for method in methods
        if any(getattr(each, "id", getattr(each, "attr", "")) in FILLED for each in ast.walk(method))
    }
    return [f"{kind.__qualname__}.{name}" for name in sorted(unfilled & used(kind))]


FILLED = ("NotImplementedError", "abstractmethod")


@pytest.mark.parametrize("package", PACKAGES)
def test_no_base_uses_a_method_that_its_descendants_fill(package: str) -> None:
    assert [fault for kind in classes(package) for fault in left_to_descendants(kind)] == []


class Unfilled:
    def run(self) -> Any:
        return self.finish()

    def finish(self) -> Any:
        raise NotImplementedError


def test_a_base_that_uses_what_its_descendants_fill_is_found() -> None:
    assert left_to_descendants(Unfilled) == ["Unfilled.finish"]


class Base:
    def run(self) -> Any:
        return self.finish()  # type: ignore[attr-defined]


class Descendant(Base):
    def finish(self) -> str:
        return "done"


def test_a_base_that_uses_its_descendant_is_found() -> None:
    assert borrowed(Descendant, [Base]) == ["Base uses finish of Descendant"]
    assert borrowed(Base, []) == borrowed(Descendant, [Descendant]) == []


# -- fields -----------------------------------------------------------------------------------------------------------

WORDS = {word for each in TABLE for word in (each.name, each.word)} - set(FIELD_KINDS)
NAMES = {each.name for each in TABLE}


STORED = {each.word for each in TABLE if each.word.startswith("_")}
"""Words of snapshots that mean nothing else anywhere."""


def texts(node: ast.AST) -> set[str]:
    """The fields that a collection names as text."""
    if not isinstance(node, ast.Tuple | ast.List | ast.Set | ast.Dict):
        return set()
    items = node.keys if isinstance(node, ast.Dict) else node.elts
    return {item.value for item in items if isinstance(item, ast.Constant) and isinstance(item.value, str)} & WORDS


def reached(node: ast.AST) -> set[str]:
    """The fields of one object that a collection or a call lists by position."""
    items = node.elts if isinstance(node, ast.Tuple | ast.List) else node.args if isinstance(node, ast.Call) else []
    attributes = [each for item in items for each in ast.walk(item) if isinstance(each, ast.Attribute)]
    return {each.attr for each in attributes} & NAMES


def test_no_field_of_a_run_is_listed_elsewhere() -> None:
    faults = []
    folders = ("engine", "prove", "replay")
    paths = [path for folder in folders for path in sorted((ROOT / "rai_missions" / folder).rglob("*.py"))]
    for path in (path for path in paths if path.name != "description.py"):  # the fields of a step, some of one name
        for node in nodes(parsed(path.read_text(encoding="utf-8"))):
            listed, fields = texts(node), reached(node)
            where = f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 0)}"
            if len(listed) > 2:
                faults.append(f"{where} lists {sorted(listed)}")
            if len(fields) >= MOST_FIELDS:
                faults.append(f"{where} lists {sorted(fields)}")
    assert faults == []


def test_no_package_lists_the_words_of_a_snapshot() -> None:
    faults = [
        f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 0)} lists {sorted(listed)}"
        for folder in ("rai_missions", "visualize")
        for path in sorted((ROOT / folder).rglob("*.py"))
        if any(f'"{word}"' in (text := path.read_text(encoding="utf-8")) for word in STORED)
        for node in nodes(parsed(text))
        if len(listed := texts(node) & STORED) > 1
    ]
    assert faults == []


ONE_LINE = '    mood: str = slot("calm")\n'
PROGRAM = """
import importlib.abc, importlib.machinery, json, sys
from pathlib import Path

ROOT, ONE_LINE = Path(sys.argv[1]), sys.argv[2]

class WithOneLine(importlib.abc.InspectLoader):
    def get_source(self, name):
        text = (ROOT / "rai_missions/engine/state.py").read_text(encoding="utf-8")
        before = "    # -- pause, cancel, migration"
        assert text.count(before) == 1
        return text.replace(before, ONE_LINE + before)

class Finder(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == "rai_missions.engine.state":
            return importlib.machinery.ModuleSpec(name, WithOneLine())

sys.meta_path.insert(0, Finder())

from rai_missions import Chart, Mission
from rai_missions.engine.snapshot_json import packed, unpacked
from rai_missions.engine.state import RunState, copied
from rai_missions.journal.in_flight import InFlight
from rai_missions.prove.environment.environment import Environment
from rai_missions.replay.migrate.activities import carry
from rai_missions.replay.migrate.configuration import reached_states
from rai_missions.replay.migrate.map import Map
from rai_missions.replay.migrate.names import Naming

mission = Mission.model_validate({"name": "m", "initial": "a", "states": {"a": {}}})
chart = Chart(mission)
chart.start()
chart.state.mood = "glad"
saved = chart.snapshot()
assert saved["mood"] == "glad"
assert unpacked(json.loads(json.dumps(packed({"mood": saved["mood"]})))) == {"mood": "glad"}
assert Chart.restore(mission, saved).state.mood == "glad"
assert Chart.restore(mission, {k: v for k, v in saved.items() if k != "mood"}).state.mood == "calm"
assert copied(chart.state).mood == "glad"

naming = Naming(mission, mission, Map())
found, faults = reached_states(naming, saved, chart.active, chart)
assert not faults and carry(naming, saved, found, InFlight()).snapshot["mood"] == "glad"

environment = Environment(mission)
environment.make(environment.begin)
environment.settle()
calm, core = environment.codec.place(), environment.codec.run_key()
environment.chart.state.mood = "glad"
assert environment.codec.run_key() != core
glad = environment.codec.place()
environment.load(calm)
assert environment.chart.state.mood == "calm" and environment.codec.run_key() == core
environment.load(glad)
assert environment.chart.state.mood == "glad"
"""


def test_a_new_field_of_a_run_is_one_line() -> None:
    """It is stored, restored, copied, migrated, explored and packed without an edit of any other line."""
    command = [sys.executable, "-c", PROGRAM, str(ROOT), ONE_LINE]
    ran = subprocess.run(command, check=False, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
