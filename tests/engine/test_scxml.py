# SPDX-License-Identifier: Apache-2.0
"""SCXML's rules, one example each (REC-scxml-20150901, sections 3 and appendix D)."""

from __future__ import annotations

import pytest

from rai_missions.event import Event
from tests.rigs.charts import chart, row, sent, ticked


def log(text: str) -> dict[str, str]:
    return {"log": text}


def told(step: object) -> list[str]:
    return [effect.text for effect in step.effects]  # type: ignore[attr-defined]


def test_rows_are_tried_in_the_order_written() -> None:
    made = chart({"a": {"transitions": [row("e", "b"), row("e", "c")]}, "b": {}, "c": {}})
    assert sent(made, "e").entered == ("b",)


def test_an_inner_row_is_tried_before_an_outer_one() -> None:
    inner = {"initial": "x", "states": {"x": {"transitions": [row("e", "y")]}, "y": {}}}
    made = chart({"a": {**inner, "transitions": [row("e", "b")]}, "b": {}})
    assert sent(made, "e").entered == ("y",)
    assert sent(made, "e").entered == ("b",)


def test_the_mission_s_own_rows_come_last() -> None:
    made = chart({"a": {"transitions": [row("e", "b")]}, "b": {}, "c": {}}, transitions=[row("e", "c")])
    assert sent(made, "e").entered == ("b",)
    assert sent(made, "e").entered == ("c",)


def test_a_guard_that_is_false_or_unknown_leaves_the_next_row_its_chance() -> None:
    never = {"key": "n", ">": 5}
    states = {"a": {"transitions": [row("e", "b", when=never), row("e", "c")]}, "b": {}, "c": {}}
    assert sent(chart(states, blackboard={"n": {"type": "integer", "initial": 0}}), "e").entered == ("c",)
    assert sent(chart(states, blackboard={"n": {"type": "integer"}}), "e").entered == ("c",)


def test_exit_is_innermost_first_then_the_row_then_entry_outermost_first() -> None:
    states = {
        "a": {
            "initial": "b", "exit": [log("out a")],
            "states": {"b": {"exit": [log("out b")], "transitions": [row("e", "d", do=[log("row")])]}},
        },
        "c": {"initial": "d", "entry": [log("in c")], "states": {"d": {"entry": [log("in d")]}}},
    }  # fmt: skip
    step = sent(chart(states), "e")
    assert told(step) == ["out b", "out a", "row", "in c", "in d"]
    assert (step.exited, step.entered) == (("b", "a"), ("c", "d"))


def test_a_row_into_its_own_compound_state_leaves_and_enters_it_unless_internal() -> None:
    inside = {"x": {}, "y": {}}
    outer = chart({"a": {"initial": "x", "states": inside, "transitions": [row("e", "y")]}})
    step = sent(outer, "e")
    assert (step.exited, step.entered) == (("x", "a"), ("a", "y"))
    inner = chart({"a": {"initial": "x", "states": inside, "transitions": [row("e", "y", internal=True)]}})
    step = sent(inner, "e")
    assert (step.exited, step.entered) == (("x",), ("y",))


def test_a_row_without_a_target_leaves_nothing() -> None:
    made = chart({"a": {"initial": "x", "states": {"x": {}}, "transitions": [row("e", do=[log("seen")])]}})
    step = sent(made, "e")
    assert (step.exited, step.entered, told(step)) == ((), (), ["seen"])
    assert step.moves and not step.ignored


def test_a_self_transition_leaves_and_enters_its_state() -> None:
    step = sent(chart({"a": {"transitions": [row("e", "a")]}}), "e")
    assert (step.exited, step.entered) == (("a",), ("a",))


def test_initial_may_name_any_descendant() -> None:
    made = chart({"a": {"initial": "z", "states": {"b": {"initial": "y", "states": {"y": {}, "z": {}}}}}})
    assert made.active == {"a", "b", "z"}


REGIONS = {
    "p": {
        "parallel": {
            "r": {"initial": "r1", "states": {"r1": {"transitions": [row("e", "r2"), row("f", "r2")]}, "r2": {}}},
            "s": {"initial": "s1", "states": {"s1": {"transitions": [row("e", "s2")]}, "s2": {}}},
        }
    },
    "q": {},
}


def test_every_region_takes_its_row_in_one_step() -> None:
    made = chart(REGIONS)
    assert made.active == {"p", "r", "r1", "s", "s1"}
    step = sent(made, "e")
    assert len(step.moves) == 1 and set(step.entered) == {"r2", "s2"}
    assert step.exited == ("s1", "r1")


def test_an_event_for_one_region_leaves_the_other_alone() -> None:
    made = chart(REGIONS)
    assert sent(made, "f").exited == ("r1",)
    assert made.active == {"p", "r", "r2", "s", "s1"}


def conflicting(first: dict, second: dict) -> dict:
    return {
        "p": {
            "parallel": {
                "r": {"initial": "r1", "states": {"r1": {"transitions": [first]}, "r2": {}}},
                "s": {"initial": "s1", "states": {"s1": {"transitions": [second]}, "s2": {}}},
            }
        },
        "q": {}, "z": {},
    }  # fmt: skip


