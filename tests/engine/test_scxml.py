# SPDX-License-Identifier: Apache-2.0
"""SCXML's rules, one example each (REC-scxml-20150901, sections 3 and appendix D)."""

from __future__ import annotations

import pytest

from rai_missions.event import Event
from tests.rigs.charts import chart, sent, ticked, transition


def log(text: str) -> dict[str, str]:
    return {"log": text}


def logged(step: object) -> list[str]:
    return [effect.text for effect in step.effects]  # type: ignore[attr-defined]


def test_transitions_are_tried_in_the_order_written() -> None:
    made = chart({"a": {"transitions": [transition("e", "b"), transition("e", "c")]}, "b": {}, "c": {}})
    assert sent(made, "e").entered == ("b",)


def test_an_inner_transition_is_tried_before_an_outer_one() -> None:
    inner = {"initial": "x", "states": {"x": {"transitions": [transition("e", "y")]}, "y": {}}}
    made = chart({"a": {**inner, "transitions": [transition("e", "b")]}, "b": {}})
    assert sent(made, "e").entered == ("y",)
    assert sent(made, "e").entered == ("b",)


def test_the_mission_s_own_transitions_come_last() -> None:
    made = chart({"a": {"transitions": [transition("e", "b")]}, "b": {}, "c": {}}, transitions=[transition("e", "c")])
    assert sent(made, "e").entered == ("b",)
    assert sent(made, "e").entered == ("c",)


def test_a_guard_that_is_false_or_unknown_leaves_the_next_transition_its_chance() -> None:
    never = {"key": "n", ">": 5}
    states = {"a": {"transitions": [transition("e", "b", when=never), transition("e", "c")]}, "b": {}, "c": {}}
    assert sent(chart(states, blackboard={"n": {"type": "integer", "initial": 0}}), "e").entered == ("c",)
    assert sent(chart(states, blackboard={"n": {"type": "integer"}}), "e").entered == ("c",)


def test_exit_is_innermost_first_then_the_transition_then_entry_outermost_first() -> None:
    states = {
        "a": {
            "initial": "b", "exit": [log("out a")],
            "states": {"b": {"exit": [log("out b")], "transitions": [transition("e", "d", do=[log("way")])]}},
        },
        "c": {"initial": "d", "entry": [log("in c")], "states": {"d": {"entry": [log("in d")]}}},
    }  # fmt: skip
    step = sent(chart(states), "e")
    assert logged(step) == ["out b", "out a", "way", "in c", "in d"]
    assert (step.exited, step.entered) == (("b", "a"), ("c", "d"))


def test_a_transition_into_its_own_compound_state_leaves_and_enters_it_unless_internal() -> None:
    inside = {"x": {}, "y": {}}
    outer = chart({"a": {"initial": "x", "states": inside, "transitions": [transition("e", "y")]}})
    step = sent(outer, "e")
    assert (step.exited, step.entered) == (("x", "a"), ("a", "y"))
    inner = chart({"a": {"initial": "x", "states": inside, "transitions": [transition("e", "y", internal=True)]}})
    step = sent(inner, "e")
    assert (step.exited, step.entered) == (("x",), ("y",))


def test_a_transition_without_a_target_leaves_nothing() -> None:
    made = chart({"a": {"initial": "x", "states": {"x": {}}, "transitions": [transition("e", do=[log("seen")])]}})
    step = sent(made, "e")
    assert (step.exited, step.entered, logged(step)) == ((), (), ["seen"])
    assert step.moves and not step.ignored


def test_a_self_transition_leaves_and_enters_its_state() -> None:
    step = sent(chart({"a": {"transitions": [transition("e", "a")]}}), "e")
    assert (step.exited, step.entered) == (("a",), ("a",))


def test_initial_may_name_any_descendant() -> None:
    made = chart({"a": {"initial": "z", "states": {"b": {"initial": "y", "states": {"y": {}, "z": {}}}}}})
    assert made.active == {"a", "b", "z"}


REGIONS = {
    "p": {
        "parallel": {
            "r": {
                "initial": "r1",
                "states": {"r1": {"transitions": [transition("e", "r2"), transition("f", "r2")]}, "r2": {}},
            },
            "s": {"initial": "s1", "states": {"s1": {"transitions": [transition("e", "s2")]}, "s2": {}}},
        }
    },
    "q": {},
}


def test_every_region_takes_its_transition_in_one_step() -> None:
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


