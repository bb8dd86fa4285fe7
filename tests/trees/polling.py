# SPDX-License-Identifier: Apache-2.0
"""Trees that write what they look at, in a chart and in plain py_trees that is polled until nothing changes.

Rule: where `docs/guide/trees.md` lists a difference, nothing is drawn or compared: in a composite without memory only
the last child takes more than one tick, what is counted is counted where it is looked at, and a key that a tree writes
and never looks at is not compared.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import py_trees
from hypothesis import strategies as st
from py_trees import decorators
from py_trees.common import Status

from rai_missions.engine import Chart
from rai_missions.engine.activities.tree import TreeActivity
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from rai_missions.states import tree
from tests.trees.growing import CONVERTERS, FACTS, STATUSES, durations, is_true, parallel
from tests.trees.oracle import ActionLeaf, Oracle, recorded

__all__ = ("COUNTERS", "Pair", "PolledOracle", "Ran", "lives", "polled_trees")

Json = dict[str, Any]
FLAGS = ("f", "g")
"""Keys that trees write, and look at."""
COUNTERS = tuple(f"n{number}" for number in range(12))
"""Keys that count, one a place."""
HIGHEST = 4
"""No check asks a counter for more."""

# -- what is drawn --------------------------------------------------------------------------------------------------

known = st.sampled_from((*FACTS, *FLAGS))
checks = known.map(lambda key: {"check": is_true(key)})
writes = st.one_of(
    st.builds(lambda key, value: {"set": key, "value": value}, st.sampled_from(FLAGS), st.booleans()),
    st.builds(lambda key, source: {"set": key, "from": source}, st.sampled_from(FLAGS), known),
)
counts = st.builds(
    lambda op, number, memory: {
        "sequence": [{"set": COUNTERS[0], "add": 1}, {"check": {"key": COUNTERS[0], op: number}}],
        "memory": memory,
    },
    st.sampled_from([">", "<", ">="]),
    st.integers(1, HIGHEST),
    st.booleans(),
)
quick = st.recursive(
    st.one_of(checks, checks, writes, counts),
    lambda inner: st.one_of(
        st.builds(lambda word, child: {word: child}, st.sampled_from(["inverter", "failure_is_success"]), inner),
        st.builds(
            lambda word, given, memory: {word: given, "memory": memory},
            st.sampled_from(["sequence", "selector"]),
            st.lists(inner, min_size=1, max_size=3),
            st.booleans(),
        ),
        st.builds(lambda key, child: {"eternal_guard": is_true(key), "child": child}, known, inner),
        inner.map(lambda child: {"one_shot": child, "policy": "on_completion"}),
    ),
    max_leaves=4,
)
"""What ends in the tick in which it begins, and does the same again at the next."""
leaves = st.one_of(
    quick,
    durations.map(lambda seconds: {"wait_s": seconds}),
    st.just({"call": "horn"}),
    durations.map(lambda seconds: {"call": "horn", "timeout_s": seconds}),
)


def branches(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    children = st.lists(inner, min_size=1, max_size=3)
    word = st.sampled_from(["sequence", "selector"])
    watched = st.builds(lambda first, last: [*first, last], st.lists(quick, max_size=2), inner)
    return st.one_of(
        st.builds(lambda word, given: {word: given, "memory": True}, word, children),
        st.builds(lambda word, given: {word: given, "memory": False}, word, watched),
        st.builds(parallel, children, st.sampled_from(["success_on_all", "success_on_one", [0]]), st.booleans()),
        st.builds(lambda child, word: {word: child}, inner, st.sampled_from(CONVERTERS)),
        st.builds(lambda child, n: {"retry": n, "child": child}, inner, st.integers(1, 3)),
        st.builds(lambda child, n: {"repeat": n, "child": child}, inner, st.sampled_from([-1, 1, 2, 3])),
        st.builds(lambda child, seconds: {"timeout": seconds, "child": child}, inner, durations),
        inner.map(lambda child: {"one_shot": child, "policy": "on_completion"}),
        st.builds(lambda child, status: {"condition": status, "child": child}, inner, st.sampled_from(STATUSES)),
        st.builds(lambda child, key: {"eternal_guard": is_true(key), "child": child}, inner, known),
    )


def numbered(node: Any, numbers: Iterator[int]) -> Any:
    """Each place that counts has a key of its own."""
    if isinstance(node, dict) and isinstance(node.get("sequence"), list) and "add" in node["sequence"][0]:
        key = COUNTERS[next(numbers) % len(COUNTERS)]
        add, check = node["sequence"]
        return {**node, "sequence": [{**add, "set": key}, {"check": {**check["check"], "key": key}}]}
    if isinstance(node, dict):
        return {word: numbered(each, numbers) for word, each in node.items()}
    return [numbered(each, numbers) for each in node] if isinstance(node, list) else node


watching = st.one_of(
    st.builds(lambda quick, rest: {"selector": [quick, rest], "memory": False}, quick, leaves),
    st.builds(lambda quick, rest: {"sequence": [quick, rest], "memory": False}, quick, leaves),
    st.builds(lambda given: {"failure_is_running": {"sequence": given}}, st.lists(quick, min_size=1, max_size=3)),
    st.builds(lambda given: {"repeat": -1, "child": {"selector": given}}, st.lists(quick, min_size=1, max_size=3)),
    st.builds(lambda child, times: {"repeat": times, "child": child}, leaves, st.integers(2, 3)),
)
"""Small trees in which what is written is looked at again."""
polled_trees = (
    st.one_of(st.recursive(leaves, branches, max_leaves=10), watching, st.recursive(watching, branches, max_leaves=4))
    .map(lambda drawn: numbered(drawn, iter(range(1000))))
    .filter(lambda drawn: str(drawn).count("'add'") <= len(COUNTERS))
)


class PollEvent(NamedTuple):
    """What happens after so many half seconds: a fact, or the end of the call that runs at such a place."""

    later: int
    fact: tuple[str, bool] | None = None
    ends: tuple[int, str] | None = None


lives = st.lists(
    st.one_of(
        st.builds(PollEvent, st.integers(0, 4), st.tuples(st.sampled_from(FACTS), st.booleans()), st.none()),
        st.builds(
            PollEvent,
            st.integers(0, 2),
            st.none(),
            st.tuples(st.integers(0, 2), st.sampled_from(["succeeded", "succeeded", "failed"])),
        ),
    ),
    max_size=8,
)

# -- plain py_trees -------------------------------------------------------------------------------------------------

MOST_POLLS = 300


class Compare(py_trees.behaviour.Behaviour):
    """A check of a counter."""

    script: Any
    guard: Any

    def update(self) -> Status:
        found, guard = self.script.facts[self.guard.key], self.guard
        asked: Any = guard.operand
        holds = {">": found > asked, ">=": found >= asked, "<": found < asked}[guard.op]
        return Status.SUCCESS if holds else Status.FAILURE


class Put(py_trees.behaviour.Behaviour):
    """Writes a key."""

    script: Any
    node: Any

    def update(self) -> Status:
        facts, node = self.script.facts, self.node
        value = facts[node.set] + node.add if node.add is not None else node.value
        if node.from_ is not None:
            value = facts.get(node.from_)
        if value is None:
            return Status.FAILURE
        facts[node.set] = value
        return Status.SUCCESS


class Wait(py_trees.behaviour.Behaviour):
    """A timer that is over at its deadline."""

    script: Any
    wait_s = until = 0.0

    def initialise(self) -> None:
        self.until = self.script.at + self.wait_s

    def update(self) -> Status:
        return Status.SUCCESS if self.script.at >= self.until else Status.RUNNING


class Ring(ActionLeaf):
    """A call that may have a time."""

    timeout_s: float | None = None
    begun = 0.0

    def initialise(self) -> None:
        super().initialise()
        self.begun = self.script.at

    def update(self) -> Status:
        status = super().update()
        is_over = self.timeout_s is not None and self.script.at >= self.begun + self.timeout_s
        return Status.FAILURE if status is Status.RUNNING and is_over else status


class PolledOracle(Oracle):
    """The same tree in plain py_trees, ticked until nothing changes."""

    def __init__(self, root: tree.TreeNode, monkeypatch: Any) -> None:
        super().__init__(root, monkeypatch)
        self.facts: Json = {**dict.fromkeys(FLAGS, False), **dict.fromkeys(COUNTERS, 0)}
        nodes = [node for _, node in root.paths()]
        self.is_counting = any(isinstance(node, tree.Set) and node.add for node in nodes)
        looked_at = {
            getattr(getattr(node, "check", getattr(node, "guard", None)), "key", getattr(node, "from_", None))
            for node in nodes
        }
        self.looked_at = tuple(key for key in FLAGS if key in looked_at)

    def make(self, node: Any, children: list[Any]) -> Any:
        made: Any
        match node:
            case tree.Check() if node.check.key in COUNTERS:
                made = recorded(Compare)(node.word)
                made.guard = node.check
            case tree.Set():
                made = recorded(Put)(node.word)
                made.node = node
            case tree.Wait():
                made = recorded(Wait)(node.word)
                made.wait_s = node.wait_s
            case tree.Call():
                made = recorded(Ring)(node.word)
                made.timeout_s = node.timeout_s
            case tree.Timeout():  # over at its deadline, not only after it
                made = recorded(decorators.Timeout)(node.word, children[0], node.duration_s - 1e-9)
            case _:
                made = super().make(node, children)
        return made

    def poll(self, at: float, outcomes: Mapping[str, str]) -> bool:
        """Tick until nothing changes; whether that came to pass, or the same comes again and again."""
        same, wanted = 0, 2 * HIGHEST + 3 if self.is_counting else 1
        before, seen = None, list[Any]()
        for _ in range(MOST_POLLS):
            self.tick(at, self.facts, outcomes)
            outcomes = {}
            if self.root.status in (Status.SUCCESS, Status.FAILURE):
                return True
            now = self._now()
            same = same + 1 if now == before else 0
            if same == wanted:
                return True
            if now != before and now in seen and not self.is_counting:
                return False
            seen.append(now)
            before = now
        return False

    def reaches(self, at: float, rig: Any) -> bool:
        """Whether polling that goes round comes by this are."""
        for _ in range(MOST_POLLS):
            if self.state_now() == rig:
                return True
            self.tick(at, self.facts, {})
        return False

    def state_now(self) -> Json:
        """What runs, and what the tree has written."""
        running = sorted(path for path, status in self.statuses().items() if status == "running")
        calls = [path for path in running if isinstance(self.nodes[path], Ring)]
        return {"running": running, "calls": calls, **{key: self.facts[key] for key in self.looked_at}}

    def _now(self) -> Any:
        words = ("status", "failures", "final_status", "current_child")
        nodes = [[getattr(node, word, None) for word in words] for node in self.nodes.values()]
        rounds = [node.success for node in self.nodes.values() if getattr(node, "num_success", -1) > 0]
        return nodes, rounds, {key: value for key, value in self.facts.items() if key not in COUNTERS}


# -- both -----------------------------------------------------------------------------------------------------------


class Ran(NamedTuple):
    """How both are after something has happened."""

    has_settled: bool
    """Polling came to an end, or goes round and comes by where the chart's tree rests."""
    resting: tuple[str, ...]
    end: tuple[str, str]
    """How each has ended: `success`, `failure`, or `running`."""
    ours: Mapping[str, Any]
    """What runs, and what the tree has written."""
    polled: Mapping[str, Any]