def test_of_two_rows_that_leave_the_same_state_the_first_in_document_order_is_taken() -> None:
    assert sent(chart(conflicting(row("e", "q"), row("e", "z"))), "e").entered == ("q",)
    assert sent(chart(conflicting(row("e", "r2"), row("e", "z"))), "e").entered == ("r2",)


def test_a_descendant_s_row_preempts_its_ancestor_s() -> None:
    states = conflicting(row("e", "r2"), row("g", "s2"))
    states["p"]["transitions"] = [row("e", "q")]
    made = chart(states)
    assert sent(made, "e").entered == ("r2",)


def test_a_target_in_another_region_leaves_and_enters_the_whole_parallel_state() -> None:
    step = sent(chart(conflicting(row("e", "s2"), row("g", "s2"))), "e")
    assert step.exited == ("s1", "s", "r1", "r", "p")
    assert step.entered == ("p", "r", "r1", "s", "s2")


def test_targets_may_name_a_state_in_each_region() -> None:
    states = {**conflicting(row("g", "r2"), row("g", "s2")), "a": {"transitions": [row("e", ["r2", "s2"])]}}
    made = chart(states, "a")
    assert sent(made, "e").entered == ("p", "r", "r2", "s", "s2")


def history(kind: str) -> dict:
    return {
        "a": {
            "initial": "b",
            "states": {
                "b": {"initial": "x", "states": {"x": {"transitions": [row("e", "y")]}, "y": {}}},
                "c": {},
                "back": {"history": kind},
            },
            "transitions": [row("out", "q"), row("over", "c")],
        },
        "q": {"transitions": [row("home", "back")]},
    }  # fmt: skip


def test_deep_history_leads_back_to_the_innermost_states() -> None:
    made = chart(history("deep"))
    assert sent(made, "e", "out", "home").entered == ("a", "b", "y")


def test_shallow_history_leads_back_to_the_child_and_its_initial() -> None:
    made = chart(history("shallow"))
    assert sent(made, "e", "out", "home").entered == ("a", "b", "x")
    assert sent(made, "over", "out", "home").entered == ("a", "c")


def test_history_without_memory_leads_to_the_parent_s_initial() -> None:
    assert sent(chart(history("deep"), "q"), "home").entered == ("a", "b", "x")


def test_the_same_row_into_history_leads_elsewhere_once_something_else_is_remembered() -> None:
    made = chart(history("deep"))
    assert sent(made, "out", "home").entered == ("a", "b", "x")
    assert sent(made, "e", "out", "home").entered == ("a", "b", "y")
    assert sent(made, "over", "out", "home").entered == ("a", "c")


def test_a_final_child_is_its_parent_s_success() -> None:
    states = {
        "a": {"initial": "x", "states": {"x": {"transitions": [row("e", "f")]}, "f": {"final": "succeeded"}},
              "transitions": [row("succeeded", "b")]},
        "b": {},
    }  # fmt: skip
    step = sent(chart(states), "e")
    assert [move.entered for move in step.moves] == [("f",), ("b",)]


def parallel_of(*finals: str) -> dict:
    regions = {
        f"r{index}": {
            "initial": f"x{index}",
            "states": {f"x{index}": {"transitions": [row(f"e{index}", f"f{index}")]}, f"f{index}": {"final": final}},
        }
        for index, final in enumerate(finals)
    }
    rows = [row(name, name[:2]) for name in ("succeeded", "failed", "aborted", "canceled")]
    return {
        "p": {"parallel": regions, "transitions": rows},
        "su": {}, "fa": {}, "ab": {}, "ca": {},
    }  # fmt: skip


@pytest.mark.parametrize(
    ("finals", "worst"),
    [
        (("succeeded", "succeeded"), "su"), (("succeeded", "failed"), "fa"), (("canceled", "aborted"), "ab"),
        (("succeeded", "canceled"), "ca"), (("aborted", "failed"), "fa"),
    ],
)  # fmt: skip
def test_a_parallel_state_ends_with_the_worst_of_its_regions_once_all_have_ended(finals: tuple, worst: str) -> None:
    made = chart(parallel_of(*finals))
    assert sent(made, "e1").entered == ("f1",)
    assert sent(made, "e0").entered == ("f0", worst)


def test_a_region_s_failure_waits_for_the_other_region() -> None:
    made = chart(parallel_of("failed", "succeeded"))
    sent(made, "e0")
    assert made.outcome is None and "p" in made.active


def test_eventless_rows_run_until_none_is_enabled() -> None:
    low = {"key": "n", "<": 3}
    states = {
        "a": {"transitions": [row(to="a", when=low, do=[{"set": "n", "add": 1}]), row(to="b", when={"not": low})]},
        "b": {},
    }
    made = chart(states, blackboard={"n": {"type": "integer", "initial": 0}}, started=False)
    assert [move.entered for move in made.start().moves] == [("a",), ("a",), ("a",), ("a",), ("b",)]