def test_of_two_transitions_that_leave_the_same_state_the_first_in_document_order_is_taken() -> None:
    assert sent(chart(conflicting(transition("e", "q"), transition("e", "z"))), "e").entered == ("q",)
    assert sent(chart(conflicting(transition("e", "r2"), transition("e", "z"))), "e").entered == ("r2",)


def test_a_descendant_s_transition_preempts_its_ancestor_s() -> None:
    states = conflicting(transition("e", "r2"), transition("g", "s2"))
    states["p"]["transitions"] = [transition("e", "q")]
    made = chart(states)
    assert sent(made, "e").entered == ("r2",)


def test_a_transition_that_is_preempted_preempts_no_other() -> None:
    regions = {
        f"r{n}": {
            "initial": f"a{n}",
            "states": {f"a{n}": {"transitions": [transition("e", f"b{n}")] if n else []}, f"b{n}": {}},
        }
        for n in range(4)
    }
    made = chart({"p": {"parallel": regions, "transitions": [transition("e", "q")]}, "q": {}})
    assert sent(made, "e").entered == ("b1", "b2", "b3")


def test_a_target_in_another_region_leaves_and_enters_the_whole_parallel_state() -> None:
    step = sent(chart(conflicting(transition("e", "s2"), transition("g", "s2"))), "e")
    assert step.exited == ("s1", "s", "r1", "r", "p")
    assert step.entered == ("p", "r", "r1", "s", "s2")


def test_targets_may_name_a_state_in_each_region() -> None:
    states = {
        **conflicting(transition("g", "r2"), transition("g", "s2")),
        "a": {"transitions": [transition("e", ["r2", "s2"])]},
    }
    made = chart(states, "a")
    assert sent(made, "e").entered == ("p", "r", "r2", "s", "s2")


