# SPDX-License-Identifier: Apache-2.0
"""After each step nothing is left that could fire or tick, anyone who wrote what made it so.

It is looked for by brute force: the guard of each transition without an event, one more tick of each tree on a copy,
what each goal and each final waits for. A leaf that has ended may be begun again by that tick, which in the chart only
an event that concerns the tree does (`docs/guide/trees.md`); it is taken to end as it did.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.activities.action import GoalActivity, GoalMachine
from rai_missions.engine.activities.goal_ledger import obstruction
from rai_missions.engine.activities.ticker import TickResult, TreeState
from rai_missions.engine.activities.tree import TreeActivity
from rai_missions.engine.semantics.hold import awake, free
from rai_missions.engine.semantics.macrostep import enabled
from rai_missions.engine.step import CallService, StartGoal, Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from rai_missions.states.tree import Decision, Tree
from tests.laws.test_chart import happenings
from tests.rigs.charts import ScriptedRobot
from tests.rigs.laws import drill
from tests.strategies import mission_documents
from tests.trees.growing import FACTS, is_true
from tests.trees.polling import COUNTERS, FLAGS, polled_trees

Json = dict[str, Any]
lenient = settings(suppress_health_check=list(HealthCheck))

# -- what is left ---------------------------------------------------------------------------------------------------


def left(chart: Chart, step: Step, ends: dict[str, str]) -> Iterator[str]:
    """What could fire or tick, in words; what is held waits until control is given back.

    Args:
        chart: After the step.
        step: The step.
        ends: Owner of a leaf → how it has ended.
    """
    program, run = chart.program, chart.state
    if chart.mode not in ("running", "canceling") or chart.outcome is not None or run.final is not None:
        return
    for transition in enabled(run, free(run, run.config.eventless), []):
        yield f"{transition.place} could fire"
    for name in run.settling.keys() - chart.held:
        requires = program.graph.nodes[name].requires
        assert requires is not None
        if requires.test(run) is True:
            yield f"'{name}' could be reached"
    for name, machine, state in awake(program, run):
        if isinstance(state, TreeActivity):
            if name not in step.resting:
                yield from unticked(chart, name, state, ends)
            for path, tended in state.leaves.items():
                leaf = machine.leaf_machines[path].machine  # type: ignore[attr-defined]
                yield from unsettled(chart, f"{name}#{path}", leaf, tended.state)
        else:
            yield from unsettled(chart, name, machine, state)


def unsettled(chart: Chart, name: str, machine: Any, state: Any) -> Iterator[str]:
    if isinstance(machine, GoalMachine) and isinstance(state, GoalActivity):
        if state.phase == "settling" and (machine.achieved is None or machine.achieved(chart.view) is True):
            yield f"'{name}' has achieved what it is for"
        if (
            state.phase == "waiting"
            and obstruction(chart.state.goals, chart.robot_facts, machine.definition.action) != "busy"
        ):
            yield f"'{name}' could start"


def unticked(chart: Chart, name: str, state: TreeActivity, ends: dict[str, str]) -> Iterator[str]:
    """Whether a tick would make another tree: what runs, and what it counts and remembers."""
    node = chart.program.graph.nodes[name]
    assert isinstance(node.state, Tree)
    ticker = CompiledTrees().compile(node.state.tree, f"{node.place}/tree", chart.mission.blackboard, name)
    ticked = ticker.tick(state.tree, chart.view, {})
    for _ in range(20):
        if any(isinstance(node, Decision) and path in ticked.started for path, node in node.state.tree.paths()):
            return  # which option it would be again is not known here
        if not (begun := again(name, ticked, state.tree, ends)):
            break
        ticked = ticker.tick(ticked.state, chart.view, begun)
    if what_runs(ticked.state) != what_runs(state.tree) or ticked.status != "running":
        yield f"the tree in '{name}' could tick: {what_runs(state.tree)} → {ticked.status} {what_runs(ticked.state)}"


def again(name: str, ticked: TickResult, before: TreeState, ends: dict[str, str]) -> dict[str, str]:
    """The leaves that a tick has begun though they have ended before, with how they end."""
    found = {path: ends.get(f"{name}#{path}", "") for path in ticked.started}
    for path in found:
        memory = before.nodes.get(path, {})
        found[path] = {"success": "succeeded", "failure": "failed"}.get(memory.get("status", ""), found[path])
    return {path: end for path, end in found.items() if end}


def what_runs(tree: TreeState) -> Any:
    passing = ("run", "until", "began", "held", "refused")
    running = {
        path: {word: value for word, value in memory.items() if word not in passing}
        for path, memory in tree.nodes.items()
        if memory["status"] == "running" and path
    }
    return running, sorted(tree.leaves)


class Run:
    """A chart to which things happen, and how its leaves have ended."""

    def __init__(self, document: Json) -> None:
        self.chart = Chart(Mission.model_validate(document), CompiledTrees())
        self.owners: dict[int, str] = {}
        self.ends: dict[str, str] = {}
        self.robot = ScriptedRobot()
        self.take(self.chart.start(0.0))

    def send(self, event: Event) -> Step:
        if event.kind == "result" and event.number in self.owners:
            self.ends[self.owners[event.number]] = event.name
        return self.take(self.chart.send(event))

    def take(self, step: Step) -> Step:
        for effect in self.robot.follow(step).effects:
            if isinstance(effect, StartGoal | CallService) and effect.owner:
                self.owners[effect.number] = effect.owner
        assert not list(left(self.chart, step, self.ends))
        return step


def live(document: Json, script: list[tuple[Any, float]]) -> None:
    run, at = Run(document), 0.0
    for drawn, wait in script:
        at += wait
        run.send(run.robot.event(drawn, at))


# -- what is drawn --------------------------------------------------------------------------------------------------

keys: Json = {key: {"type": "boolean", "source": "robot", "max_age_s": 3} for key in FACTS}
keys |= {key: {"type": "boolean", "initial": False} for key in FLAGS}
keys |= {key: {"type": "integer", "initial": 0} for key in COUNTERS}
guards = st.one_of(
    st.sampled_from((*FACTS, *FLAGS)).map(is_true),
    st.sampled_from(FLAGS).map(lambda key: {"not": is_true(key)}),
    st.builds(lambda key, number: {"key": key, ">": number}, st.sampled_from(COUNTERS[:3]), st.integers(0, 3)),
    st.builds(lambda key, seconds: {"held": is_true(key), "for_s": seconds}, st.sampled_from(FLAGS), st.integers(1, 2)),
)
effects = st.lists(
    st.one_of(
        st.builds(lambda key, value: {"set": key, "value": value}, st.sampled_from(FLAGS), st.booleans()),
        st.builds(lambda key: {"set": key, "add": 1}, st.sampled_from(COUNTERS[:3])),
    ),
    max_size=2,
)


def tree_region(number: int, tree: Json, back: Json, do: list[Json]) -> Json:
    work, idle = f"work{number}", f"idle{number}"
    ends = {"on": ["succeeded", "failed"], "to": idle}
    states = {work: {"tree": tree, "transitions": [ends]}, idle: {"transitions": [{**back, "to": work, "do": do}]}}
    return {"initial": work, "states": states}


def transition_region(number: int, transitions: list[tuple[Json, list[Json]]]) -> Json:
    """States in a line, each left by a transition that waits for its guard, the last by an event."""
    names = [f"s{number}_{index}" for index in range(len(transitions) + 1)]
    states: Json = {
        name: {"transitions": [{"when": guard, "to": after, "do": do}]}
        for name, after, (guard, do) in zip(names, names[1:], transitions, strict=False)
    }
    states[names[-1]] = {"transitions": [{"on": "poke", "to": names[0], "do": transitions[0][1]}]}
    return {"initial": names[0], "states": states}


backs = st.one_of(st.just({"on": "poke"}), st.just({"after_s": 1}), guards.map(lambda guard: {"when": guard}))
tree_regions = st.builds(tree_region, st.integers(10, 10_000), polled_trees, backs, effects)
transition_regions = st.builds(
    transition_region, st.integers(10, 10_000), st.lists(st.tuples(guards, effects), min_size=1, max_size=3)
)


def side_by_side(trees: list[Json], transitions: list[Json]) -> Json:
    regions = {f"region{number}": region for number, region in enumerate((*trees, *transitions))}
    states = {"all": {"parallel": regions}}
    return {"name": "m", "initial": "all", "blackboard": keys, "events": {"poke": {}}, "states": states}


def named_once(regions: tuple[list[Json], list[Json]]) -> bool:
    names = [name for region in (*regions[0], *regions[1]) for name in region["states"]]
    return len(set(names)) == len(names)


counting = st.builds(
    lambda number, asked, rest, do: side_by_side(
        [tree_region(1, {"selector": [counted(number), rest], "memory": False}, {"on": "poke"}, [])],
        [transition_region(2, [({"key": "n0", ">": asked}, do)])],
    ),
    st.integers(1, 6),
    st.integers(0, 5),
    st.sampled_from([{"wait_s": 1.5}, {"call": "horn"}]),
    effects,
)
"""A transition waits for what a tree counts."""


def counted(number: int) -> Json:
    return {"sequence": [{"set": "n0", "add": 1}, {"check": {"key": "n0", ">": number}}], "memory": False}


several = (
    st.tuples(st.lists(tree_regions, min_size=1, max_size=2), st.lists(transition_regions, max_size=2))
    .filter(named_once)
    .map(lambda regions: side_by_side(*regions))
)
with_trees = st.one_of(several, several, counting)
things = st.one_of(
    st.tuples(st.just("write"), st.sampled_from(FACTS), st.booleans()),
    st.tuples(st.just("write"), st.sampled_from(FLAGS), st.booleans()),
    st.tuples(st.just("result"), st.integers(0, 3), st.sampled_from(["succeeded", "failed"])),
    st.just(("event", "poke")),
    st.just(("tick", "")),
)
scripts = st.lists(st.tuples(things, st.sampled_from([0.0, 0.0, 0.5, 1.0, 2.5, 7.0])), max_size=10)


@settings(lenient, max_examples=15)
@given(with_trees, scripts)
def test_after_each_step_nothing_is_left_where_trees_and_transitions_write(document: Json, script: Any) -> None:
    live(document, script)


@lenient
@given(mission_documents(), happenings(commands=False))
def test_after_each_step_nothing_is_left_in_a_mission_of_every_kind(document: Json, script: Any) -> None:
    live(document, script)


test_nothing_is_left_in_many_missions_with_trees = drill(
    live, with_trees, scripts, tried=settings(lenient, max_examples=3000)
)


test_nothing_is_left_in_many_missions = drill(
    live, mission_documents(), happenings(commands=False), tried=settings(lenient, max_examples=3000)
)


def test_a_tree_that_no_one_has_ticked_is_found() -> None:
    tree = {"selector": [{"check": is_true("f")}, {"wait_s": 9}]}
    run = Run(side_by_side([tree_region(1, tree, {"on": "poke"}, [])], []))
    run.chart.view.board["f"] = run.chart.view.board["f"]._replace(value=True)
    assert list(left(run.chart, run.chart.send(Tick(0.0)), {}))
