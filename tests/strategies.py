# SPDX-License-Identifier: Apache-2.0
"""Generated missions: small, of every kind of state, guard, effect and tree node, and such that each step ends.

Rule: whatever can fire without an event from outside leads forward among its siblings, so no run goes round for ever.
"""

from __future__ import annotations

import functools
from typing import Any

from hypothesis import strategies as st

from rai_missions.mission.mission import Mission
from rai_missions.model.references import template_paths

__all__ = ("EVENTS", "KEYS", "SIGHTS", "guards", "mission_documents", "missions", "tree_nodes")

Draw = st.DrawFn
Json = dict[str, Any]

KEYS: Json = {
    "alleys": {"type": "integer", "source": "argument", "initial": 2},
    "waypoints": {"type": "list", "source": "argument", "initial": ["a", "b"]},
    "home": {"type": "pose", "source": "argument", "initial": {"x": 0.0, "y": 0.0}},
    "waypoint": {"type": "string", "source": "mission", "initial": ""},
    "count": {"type": "integer", "source": "mission", "initial": 0},
    "armed": {"type": "boolean", "source": "mission", "initial": False},
    "battery": {"type": "number", "source": "robot", "max_age_s": 10},
    "clear": {"type": "boolean", "source": "robot", "max_age_s": 5, "optional": True},
    "pose": {"type": "pose", "source": "robot", "max_age_s": 1},
    "obstacle": {"type": "object", "source": "robot", "max_age_s": 0.5, "optional": True,
                 "fields": {"kind": "string", "height_m": "number", "living": "boolean"}},
    "request": {"type": "string", "source": "argument", "initial": "put the red cube on the blue cube"},
    "objects": {"type": "object", "source": "robot", "max_age_s": 5, "optional": True},
    "reading": {"type": "object"}, "wanted": {"type": "object"}, "plan": {"type": "object"},
}  # fmt: skip
"""The keys that every generated mission has."""
EVENTS = ("anomaly", "halt", "poke")
"""The events from outside; `hint` is raised by transitions alone."""
HINT = "hint"
SIGHTS: tuple[Json, ...] = tuple(
    {
        "gripper": "empty",
        "things": [
            {
                "name": name,
                "type": kind,
                "colour": colour,
                "x": x,
                "y": 0.0,
                "z": z,
                "yaw": 0.0,
                "size": [0.044] * 3,
                "sigma_m": 0.001,
                "looks": 6,
                "agreeing": 6,
                "at_rest": True,
            }
            for name, kind, colour, x, z in things
        ],
    }
    for things in (
        (("red_cube", "cube", "red", 0.4, 0.022), ("blue_cube", "cube", "blue", 0.6, 0.022)),
        (("red_cube", "cube", "red", 0.6, 0.066), ("blue_cube", "cube", "blue", 0.6, 0.022)),
        (("red_cube", "cube", "red", 0.4, 0.022),),
        (("red_cube", "cube", "red", 0.4, 0.022), ("blue_cube", "apple", "blue", 0.6, 0.022)),
    )
)
"""What a robot may see: two cubes apart, stacked, one alone, and next to something on which nothing can rest."""
FIELDS = ("a", "b", "pose")
CONSTANTS: tuple[Any, ...] = (None, True, 2, 1.5, "grün", [], {}, {"x": [1, None]})
RESULTS: tuple[Json, ...] = ({}, {"count": "n"}, {"count": "a.0.n", "armed": "ok"}, {"wanted": "goal"})
OPTIONS = ("drive_over", "replan", "wait", "give_up")
ACTIVITY_ENDS = ("succeeded", "failed", "unverified", "timed_out", "rejected")
DEPTH = 2


@functools.cache
def comparisons() -> st.SearchStrategy[Json]:
    """Comparisons with values that fit the keys."""
    order = st.sampled_from(["<", "<=", ">", ">=", "==", "!="])
    return st.one_of(
        st.builds(lambda op, n: {"key": "count", op: n}, order, st.integers(0, 3)),
        st.builds(lambda op, n: {"key": "battery", op: n}, order, st.sampled_from([0.1, 0.25, 0.5])),
        st.builds(lambda op, n: {"key": "obstacle.height_m", op: n}, order, st.sampled_from([0.1, 0.25])),
        st.builds(
            lambda key, b: {"key": key, "==": b}, st.sampled_from(["armed", "clear", "obstacle.living"]), st.booleans()
        ),
        st.just({"key": "count", ">=": {"key": "alleys"}}),
        st.just({"key": "obstacle.kind", "in": ["log", "branch"]}),
    )


