# SPDX-License-Identifier: Apache-2.0
"""Charts of a simple kind, as missions and as Promela, for SPIN to find by itself what can be reached.

The kind: compound states below regions that run side by side, events, eventless transitions, guards over the mission's
own booleans and numbers, `set` and `raise`. No transition leads out of its region but to the end. The translation knows
nothing of the chart: exits, entries and the order of transitions are written out for each innermost state, by W3C
SCXML's rules.
"""

from __future__ import annotations

import random
import re
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

Json = dict[str, Any]
EVENTS = ("e0", "e1", "e2")
RAISED = ("i0", "i1")
FLAGS, COUNTS = ("p", "q"), ("n",)
END = "over"
QUEUE = 6
LABEL = re.compile(r"^REACHED ([-\d ]+)$", re.MULTILINE)


# -- charts ----------------------------------------------------------------------------------------------------------


class Drawing:
    """Draws one chart."""

    def __init__(self, seed: int) -> None:
        self.random, self.made = random.Random(seed), 0
        self.regions: dict[str, list[str]] = {}

    def mission(self) -> Json:
        regions = {
            f"r{number}": self.compound(depth=1, region=f"r{number}") for number in range(self.random.choice([1, 2, 2]))
        }
        for name, region in regions.items():
            self.transitions(region, name)
        return {
            "format": 1,
            "name": "drawn",
            "version": "1.0.0",
            "initial": "all",
            "blackboard": {
                **{name: {"type": "boolean", "initial": False} for name in FLAGS},
                **{name: {"type": "integer", "initial": 0} for name in COUNTS},
            },
            "events": {name: {} for name in (*EVENTS, *RAISED, "stop")},
            "states": {"all": {"parallel": regions}, END: {"final": "aborted"}},
            "transitions": [{"on": "stop", "when": self.guard(), "to": END}],
        }

    def compound(self, *, depth: int, region: str) -> Json:
        states: Json = {}
        for _ in range(self.random.randint(2, 3)):
            self.made += 1
            name = f"s{self.made}"
            deep = depth > 0 and self.random.random() < 0.4
            states[name] = self.compound(depth=depth - 1, region=region) if deep else {}
            self.regions.setdefault(region, []).append(name)
            for word in ("entry", "exit"):
                if self.random.random() < 0.3:
                    states[name][word] = [self.effect(raising=False)]
        return {"initial": next(iter(states)), "states": states}

    def transitions(self, state: Json, region: str) -> None:
        for each in state.get("states", {}).values():
            transitions = [self.transition(region) for _ in range(self.random.randint(0, 3))]
            if self.random.random() < 0.25:  # it makes its own guard false, so that no cycle is without end
                transitions.append(
                    {
                        "when": {"key": "p", "==": True},
                        "to": self.random.choice(self.regions[region]),
                        "do": [{"set": "p", "value": False}],
                    }
                )
            if transitions:
                each["transitions"] = transitions
            self.transitions(each, region)

    def transition(self, region: str) -> Json:
        transition: Json = {"on": self.random.choice([*EVENTS, *EVENTS, *RAISED])}
        if self.random.random() < 0.6:
            transition["when"] = self.guard()
        if self.random.random() < 0.85:
            transition["to"] = self.random.choice(self.regions[region])
        raising = transition["on"] in EVENTS
        transition["do"] = [
            self.effect(raising=raising) for _ in range(self.random.randint(0 if "to" in transition else 1, 2))
        ]
        return (
            transition
            if transition["do"]
            else {word: reported for word, reported in transition.items() if word != "do"}
        )

    def effect(self, *, raising: bool) -> Json:
        if raising and self.random.random() < 0.5:
            return {"raise": self.random.choice(RAISED)}
        if self.random.random() < 0.6:
            return {"set": self.random.choice(FLAGS[1:] if not raising else FLAGS), "value": self.random.random() < 0.5}
        return {"set": self.random.choice(COUNTS), "value": self.random.randint(0, 2)}

    def guard(self) -> Json:
        kind = self.random.random()
        if kind < 0.2:
            return {"not": self.guard()}
        if kind < 0.4:
            return {self.random.choice(["all", "any"]): [self.guard(), self.guard()]}
        if kind < 0.7:
            return {"key": self.random.choice(FLAGS), "==": self.random.random() < 0.5}
        return {
            "key": self.random.choice(COUNTS),
            self.random.choice(["<", ">=", "==", "!="]): self.random.randint(0, 2),
        }


