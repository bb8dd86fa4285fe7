# SPDX-License-Identifier: Apache-2.0
"""What a step leads to happens in that step, also where it takes the short way; and what counts while it is held."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from math import inf, nan
from typing import Any

import pytest

from rai_missions.errors import UsageError
from rai_missions.event import Event
from tests.rigs.charts import chart, sent, transition

OK: Any = {"key": "ok", "==": True}
KEYS: Any = {"ok": {"type": "boolean", "source": "robot", "optional": True}, "n": {"type": "integer", "initial": 0}}


class Later(float):
    """A number that a program made, such as NumPy's."""


@pytest.mark.parametrize("is_quick", [True, False])
@pytest.mark.parametrize("kind", ["event", "write", "tick"])
@pytest.mark.parametrize("at", [True, False, Decimal(3), Fraction(7, 2), "3", None, inf, -inf, nan, 3j, [3.0]])
def test_what_is_no_time_is_refused_on_either_way_and_changes_nothing(at: Any, kind: str, is_quick: bool) -> None:
    made = chart({"a": {"transitions": [transition("go", "b")]}, "b": {}}, blackboard=KEYS)
    made.send(Event("ok", 1.0, {"value": False}, "write"))
    if not is_quick:
        made.send(Event("pause", 1.0, kind="command"))
    before = made.snapshot()
    assert made.state.quick is is_quick
    name = {"event": "go", "write": "ok", "tick": "tick"}[kind]
    with pytest.raises(UsageError, match="seconds"):
        made.send(Event(name, at, {"value": True} if kind == "write" else {}, kind))  # type: ignore[arg-type]
    assert made.snapshot() == before


@pytest.mark.parametrize("is_quick", [True, False])
@pytest.mark.parametrize("is_watched", [True, False])
@pytest.mark.parametrize("stamp", [True, Decimal(1), "1", None, inf, -inf, nan, [1.0]])
def test_a_reading_whose_stamp_is_no_time_is_refused_and_changes_nothing(
    stamp: Any, is_watched: bool, is_quick: bool
) -> None:
    waits = [transition(to="b", when=OK)] if is_watched else [transition("go", "b")]
    made = chart({"a": {"transitions": waits}, "b": {}}, blackboard=KEYS)
    made.send(Event("ok", 1.0, {"value": False}, "write"))
    if not is_quick:
        made.send(Event("pause", 1.0, kind="command"))
    before = made.snapshot()
    with pytest.raises(UsageError, match="the stamp of 'ok' takes"):
        made.send(Event("ok", 2.0, {"value": True, "stamp": stamp}, "write"))
    assert made.snapshot() == before


@pytest.mark.parametrize(("stamp", "counts"), [(3, 3.0), (Later(1.5), 1.5), (2.5, 2.5), (9.0, 4.0), (-5, -5.0)])
def test_a_reading_counts_from_its_stamp_and_never_from_the_future(stamp: Any, counts: float) -> None:
    made = chart({"a": {"transitions": [transition("go", "b")]}, "b": {}}, blackboard=KEYS)
    made.send(Event("ok", 4.0, {"value": True, "stamp": stamp}, "write"))
    assert made.view.board["ok"] == (True, counts)


@pytest.mark.parametrize("at", [3, 3.0, Later(3.0), 2**60])
def test_any_number_is_a_time(at: Any) -> None:
    made = chart({"a": {"transitions": [transition("go", "b")]}, "b": {}}, blackboard=KEYS)
    assert made.send(Event("go", at)).entered == ("b",) and made.at == at


def test_what_a_transition_raises_happens_in_its_step_each_time() -> None:
    transitions = [transition("e", do=[{"raise": "f"}]), transition("f", do=[{"set": "n", "add": 1}])]
    made = chart({"a": {"transitions": transitions}}, blackboard=KEYS)
    assert [sent(made, "e").writes for _ in range(3)] == [(("n", 1),), (("n", 2),), (("n", 3),)]


def test_what_a_transition_writes_is_seen_in_its_step_each_time() -> None:
    transitions = [transition("e", do=[{"set": "n", "add": 1}]), transition(to="b", when={"key": "n", "==": 3})]
    made = chart({"a": {"transitions": transitions}, "b": {}}, blackboard=KEYS)
    assert [sent(made, "e").entered for _ in range(3)] == [(), (), ("b",)]


def test_an_inner_end_that_nothing_confirms_is_unverified_at_once_where_no_time_is_given() -> None:
    inner = {"at": {"transitions": [transition("e", "end")]}, "end": {"final": "succeeded", "requires": OK}}
    work = {
        "initial": "at",
        "states": inner,
        "transitions": [transition("unverified", "lost"), transition("succeeded", "lost")],
    }
    made = chart({"work": work, "lost": {}}, settle_s=0, blackboard=KEYS)
    step = sent(made, "e", at=1.0)
    assert step.moves[-1].trigger == "unverified" and made.active == {"lost"}


def test_an_end_that_waits_for_the_facts_has_its_deadline_though_the_operator_takes_control() -> None:
    made = chart(
        {
            "work": {"control": "autonomy", "transitions": [transition("e", "end")]},
            "end": {"final": "succeeded", "control": "autonomy", "requires": OK},
        },
        settle_s=2,
        blackboard=KEYS,
    )
    assert sent(made, "e", at=1.0).wake_at == 3.0
    made.send(Event("operator", 1.5, {"by": "operator", "role": "operator"}, "control"))
    assert made.wake_at == 3.0
    assert made.send(Event("tick", 3.0, kind="tick")).outcome == "failed"


def test_the_time_in_a_state_counts_each_time_where_only_the_guard_of_an_event_looks_at_it() -> None:
    aged, way_out = {"elapsed_s": 5}, transition("back", "a")
    made = chart({
        "a": {"transitions": [transition("go", "b")]},
        "b": {"transitions": [transition("on", "c", when=aged), way_out]},
        "c": {"transitions": [way_out]},
    })  # fmt: skip
    for begin in (0.0, 20.0, 40.0):
        for name, after_s, led_to in (("go", 2, "b"), ("on", 6.9, "b"), ("on", 7, "c"), ("back", 8, "a")):
            made.send(Event(name, begin + after_s))
            assert made.active == {led_to}, (begin, name)


def test_the_active_states_are_those_of_the_last_event_each_time() -> None:
    made = chart({"a": {"transitions": [transition("go", "b")]}, "b": {"transitions": [transition("go", "a")]}})
    for led_to in ("b", "a", "b", "a", "b"):
        assert sent(made, "go").entered == (led_to,)
        assert made.active == {led_to}
