# SPDX-License-Identifier: Apache-2.0
"""A kind owns its behaviour: no module but its own picks one out, so that a new one needs no branch elsewhere."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import rai_missions
import visualize
from rai_missions.states import Compound, Each, Final, History, Include, Parallel, State
from tests.rigs.sources import nodes, parsed

ROOTS = [Path(str(each.__file__)).parent for each in (rai_missions, visualize)]
GRAMMAR = {State, Compound, Each, Final, History, Include, Parallel}
"""What a chart is made of, in SCXML's words: the engine, the rules and the picture know these."""
OPEN = {kind.__name__ for kind in {*State.kinds.values()} - GRAMMAR}
"""The activities; other packages may add to them."""


def files() -> Iterator[tuple[str, ast.Module]]:
    for root in ROOTS:
        for file in sorted(root.rglob("*.py")):
            text = file.read_text(encoding="utf-8")
            if "rai_missions.states" not in text and ".word" not in text:
                continue  # it knows no activity by its class, nor by its word
            yield file.relative_to(root.parent).as_posix(), parsed(text)


def of_states(module: ast.Module) -> set[str]:
    """The names under which a module knows activities; an effect of the same name is another thing."""
    return {
        alias.asname or alias.name
        for node in nodes(module)
        if isinstance(node, ast.ImportFrom)
        and (node.module or "").startswith("rai_missions.states")
        and node.module != "rai_missions.states.effects"
        for alias in node.names
        if alias.name in OPEN
    }


def picked(module: ast.Module) -> Iterator[str]:
    """Where a module asks whether something is of one kind of activity, by its class or by its word."""
    known, words = of_states(module), {kind.word for kind in State.kinds.values() if kind.__name__ in OPEN}
    for node in nodes(module):
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id in ("isinstance", "issubclass")
        ):
            names = {each.id for each in ast.walk(node.args[1]) if isinstance(each, ast.Name)}
            yield from (f"line {node.lineno}: {name}" for name in sorted(names & known))
        if isinstance(node, ast.MatchClass) and isinstance(node.cls, ast.Name) and node.cls.id in known:
            yield f"line {node.lineno}: {node.cls.id}"
        if isinstance(node, ast.Compare) and isinstance(node.left, ast.Attribute) and node.left.attr == "word":
            compared = {
                each.value for right in node.comparators for each in ast.walk(right) if isinstance(each, ast.Constant)
            }
            yield from (f"line {node.lineno}: '{word}'" for word in sorted(compared & words))


def test_no_module_picks_out_a_kind_of_activity() -> None:
    found = {name: each for name, module in files() if (each := list(picked(module)))}
    assert found == {}


def test_the_law_finds_what_it_is_for() -> None:
    text = "from rai_missions.states import Call\nisinstance(x, Call | int)\nx.word == 'tree'\n"
    assert list(picked(ast.parse(text))) == ["line 2: Call", "line 3: 'tree'"]
    text = "from rai_missions.states.effects import Call\nisinstance(x, Call)\n"
    assert list(picked(ast.parse(text))) == []


MODEL = '''
from typing import ClassVar
from rai_missions.model import Seconds
from rai_missions.states.state import State

class Rest(State, word="rest"):
    """Does nothing for a while."""
    positional: ClassVar = ("rest",)
    rest: Seconds
    def outcomes(self):
        return super().outcomes() | {"succeeded"}
    def takes_time(self):
        return True
    def activity(self):
        return f"rest {self.rest:g} s"
'''
MACHINE = """
import math
from typing import NamedTuple
from rai_missions.engine.activities.activity import NO_KEYS, Outcome, Turn, machine_of, remembered
from rai_missions.states.rest import Rest

@remembered("Resting")
class RestActivity(NamedTuple):
    until: float

class RestMachine:
    def __init__(self, definition, bench):
        self.definition, self.owner = definition, bench.owner
    def begin(self, host):
        return Turn(RestActivity(host.begins_at + self.definition.rest))
    def receive(self, state, event, host):
        return Turn(None, outcome=Outcome("succeeded")) if host.view.at >= state.until else None
    def leave(self, state, host):
        return Turn(None)
    def wake_at(self, state, view):
        return state.until
    def reads(self, state):
        return NO_KEYS
    def awaits(self, state):
        return frozenset()
    def shift(self, state, by_s):
        return state._replace(until=state.until + by_s)

@machine_of.register
def _(definition: Rest, bench):
    return RestMachine(definition, bench)
"""
USE = """
import json
from rai_missions.check import check
from rai_missions.engine import Chart
from rai_missions.engine.snapshot_json import packed, unpacked
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove
from rai_missions.testing import check_activity
from visualize import difference, drawn, picture

def mission(rest):
    return Mission.model_validate({"name": "m", "initial": "a", "states": {
        "a": {"rest": rest, "transitions": [{"on": "succeeded", "to": "b"}]}, "b": {"final": "canceled"}}})

here = mission(2)
check_activity(here.states["a"], {})
chart = Chart(here)
chart.start(0.0)
chart = Chart.restore(here, unpacked(packed(chart.snapshot())))
print(json.dumps({
    "check": list(map(str, check(here))), "picture": "rest 2 s" in drawn(picture(here), "dot").decode(),
    "difference": [str(each) for each in difference(here, mission(3)).changes],
    "outcome": chart.send(Event("tick", 2.0, {}, "tick")).outcome,
    "proof": sorted({claim.verdict for claim in prove(here).claims}),
}))
"""


def test_a_new_state_kind_of_the_format_is_two_files(tmp_path: Path) -> None:
    for root in ROOTS:
        (tmp_path / root.name).symlink_to(root)
    package = tmp_path / "rai_missions"
    package.unlink()
    copied(ROOTS[0], package, {"states/rest.py": MODEL, "engine/activities/rest.py": MACHINE})
    done = subprocess.run(
        [sys.executable, "-c", USE],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert any("'rest' changed" in each for each in found.pop("difference"))
    assert found == {"check": [], "picture": True, "outcome": "canceled", "proof": ["proved"]}


def copied(package: Path, to: Path, new: dict[str, str]) -> None:
    """A package whose modules are links to those of another, and some new ones."""
    for file in package.rglob("*"):
        there = to / file.relative_to(package)
        if file.is_dir() and file.name != "__pycache__":
            there.mkdir(parents=True, exist_ok=True)
        elif file.is_file() and file.suffix != ".pyc":
            there.parent.mkdir(parents=True, exist_ok=True)
            there.symlink_to(file)
    for name, text in new.items():
        (to / name).write_text(text, encoding="utf-8")