# -- the translation -------------------------------------------------------------------------------------------------


class Inner(NamedTuple):
    """A state inside a region: where it is."""

    number: int
    name: str
    state: Json
    chain: tuple[str, ...]
    """It and its ancestors inside the region, innermost first."""


class Translation:
    """A drawn mission as a Promela process that prints each configuration in which it waits."""

    def __init__(self, mission: Json) -> None:
        self.mission = mission
        self.regions: list[Mapping[str, Inner]] = []
        for region in mission["states"]["all"]["parallel"].values():
            found: dict[str, Inner] = {}
            self._collect(region["states"], (), found)
            self.regions.append(found)
        self.raises = [*EVENTS, "stop", *RAISED]

    def _collect(self, states: Json, above: tuple[str, ...], found: dict[str, Inner]) -> None:
        for name, state in states.items():
            found[name] = Inner(len(found), name, state, (name, *above))
            self._collect(state.get("states", {}), (name, *above), found)

    def text(self) -> str:
        count = len(self.regions)
        lines = [*(f"bool {name} = false;" for name in FLAGS), *(f"byte {name} = 0;" for name in COUNTS)]
        lines += [f"short cur{at}; short sel{at};" for at in range(count)]
        lines += [f"byte queue[{QUEUE}]; byte waiting = 0; bool over = false; byte ev; bool moved;"]
        lines += [f"inline push(e) {{ assert(waiting < {QUEUE}); queue[waiting] = e; waiting++ }}"]
        lines += [f"inline choose() {{ {self._selections()} }}", f"inline take() {{ {self._moves()} }}"]
        printed = ", ".join(f"now.cur{at}" for at in range(count))
        reported = f'c_code {{ printf("REACHED {" ".join(["%d"] * count)} %d\\n", {printed}, now.over); }}'
        lines += ["active proctype chart() { d_step {", self._entered(), "ev = 255 };", self._settled(), reported + ";"]
        lines += ["do :: over -> break :: else ->", "if"]
        lines += [f":: ev = {number}" for number in range(len(self.raises))]
        lines += ["fi;", "atomic { " + self._macrostep() + " };", self._settled(), reported + ";", "od }"]
        return "\n".join(lines)

    def _macrostep(self) -> str:
        """An event from outside: the transitions of the regions first, the mission's own after them."""
        stop = self.raises.index("stop")
        guard = _guard(self.mission["transitions"][0]["when"])
        return f"choose(); take(); if :: !moved && ev == {stop} && {guard} -> over = true :: else fi"

    def _settled(self) -> str:
        """Eventless transitions until there is none, then what was raised, until all is done."""
        shift = " ".join(f"queue[{at}] = queue[{at + 1}];" for at in range(QUEUE - 1))
        return (
            "atomic { do :: over -> break :: else -> ev = 255; choose(); take(); "
            f"if :: moved -> skip :: else -> if :: waiting > 0 -> ev = queue[0]; {shift} waiting--; choose(); take() "
            ":: else -> break fi fi od };"
        )

    def _selections(self) -> str:
        """For each region the first transition that is enabled, the innermost state's before its ancestors'."""
        return " ".join(self._selection(at, region) for at, region in enumerate(self.regions))

    def _selection(self, at: int, region: Mapping[str, Inner]) -> str:
        branches = []
        for leaf in region.values():
            if "states" in leaf.state:
                continue
            tests = "".join(
                f":: else -> if :: ({_fires(each, self.raises)}) -> "
                f"sel{at} = {_transition_number(region, owner, index)} "
                for owner in leaf.chain
                for index, each in enumerate(region[owner].state.get("transitions", ()))
            )
            depth = tests.count(":: else ->")
            branches.append(
                f":: cur{at} == {leaf.number} -> if :: false -> skip {tests} :: else -> skip fi" + " fi" * depth
            )
        return f"sel{at} = -1; if {' '.join(branches)} fi;"

    def _moves(self) -> str:
        """Exits of all that were selected, last in the document first; then what the transitions do; then entries."""
        parts = ["moved = false;"]
        parts += [self._each_transition(at, "exit") for at in reversed(range(len(self.regions)))]
        parts += [self._each_transition(at, "do") for at in range(len(self.regions))]
        parts += [self._each_transition(at, "entry") for at in range(len(self.regions))]
        return " ".join(parts)

    def _each_transition(self, at: int, phase: str) -> str:
        region, branches = self.regions[at], []
        for leaf in region.values():
            if "states" in leaf.state:
                continue
            for owner in leaf.chain:
                for index, transition in enumerate(region[owner].state.get("transitions", ())):
                    test = f"cur{at} == {leaf.number} && sel{at} == {_transition_number(region, owner, index)}"
                    did = " ".join(self._phase(region, at, leaf, transition, owner, phase))
                    if (
                        phase == "entry"
                    ):  # the configuration changes last: until then it states where the transition began
                        test = f"sel{at} == {_transition_number(region, owner, index)} && cur{at} == {leaf.number}"
                    branches.append(f":: {test} -> {did or 'skip;'} skip")
        return f"if {' '.join(branches)} :: else -> skip fi;" if branches else ""

    def _phase(
        self, region: Mapping[str, Inner], at: int, leaf: Inner, transition: Json, owner: str, phase: str
    ) -> Iterator[str]:
        if phase == "do":
            yield "moved = true;"
            yield from _effects(transition.get("do", ()), self.raises)
            return
        if "to" not in transition:
            return
        target = transition["to"]
        domain = next((each for each in region[owner].chain[1:] if each in region[target].chain[1:]), None)
        if phase == "exit":
            for name in leaf.chain:
                if name == domain:
                    break
                yield from _effects(region[name].state.get("exit", ()), self.raises)
            return
        path = [target]
        while "states" in region[path[-1]].state:
            path.append(region[path[-1]].state["initial"])
        above = region[target].chain[1:]
        entered = [*reversed(above[: above.index(domain)] if domain is not None else above), *path]
        for name in entered:
            yield from _effects(region[name].state.get("entry", ()), self.raises)
        yield f"cur{at} = {region[path[-1]].number};"

    def _entered(self) -> str:
        parts = []
        for at, (region, written) in enumerate(
            zip(self.regions, self.mission["states"]["all"]["parallel"].values(), strict=True)
        ):
            name = written["initial"]
            parts += _effects(region[name].state.get("entry", ()), self.raises)
            while "states" in region[name].state:
                name = region[name].state["initial"]
                parts += _effects(region[name].state.get("entry", ()), self.raises)
            parts.append(f"cur{at} = {region[name].number};")
        return " ".join(parts)

    def named(self, printed: str) -> frozenset[str]:
        """The innermost active states of a line that was printed."""
        *numbers, over = (int(each) for each in printed.split())
        if over:
            return frozenset({END})
        names = [list(region) for region in self.regions]
        return frozenset(names[at][number] for at, number in enumerate(numbers))


