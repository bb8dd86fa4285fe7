# SPDX-License-Identifier: Apache-2.0
"""Trees and what happens to them, as hypothesis draws them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from hypothesis import settings
from hypothesis import strategies as st

from rai_missions.guards.view import Truth
from rai_missions.keys import Stamped

FACTS = ("a", "b", "c")
often = settings(max_examples=4 * settings().max_examples)
"""For laws over trees: most small trees are alike."""


class Facts(NamedTuple):
    """A view as a chart gives it."""

    at: float
    board: Mapping[str, Stamped]
    active: frozenset[str] = frozenset()
    entered: Mapping[str, float] = {}
    true_since: Mapping[str, float] = {}
    event: Mapping[str, Any] = {}
    answer: Mapping[str, Any] = {}

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        return None

    def note(self, text: str) -> None:
        return None


def seen(at: float, facts: Mapping[str, Any]) -> Any:
    """A view of these facts, stamped with this time; a fact that is None was never received."""
    return Facts(at, {key: Stamped(value, at) for key, value in facts.items() if value is not None})


def is_true(key: str) -> dict[str, Any]:
    return {"key": key, "==": True}


durations = st.integers(0, 4).map(lambda whole: whole + 0.5)
"""Seconds; ticks come at whole seconds, so that `at the deadline` and `after it` are the same."""
leaves = st.one_of(
    st.sampled_from(FACTS).map(lambda key: {"check": is_true(key)}),
    st.sampled_from([{"action": "drive"}, {"call": "horn"}]),
    st.sampled_from([{"action": "drive"}, {"call": "horn"}]),
    durations.map(lambda seconds: {"wait_s": seconds}),
)
CONVERTERS = (
    "inverter", "failure_is_success", "failure_is_running", "success_is_failure", "success_is_running",
    "running_is_failure", "running_is_success", "pass_through",
)  # fmt: skip

guards = st.recursive(
    st.one_of(
        st.sampled_from(FACTS).map(is_true),
        st.sampled_from(FACTS).map(lambda key: {"fresh": key}),
        durations.map(lambda seconds: {"elapsed_s": seconds}),
    ),
    lambda inner: st.one_of(
        inner.map(lambda guard: {"not": guard}),
        st.builds(lambda guard, seconds: {"held": guard, "for_s": seconds}, inner, durations),
        st.builds(lambda guard, seconds: {"held": guard, "for_s": seconds}, inner, durations),
        st.lists(inner, min_size=1, max_size=2).map(lambda given: {"any": given}),
    ),
    max_leaves=3,
)


def asked(given: dict[str, Any]) -> dict[str, Any]:
    return {"decision": {"question": "Left or right?", "options": {"left": {}, "right": {}}}, "then": given}


def branches(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    children = st.lists(inner, min_size=1, max_size=4)
    return st.one_of(
        st.builds(lambda given, memory: {"sequence": given, "memory": memory}, children, st.booleans()),
        st.builds(lambda given, memory: {"selector": given, "memory": memory}, children, st.booleans()),
        st.builds(lambda given, memory: {"selector": given, "memory": memory}, children, st.just(False)),
        st.builds(parallel, children, st.sampled_from(["success_on_all", "success_on_one", [0]]), st.booleans()),
        st.builds(lambda child, word: {word: child}, inner, st.sampled_from(CONVERTERS)),
        st.builds(lambda child, n: {"retry": n, "child": child}, inner, st.integers(1, 3)),
        st.builds(lambda child, n: {"repeat": n, "child": child}, inner, st.sampled_from([-1, 1, 2, 3])),
        st.builds(lambda child, seconds: {"timeout": seconds, "child": child}, inner, durations),
        st.builds(lambda child, policy: {"one_shot": child, "policy": policy}, inner, st.sampled_from(ONE_SHOTS)),
        st.builds(lambda child, word: {"condition": word, "child": child}, inner, st.sampled_from(STATUSES)),
        st.builds(lambda child, key: {"eternal_guard": is_true(key), "child": child}, inner, st.sampled_from(FACTS)),
    )


def parallel(given: list[Any], policy: Any, synchronise: bool) -> dict[str, Any]:
    return {"parallel": given, "policy": policy, "synchronise": synchronise}


ONE_SHOTS = ("on_completion", "on_successful_completion")
STATUSES = ("success", "failure", "running")
plain = st.recursive(leaves, branches, max_leaves=10)
trees = st.one_of(
    plain,
    st.builds(lambda check, high, low: {"selector": [{"sequence": [check, high]}, low]}, leaves, plain, plain),
    st.builds(lambda high, low: {"sequence": [high, low], "memory": False}, plain, plain),
)
"""Trees that plain py_trees can be given as well."""
rich_leaves = st.one_of(
    leaves,
    guards.map(lambda guard: {"check": guard}),
    st.sampled_from([{"set": "n", "add": 1}, {"set": "n", "from": "m"}, {"set": "c", "value": True}]),
    st.just({"publish": "spoken", "message": {"n": {"from": "n"}}}),
)


def rich_branches(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.one_of(
        branches(inner),
        st.builds(lambda guard, child: {"eternal_guard": guard, "child": child}, guards, inner),
        st.builds(lambda child: {"status_to_blackboard": "spoken", "child": child}, inner),
        st.dictionaries(st.sampled_from(["left", "right"]), inner).map(asked),
    )


rich_trees = st.recursive(rich_leaves, rich_branches, max_leaves=10)
"""Trees with everything that a mission can write."""
facts = st.fixed_dictionaries({key: st.sampled_from([True, True, False, None]) for key in FACTS})


class Moment(NamedTuple):
    """What has happened until a tick."""

    facts: Mapping[str, bool | None]
    ends: tuple[str, ...]
    """The outcomes that running leaves come to, in the order of their paths; empty for one that runs on."""
    later_s: int


ENDS = ("", "succeeded", "succeeded", "failed", "left", "right")
moments = st.builds(
    Moment,
    facts,
    st.lists(st.sampled_from(ENDS), min_size=3, max_size=3).map(tuple),
    st.integers(0, 3),
)
lives = st.lists(moments, min_size=1, max_size=8)
long_lives = st.lists(moments, min_size=1, max_size=25)


def lasting(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """Trees that run on, whatever their parts report: what they look at is looked at again and again."""
    parts = st.lists(inner, min_size=1, max_size=4)
    last: dict[str, Any] = {"wait_s": 999.5}
    watching = st.builds(
        lambda word, given, memory: {word: [*({WATCHED[word]: each} for each in given), last], "memory": memory},
        st.sampled_from(["selector", "sequence"]),
        parts,
        st.sampled_from([False, False, False, True]),
    )
    return st.one_of(
        watching,
        watching,
        st.builds(lambda given: {"parallel": given}, st.lists(watching, min_size=1, max_size=3)),
        st.builds(
            lambda key, child: {"failure_is_running": {"eternal_guard": is_true(key), "child": child}},
            st.sampled_from(FACTS),
            watching,
        ),
    )


WATCHED = {"selector": "success_is_failure", "sequence": "failure_is_success"}
lasting_trees = lasting(rich_trees)


def guarded(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """Branches that a guard leads: a sequence that it opens, or a selector that it spares."""
    return st.builds(
        lambda word, key, given: {word: [{"check": is_true(key)}, *given]},
        st.sampled_from(["sequence", "selector"]),
        st.sampled_from(FACTS),
        st.lists(inner, max_size=2),
    )


checks = st.sampled_from(FACTS).map(lambda key: {"check": is_true(key)})
guarded_trees = lasting(guarded(st.one_of(checks, leaves, guarded(leaves))))
flips = st.tuples(
    st.sampled_from(FACTS),
    st.sampled_from([True, False, None]),
    st.lists(st.sampled_from(ENDS), min_size=3, max_size=3).map(tuple),
    st.sampled_from([0, 0, 0, 1]),
)


def _one_by_one(drawn: list[Any]) -> list[Moment]:
    known: dict[str, bool | None] = {"a": False, "b": False, "c": False}
    life = []
    for key, value, ends, later_s in drawn:
        known = {**known, key: value}
        life.append(Moment(known, ends, later_s))
    return life


flipping_lives = st.lists(flips, min_size=5, max_size=25).map(_one_by_one)
"""Lives in which one fact changes at a time, mostly at one instant."""