def mission_of(drawn: Json) -> Mission:
    ends = [{"on": "succeeded", "to": "success"}, {"on": "failed", "to": "failure"}]
    keys: Json = {key: {"type": "boolean", "source": "robot"} for key in FACTS}
    keys |= {key: {"type": "boolean", "initial": False} for key in FLAGS}
    keys |= {key: {"type": "integer", "initial": 0} for key in COUNTERS}
    states = {
        "work": {"tree": drawn, "transitions": ends}, "success": {"final": "aborted"}, "failure": {"final": "failed"}
    }  # fmt: skip
    return Mission.model_validate({"name": "m", "initial": "work", "blackboard": keys, "states": states})


class Pair:
    """A chart and polled py_trees that go through the same."""

    def __init__(self, drawn: Json, monkeypatch: Any) -> None:
        self.chart = Chart(mission_of(drawn), CompiledTrees())
        self.polled = PolledOracle(tree.TreeNode.read(drawn), monkeypatch)
        self.half_s, self.has_settled = 0, True

    def live(self, life: list[PollEvent]) -> Iterator[Ran]:
        self.step = self.chart.start(0.0)
        self._poll({})
        yield self._ran()
        for each in life:
            if self.chart.outcome is not None:
                return
            yield from self._happen(each)

    def _poll(self, outcomes: Mapping[str, str]) -> None:
        if self.polled.root.status not in (Status.SUCCESS, Status.FAILURE):
            self.has_settled = self.polled.poll(self.half_s / 2, outcomes) and self.has_settled

    def _happen(self, each: PollEvent) -> Iterator[Ran]:
        for _ in range(each.later):
            self.half_s += 1
            self._poll({})
        at = self.half_s / 2
        if each.later:
            self.step = self.chart.send(Tick(at))
            yield self._ran()
        if each.fact is not None:
            self.polled.facts.update([each.fact])
            self._poll({})
            self.step = self.chart.write(*each.fact, at)
            yield self._ran()
        running = self._tending().leaves if self._tending() is not None else {}
        if each.ends is not None and running:
            number, end = each.ends
            path = sorted(running)[number % len(running)]
            self._poll({path: end})
            self.step = self.chart.send(Event(end, at, {}, "result", running[path].state.number))
            yield self._ran()

    def _tending(self) -> Any:
        return self.chart.state.running.get("work")

    def _ran(self) -> Ran:
        state, board = self._tending(), self.chart.view.board
        ended = next(iter({"success", "failure"} & set(self.chart.view.active)), "running")
        if not isinstance(state, TreeActivity):
            return Ran(self.has_settled, self.step.resting, (ended, self._end()), {}, {})
        ours: Json = {key: board[key].value for key in self.polled.looked_at}
        ours["running"] = sorted(path for path, node in state.tree.nodes.items() if node["status"] == "running")
        ours["calls"] = sorted(state.leaves)
        if not self.has_settled and not self.step.resting:
            self.has_settled = self.polled.reaches(self.half_s / 2, ours)
        return Ran(self.has_settled, self.step.resting, (ended, self._end()), ours, self.polled.state_now())

    def _end(self) -> str:
        return {Status.SUCCESS: "success", Status.FAILURE: "failure"}.get(self.polled.root.status, "running")