def _transition_number(region: Mapping[str, Inner], owner: str, index: int) -> int:
    return region[owner].number * 10 + index


def _fires(transition: Json, events: list[str]) -> str:
    trigger = f"ev == {events.index(transition['on'])}" if "on" in transition else "ev == 255"
    return f"{trigger} && {_guard(transition['when'])}" if "when" in transition else trigger


def _guard(guard: Json) -> str:
    if "not" in guard:
        return f"(!{_guard(guard['not'])})"
    for word, sign in (("all", " && "), ("any", " || ")):
        if word in guard:
            return f"({sign.join(_guard(each) for each in guard[word])})"
    op, value = next((op, value) for op, value in guard.items() if op != "key")
    return f"({guard['key']} {op} {str(value).lower()})"


def _effects(effects: Any, events: list[str]) -> Iterator[str]:
    for effect in effects:
        if "raise" in effect:
            yield f"push({events.index(effect['raise'])});"
        else:
            yield f"{effect['set']} = {str(effect['value']).lower()};"


# -- SPIN ------------------------------------------------------------------------------------------------------------


def has_spin() -> bool:
    return shutil.which("spin") is not None and shutil.which("gcc") is not None


def reached_by_spin(mission: Json, folder: Path) -> set[frozenset[str]]:
    """Every configuration in which the chart waits, as SPIN finds them."""
    translation = Translation(mission)
    (folder / "chart.pml").write_text(translation.text() + "\n", encoding="utf-8")
    for command in (["spin", "-a", "chart.pml"], ["gcc", "-w", "-O0", "-o", "pan", "pan.c"]):
        ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)
        assert ran.returncode == 0, f"{command}: {ran.stdout}{ran.stderr}"
    ran = subprocess.run(["./pan", "-m100000"], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert "errors: 0" in ran.stdout, ran.stdout[-2000:]
    return {translation.named(printed) for printed in LABEL.findall(ran.stdout)}