@functools.cache
def guards(states: tuple[str, ...] = (), *, timed: bool = True) -> st.SearchStrategy[Json]:
    """Guards as JSON has them.

    Args:
        states: The states that `in` may ask for.
        timed: With `held` and `elapsed_s`.
    """
    leaves: list[st.SearchStrategy[Json]] = [
        comparisons(),
        st.sampled_from([{"fresh": "obstacle"}, {"fresh": "battery"}, {"near": ["pose", "home"], "within_m": 0.5}]),
        st.sampled_from(
            [
                {"goal": "wanted", "over": "objects"},
                {"goal": "wanted", "over": "objects", "is": "feasible"},
                {"goal": "wanted", "is": "said", "in": "request"},
            ]
        ),
    ]
    if states:
        leaves.append(st.sampled_from(states).map(lambda name: {"in": name}))
    if timed:
        leaves.append(st.sampled_from([{"elapsed_s": 1.0}, {"elapsed_s": 5.0}]))

    def around(inner: st.SearchStrategy[Json]) -> st.SearchStrategy[Json]:
        several = st.lists(inner, min_size=1, max_size=3)
        kinds = [
            several.map(lambda given: {"all": given}),
            several.map(lambda given: {"any": given}),
            inner.map(lambda given: {"not": given}),
            inner.map(lambda given: {"possible": given}),
        ]
        if timed:
            kinds.append(inner.map(lambda given: {"held": given, "for_s": 2.0}))
        return st.one_of(kinds)

    return st.recursive(st.one_of(leaves), around, max_leaves=4)