def test_eventless_rows_come_before_internal_events_and_those_before_external_ones() -> None:
    states = {
        "a": {"transitions": [row("e", "b", do=[{"raise": "inner"}])]},
        "b": {"transitions": [row(to="c", when={"all": []}), row("inner", "wrong")]},
        "c": {"transitions": [row("inner", "d")]},
        "d": {"transitions": [row("e", "z")]},
        "wrong": {}, "z": {},
    }  # fmt: skip
    made = chart(states)
    step = sent(made, "e")
    assert [move.entered for move in step.moves] == [("b",), ("c",), ("d",)]


def test_internal_events_are_taken_in_the_order_in_which_they_were_raised() -> None:
    states = {
        "a": {"transitions": [row("e", "b", do=[{"raise": "one"}, {"raise": "two"}])]},
        "b": {"transitions": [row("one", do=[log("one")]), row("two", do=[log("two")])]},
    }
    assert told(sent(chart(states), "e")) == ["one", "two"]


def test_a_cycle_without_end_is_a_fault_that_names_its_states() -> None:
    always = {"all": []}
    made = chart({"a": {"transitions": [row("e", "b")]}, "b": {"transitions": [row(to="c", when=always)]},
                  "c": {"transitions": [row(to="b", when=always)]}})  # fmt: skip
    step = sent(made, "e")
    assert step.outcome == "failed"
    assert step.why == "a cycle without end: b → c"


def test_a_delayed_event_comes_after_its_time_and_only_then() -> None:
    made = chart({"a": {"entry": [{"raise": "late", "after_s": 5}], "transitions": [row("late", "b")]}, "b": {}})
    assert made.wake_at == 5.0
    assert ticked(made, 4.9).moves == ()
    assert ticked(made, 5.0).entered == ("b",)
    assert made.wake_at is None


def test_a_delayed_event_can_be_dropped() -> None:
    states = {
        "a": {
            "entry": [{"raise": "late", "after_s": 5, "id": "x"}],
            "transitions": [row("stop", do=[{"drop": "x"}]), row("late", "b")],
        },
        "b": {},
    }
    made = chart(states)
    sent(made, "stop")
    assert made.wake_at is None
    assert ticked(made, 9.0).moves == ()


def test_a_delayed_event_outlives_the_state_that_raised_it() -> None:
    states = {
        "a": {"entry": [{"raise": "late", "after_s": 5}], "transitions": [row("e", "b")]},
        "b": {"transitions": [row("late", "c")]},
        "c": {},
    }
    made = chart(states)
    sent(made, "e", at=1.0)
    assert ticked(made, 5.0).entered == ("c",)


def test_after_counts_from_the_entry_and_ends_with_the_state() -> None:
    states = {
        "a": {"transitions": [row("e", "b"), row(after_s=3, to="z")]},
        "b": {"transitions": [row("e", "a")]},
        "z": {},
    }
    made = chart(states)
    sent(made, "e", at=2.0)
    assert made.wake_at is None
    sent(made, "e", at=10.0)
    assert made.wake_at == 13.0
    assert ticked(made, 13.0).entered == ("z",)


def test_after_with_a_false_guard_is_lost() -> None:
    states = {
        "a": {
            "transitions": [row(after_s=3, to="z", when={"key": "n", ">": 0}), row("e", do=[{"set": "n", "value": 1}])]
        },
        "z": {},
    }
    made = chart(states, blackboard={"n": {"type": "integer", "initial": 0}})
    ticked(made, 3.0)
    sent(made, "e")
    assert ticked(made, 99.0).moves == () and made.active == {"a"}


def test_timers_that_are_due_fire_in_order_each_to_completion_before_the_event() -> None:
    states = {
        "a": {"transitions": [row(after_s=2, to="b")]}, "b": {"transitions": [row(after_s=3, to="c")]},
        "c": {"transitions": [row("e", "d")]}, "d": {},
    }  # fmt: skip
    made = chart(states)
    step = made.send(Event("e", 50.0))
    assert [move.entered for move in step.moves] == [("b",), ("c",), ("d",)]


def test_a_top_level_final_ends_the_mission() -> None:
    made = chart({"a": {"transitions": [row("e", "f")]}, "f": {"final": "aborted"}})
    step = sent(made, "e")
    assert (step.outcome, step.why) == ("aborted", "'f' was reached")
    late = sent(made, "e")
    assert late.ignored is False or late.why == "the mission has ended"
    assert late.moves == ()


def test_a_star_takes_any_declared_event_and_no_outcome() -> None:
    made = chart({"a": {"transitions": [row("*", "b")]}, "b": {}}, events=["x", "y"])
    assert sent(made, "y").entered == ("b",)


def test_an_event_that_is_not_declared_is_refused_with_what_there_is() -> None:
    step = sent(chart({"a": {"transitions": [row("go", "b")]}, "b": {}}), "goo")
    assert step.ignored and step.why == "the mission declares no event 'goo'; did you mean 'go'?"


def test_an_ignored_event_changes_nothing() -> None:
    made = chart({"a": {"transitions": [row("e", "b")]}, "b": {}}, events=["e", "f"])
    before = made.snapshot()
    step = sent(made, "f")
    assert step.ignored
    assert {**made.snapshot(), "seq": 0} == {**before, "seq": 0, "event": {}}