def history(kind: str) -> dict:
    return {
        "a": {
            "initial": "b",
            "states": {
                "b": {"initial": "x", "states": {"x": {"transitions": [transition("e", "y")]}, "y": {}}},
                "c": {},
                "back": {"history": kind},
            },
            "transitions": [transition("out", "q"), transition("over", "c")],
        },
        "q": {"transitions": [transition("home", "back")]},
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


def test_the_same_transition_into_history_leads_elsewhere_once_something_else_is_remembered() -> None:
    made = chart(history("deep"))
    assert sent(made, "out", "home").entered == ("a", "b", "x")
    assert sent(made, "e", "out", "home").entered == ("a", "b", "y")
    assert sent(made, "over", "out", "home").entered == ("a", "c")


def test_a_final_child_is_its_parent_s_success() -> None:
    states = {
        "a": {"initial": "x", "states": {"x": {"transitions": [transition("e", "f")]}, "f": {"final": "succeeded"}},
              "transitions": [transition("succeeded", "b")]},
        "b": {},
    }  # fmt: skip
    step = sent(chart(states), "e")
    assert [move.entered for move in step.moves] == [("f",), ("b",)]


def parallel_of(*finals: str) -> dict:
    regions = {
        f"r{index}": {
            "initial": f"x{index}",
            "states": {
                f"x{index}": {"transitions": [transition(f"e{index}", f"f{index}")]},
                f"f{index}": {"final": final},
            },
        }
        for index, final in enumerate(finals)
    }
    transitions = [transition(name, name[:2]) for name in ("succeeded", "failed", "aborted", "canceled")]
    return {
        "p": {"parallel": regions, "transitions": transitions},
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


def test_eventless_transitions_run_until_none_is_enabled() -> None:
    low = {"key": "n", "<": 3}
    states = {
        "a": {
            "transitions": [
                transition(to="a", when=low, do=[{"set": "n", "add": 1}]),
                transition(to="b", when={"not": low}),
            ]
        },
        "b": {},
    }
    made = chart(states, blackboard={"n": {"type": "integer", "initial": 0}}, started=False)
    assert [move.entered for move in made.start().moves] == [("a",), ("a",), ("a",), ("a",), ("b",)]


def test_eventless_transitions_come_before_internal_events_and_those_before_external_ones() -> None:
    states = {
        "a": {"transitions": [transition("e", "b", do=[{"raise": "inner"}])]},
        "b": {"transitions": [transition(to="c", when={"all": []}), transition("inner", "wrong")]},
        "c": {"transitions": [transition("inner", "d")]},
        "d": {"transitions": [transition("e", "z")]},
        "wrong": {}, "z": {},
    }  # fmt: skip
    made = chart(states)
    step = sent(made, "e")
    assert [move.entered for move in step.moves] == [("b",), ("c",), ("d",)]


def test_internal_events_are_taken_in_the_order_in_which_they_were_raised() -> None:
    states = {
        "a": {"transitions": [transition("e", "b", do=[{"raise": "one"}, {"raise": "two"}])]},
        "b": {"transitions": [transition("one", do=[log("one")]), transition("two", do=[log("two")])]},
    }
    assert logged(sent(chart(states), "e")) == ["one", "two"]


def test_a_cycle_without_end_is_a_fault_that_names_its_states() -> None:
    always = {"all": []}
    made = chart({"a": {"transitions": [transition("e", "b")]}, "b": {"transitions": [transition(to="c", when=always)]},
                  "c": {"transitions": [transition(to="b", when=always)]}})  # fmt: skip
    step = sent(made, "e")
    assert step.outcome == "failed"
    assert step.why == "a cycle without end: b → c"


def test_a_delayed_event_comes_after_its_time_and_only_then() -> None:
    made = chart({"a": {"entry": [{"raise": "late", "after_s": 5}], "transitions": [transition("late", "b")]}, "b": {}})
    assert made.wake_at == 5.0
    assert ticked(made, 4.9).moves == ()
    assert ticked(made, 5.0).entered == ("b",)
    assert made.wake_at is None


def test_a_delayed_event_can_be_dropped() -> None:
    states = {
        "a": {
            "entry": [{"raise": "late", "after_s": 5, "id": "x"}],
            "transitions": [transition("stop", do=[{"drop": "x"}]), transition("late", "b")],
        },
        "b": {},
    }
    made = chart(states)
    sent(made, "stop")
    assert made.wake_at is None
    assert ticked(made, 9.0).moves == ()


def test_a_delayed_event_outlives_the_state_that_raised_it() -> None:
    states = {
        "a": {"entry": [{"raise": "late", "after_s": 5}], "transitions": [transition("e", "b")]},
        "b": {"transitions": [transition("late", "c")]},
        "c": {},
    }
    made = chart(states)
    sent(made, "e", at=1.0)
    assert ticked(made, 5.0).entered == ("c",)


def test_after_counts_from_the_entry_and_ends_with_the_state() -> None:
    states = {
        "a": {"transitions": [transition("e", "b"), transition(after_s=3, to="z")]},
        "b": {"transitions": [transition("e", "a")]},
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
            "transitions": [
                transition(after_s=3, to="z", when={"key": "n", ">": 0}),
                transition("e", do=[{"set": "n", "value": 1}]),
            ]
        },
        "z": {},
    }
    made = chart(states, blackboard={"n": {"type": "integer", "initial": 0}})
    ticked(made, 3.0)
    sent(made, "e")
    assert ticked(made, 99.0).moves == () and made.active == {"a"}


def test_timers_that_are_due_fire_in_order_each_to_completion_before_the_event() -> None:
    states = {
        "a": {"transitions": [transition(after_s=2, to="b")]}, "b": {"transitions": [transition(after_s=3, to="c")]},
        "c": {"transitions": [transition("e", "d")]}, "d": {},
    }  # fmt: skip
    made = chart(states)
    step = made.send(Event("e", 50.0))
    assert [move.entered for move in step.moves] == [("b",), ("c",), ("d",)]


def test_a_top_level_final_ends_the_mission() -> None:
    made = chart({"a": {"transitions": [transition("e", "f")]}, "f": {"final": "aborted"}})
    step = sent(made, "e")
    assert (step.outcome, step.why) == ("aborted", "'f' was reached")
    late = sent(made, "e")
    assert late.ignored is False or late.why == "the mission has ended"
    assert late.moves == ()


def test_a_star_takes_any_declared_event_and_no_outcome() -> None:
    made = chart({"a": {"transitions": [transition("*", "b")]}, "b": {}}, events=["x", "y"])
    assert sent(made, "y").entered == ("b",)


def test_an_event_that_is_not_declared_is_refused_with_what_there_is() -> None:
    step = sent(chart({"a": {"transitions": [transition("go", "b")]}, "b": {}}), "goo")
    assert step.ignored and step.why == "the mission declares no event 'goo'; did you mean 'go'?"


def test_an_ignored_event_changes_nothing() -> None:
    made = chart({"a": {"transitions": [transition("e", "b")]}, "b": {}}, events=["e", "f"])
    before = made.snapshot()
    step = sent(made, "f")
    assert step.ignored
    assert {**made.snapshot(), "seq": 0} == {**before, "seq": 0, "event": {}}