def _around(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.one_of(st.lists(inner, max_size=2), st.dictionaries(st.sampled_from(FIELDS), inner, max_size=2))


@functools.cache
def sent(*paths: str, wholes: tuple[str, ...]) -> st.SearchStrategy[Json]:
    """Goals, requests, messages and payloads: fields and lists with constants and references in them, or a reference.

    Args:
        paths: What the references in it name.
        wholes: Keys with fields, any of which may be referred to as the whole.
    """
    refers = st.sampled_from((*paths, *wholes)).map(lambda path: {"from": path})
    parts = st.recursive(st.one_of(refers, st.sampled_from(CONSTANTS)), _around, max_leaves=3)
    fields = st.dictionaries(st.sampled_from(FIELDS), parts, max_size=2)
    return st.one_of(st.just({}), fields, st.sampled_from(wholes).map(lambda path: {"from": path}))


def known() -> st.SearchStrategy[Json]:
    """What can always be sent."""
    return sent("count", "alleys", "armed", "request", "waypoints.0", "home.x", wholes=("home",))


def anything() -> st.SearchStrategy[Json]:
    """What cannot be sent while a part of it is unknown."""
    return sent(
        "battery", "obstacle.height_m", "reading.goal", "count", "home.x", wholes=("home", "obstacle", "wanted")
    )


@functools.cache
def effects(*, raising: bool = False) -> st.SearchStrategy[list[Json]]:
    """Effects of a transition, an entry or an exit.

    Args:
        raising: With `raise` at once, which only transitions fired from outside may have.
    """
    fixed: list[Json] = [
        {"set": "count", "value": 0}, {"set": "count", "add": 1}, {"set": "count", "from": "alleys"},
        {"set": "armed", "value": True}, {"set": "wanted", "from": "reading.goal"},
        {"say": "careful"}, {"log": "noted"}, {"drop": "later"},
    ]  # fmt: skip
    later = {"raise": "poke", "after_s": 3.0, "id": "later"}
    unsure = st.sampled_from([{"a": [{"from": "obstacle.height_m"}]}, {"from": "obstacle"}])
    sending = [
        st.one_of(known(), unsure).map(lambda request: {"call": "horn", "request": request}),
        st.one_of(known(), unsure).map(lambda message: {"publish": "lamp", "message": message}),
        known().map(lambda data: {**later, "data": data}),
    ]
    return st.lists(st.one_of(st.sampled_from(fixed + ([{"raise": HINT}] if raising else [])), *sending), max_size=2)


def asked(draw: Draw) -> Json:
    """A decision with its question, two to four options and an open fallback."""
    names = draw(st.lists(st.sampled_from(OPTIONS), min_size=2, max_size=4, unique=True))
    options: Json = {name: {"about": f"{name}, please"} for name in names}
    for name in names[1:]:
        if draw(st.booleans()):
            options[name]["when"] = draw(guards(timed=False))
        elif draw(st.integers(0, 3)) == 0:
            options[name]["parameters"] = {"type": "object", "properties": {"speed": {"type": "number"}}}
    return {
        "question": "What now?", "evidence": draw(st.sampled_from([[], ["obstacle"], ["obstacle", "battery"]])),
        "options": options, "fallback": names[0], "attempts": draw(st.integers(1, 2)), "deadline_s": 20.0,
        "ask": draw(st.sampled_from([["rules"], ["agent", "rules"], ["agent", "operator", "rules"]])),
    }  # fmt: skip


@st.composite
def tree_nodes(draw: Draw, depth: int = 2) -> Json:
    """A behaviour tree as JSON has it; none that goes round for ever within a tick."""
    leaves = ["call", "action", "check", "wait_s", "set", "publish", "decision"]
    inner = ["sequence", "selector", "parallel", "inverter", "retry", "repeat", "timeout", "failure_is_success"]
    word = draw(st.sampled_from(leaves + (inner * 2 if depth else [])))
    children = tree_nodes(depth=depth - 1)
    if word in ("sequence", "selector", "parallel"):
        return {word: draw(st.lists(children, min_size=1, max_size=3))}
    if word in ("inverter", "failure_is_success"):
        return {word: draw(children)}
    if word in ("retry", "repeat"):
        return {word: 2, "child": draw(children)}
    if word == "decision":
        question = asked(draw)
        then = {name: draw(children) for name in question["options"] if depth and draw(st.booleans())}
        return {"decision": question, **({"then": then} if then else {})}
    given: Json = {
        "timeout": lambda: {"timeout": 4.0, "child": draw(children)},
        "call": lambda: {"call": "horn", "request": draw(anything()), "timeout_s": 2.0},
        "action": lambda: {"action": "cross", "goal": draw(anything()), "timeout_s": 5.0},
        "check": lambda: {"check": draw(guards(timed=False))},
        "wait_s": lambda: {"wait_s": draw(st.sampled_from([0.5, 2.0]))},
        "set": lambda: {"set": "count", "add": 1},
        "publish": lambda: {"publish": "lamp", "message": draw(anything())},
    }[word]()
    return given


class _Draft:
    """A mission as it is drawn: first the states with their names, then the transitions between them."""

    def __init__(self, draw: Draw) -> None:
        self.draw, self.names = draw, 0
        self.targets: list[str] = []
        """The states that a transition from anywhere may lead to."""
        self.plain: list[str] = []
        """The states that guards may ask for."""
        self.rooms: list[tuple[str, list[tuple[str, Json]]]] = []
        """Word of the parent → its children, for the transitions that lead forward."""
        self.regions: list[list[list[str]]] = []
        """For each parallel state, what each of its regions has directly inside."""

    def name(self, word: str) -> str:
        self.names += 1
        return f"{word}{self.names}"

    def states(self, depth: int, *, word: str = "states") -> Json:
        """Siblings, the first of them one to begin with."""
        room: Json = {}
        for _ in range(self.draw(st.integers(1, 3))):
            kinds = ["wait", "action", "action", "call", "decision", "tree", "read", "plan"]
            kind = self.draw(st.sampled_from(kinds + (["compound", "parallel", "each"] if depth else [])))
            self.add(room, kind, depth)
        if word == "states":
            for kind in self.draw(st.sampled_from([(), ("final",), ("final", "final"), ("history", "final")])):
                if kind == "final" or depth < DEPTH:
                    self.add(room, kind, depth)
        self.rooms.append((word, list(room.items())))
        return room

    def add(self, room: Json, kind: str, depth: int) -> None:
        name = self.name(kind)
        room[name] = getattr(self, f"_{kind}")(depth - 1)
        self.targets.append(name)
        if kind != "history":
            self.plain.append(name)
        if kind not in ("history", "final"):
            self.dress(room[name])

    def dress(self, state: Json) -> None:
        """What any state may have next to its kind."""
        entry, leave = self.draw(effects()), self.draw(effects())
        state |= ({"entry": entry} if entry else {}) | ({"exit": leave} if leave else {})
        control = self.draw(st.sampled_from([None, None, None, "autonomy", "agent"]))
        state |= {"control": control} if control else {}

    def _wait(self, depth: int) -> Json:
        return {"about": "waits"} if self.draw(st.booleans()) else {}

    def _action(self, depth: int) -> Json:
        achieved = self.draw(st.none() | guards(timed=False))
        return {
            "action": self.draw(st.sampled_from(["drive", "cross", "go_home"])), "timeout_s": 30.0,
            **self.sends("goal"), **({"achieved": achieved} if achieved else {}),
        }  # fmt: skip

    def _call(self, depth: int) -> Json:
        return {"call": "replan", "timeout_s": 10.0, **self.sends("request")}

    def sends(self, word: str) -> Json:
        """What a state sends, and what it keeps of what comes back."""
        what, result = self.draw(st.one_of(known(), anything())), self.draw(st.sampled_from(RESULTS))
        return ({word: what} if what else {}) | ({"result": result} if result else {})

    def _read(self, depth: int) -> Json:
        return {"read": "request", "over": "objects", "into": "reading"}

    def _plan(self, depth: int) -> Json:
        return {"plan": self.draw(st.sampled_from(["wanted", "reading.goal"])), "over": "objects", "into": "plan"}

    def _decision(self, depth: int) -> Json:
        return {"decision": asked(self.draw)}

    def _tree(self, depth: int) -> Json:
        return {"tree": self.draw(tree_nodes()), "timeout_s": 20.0}

    def _compound(self, depth: int) -> Json:
        states = self.states(depth)
        return {"initial": next(iter(states)), "states": states}

    def _each(self, depth: int) -> Json:
        return {"each": "waypoints", "as": "waypoint", **self._compound(depth)}

    def _parallel(self, depth: int) -> Json:
        regions: Json = {}
        for _ in range(2):
            name = self.name("region")
            regions[name] = self._compound(depth)
            self.plain.append(name)
        self.regions.append([list(region["states"]) for region in regions.values()])
        self.rooms.append(("parallel", list(regions.items())))
        return {"parallel": regions}

    def _final(self, depth: int) -> Json:
        return {"final": self.draw(st.sampled_from(["succeeded", "failed", "aborted", "canceled"]))}

    def _history(self, depth: int) -> Json:
        return {"history": self.draw(st.sampled_from(["shallow", "deep"]))}

    def connect(self) -> None:
        """Give every state its transitions."""
        for word, room in self.rooms:
            for index, (_, state) in enumerate(room):
                if "final" not in state and "history" not in state:
                    forward = (
                        [name for name, other in room[index + 1 :] if "history" not in other]
                        if word == "states"
                        else []
                    )
                    if transitions := self.transitions(state, forward):
                        state["transitions"] = transitions

    def transitions(self, state: Json, forward: list[str]) -> list[Json]:
        transitions: list[Json] = []
        for option in state.get("decision", {}).get("options", ()):
            transitions.append(self.transition({"on": option}, self.anywhere(), raising=True))
        ends = self.draw(st.sampled_from([(), ("succeeded",), ("succeeded", "failed"), (list(ACTIVITY_ENDS[1:]),)]))
        if state.keys() & {"action", "call"}:
            transitions += [self.transition({"on": end}, self.anywhere(), raising=True) for end in ends]
            if "rejected" in str(ends) and may_lack(state):
                transitions[-1]["on"] = [end for end in transitions[-1]["on"] if end != "rejected"]
                transitions += [{"on": "rejected", "to": self.draw(st.sampled_from(forward))}] if forward else []
        elif "read" in state and forward:
            do: Json = {"do": [{"set": "wanted", "from": "reading.goal"}]}
            transitions.append({"on": "succeeded", "to": self.draw(st.sampled_from(forward)), **do})
            transitions.append(self.transition({"on": ["unclear", "refused"]}, self.draw(st.sampled_from(forward))))
        elif state.keys() & {"tree", "states", "parallel", "each", "plan"} and forward:
            transitions += [self.transition({"on": end}, self.draw(st.sampled_from(forward))) for end in ends]
        for _ in range(self.draw(st.integers(0, 2))):
            transitions.append(self.outside_transition())
        if forward and self.draw(st.integers(0, 3)) == 0:
            transitions.append(self.transition({"when": self.guard()}, self.draw(st.sampled_from(forward))))
        if forward and self.draw(st.integers(0, 3)) == 0:
            transitions.append(self.transition({"on": HINT}, self.draw(st.sampled_from(forward))))
        return transitions

    def outside_transition(self) -> Json:
        """A transition that only something from outside, or time, can fire."""
        trigger = self.draw(
            st.one_of(
                st.sampled_from(EVENTS).map(lambda name: {"on": name}),
                st.sampled_from([{"on": list(EVENTS[:2])}, {"after_s": 5.0}]),
            )
        )
        guard = self.draw(st.none() | st.just(True))
        trigger = {**trigger, **({"when": self.guard()} if guard else {})}
        return self.transition(trigger, self.anywhere() if self.draw(st.integers(0, 4)) else None, raising=True)

    def anywhere(self) -> Any:
        several = [region for region in self.regions if all(region)]
        if several and self.draw(st.integers(0, 3)) == 0:
            return [self.draw(st.sampled_from(inside)) for inside in self.draw(st.sampled_from(several))]
        return self.draw(st.sampled_from(self.targets))

    def guard(self) -> Json:
        given: Json = self.draw(guards(tuple(self.plain)))
        return given

    def transition(self, trigger: Json, to: Any, *, raising: bool = False) -> Json:
        do = self.draw(effects(raising=raising))
        transition = {**trigger, **({"to": to} if to is not None else {})}
        return {**transition, "do": do or [{"log": "stays"}]} if to is None or do else transition


def may_lack(state: Json) -> bool:
    """Whether what a state sends may have an unknown part: then it is `rejected` in the step in which it begins."""
    sites = (template_paths(state.get(word, {})) for word in ("goal", "request"))
    sure = {name for name, key in KEYS.items() if "initial" in key}
    return any(path.partition(".")[0] not in sure for paths in sites for path, _ in paths)


@st.composite
def mission_documents(draw: Draw) -> Json:
    """A mission as JSON has it: of every kind of state, with names and targets that exist."""
    draft = _Draft(draw)
    states = draft.states(DEPTH)
    begin = next(iter(states))
    end = draft.name("final")
    states[end] = {"final": "aborted"}
    draft.targets.append(end)
    draft.connect()
    document: Json = {
        "format": 1,
        "name": "generated",
        "version": "1.0.0",
        "blackboard": KEYS,
        "events": {name: {} for name in (*EVENTS, HINT)},
        "initial": begin,
        "states": states,
    }
    transitions: list[Json] = [{"on": "halt", "to": end}] if draw(st.booleans()) else []
    if draw(st.booleans()):
        transitions.append({"when": {"all": [{"not": {"in": end}}, {"key": "battery", "<": 0.15}]}, "to": end})
    if draw(st.integers(0, 2)) == 0:
        transitions.append({"on": "*", "when": draft.guard(), "do": [{"log": "heard"}]})
    if transitions:
        document["transitions"] = transitions
    if draw(st.booleans()):
        document["invariants"] = {"always": draw(guards(tuple(draft.plain), timed=False))}
    return document


def missions() -> st.SearchStrategy[Mission]:
    """Missions of every kind of state, guard, effect and tree node, small enough to look at."""
    return mission_documents().map(Mission.model_validate)
