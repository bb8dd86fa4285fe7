# SPDX-License-Identifier: Apache-2.0
# ruff: noqa: E501
"""W3C's assertions about SCXML interpreters (the implementation report plan), those that a mission can express.

The numbers are those of the plan's tests. Each chart ends in `pass` or `fail`; a transition that must not fire leads to `fail`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import pytest

from rai_missions.event import Event, Tick
from tests.oracles.ours import logged
from tests.rigs.charts import chart, transition

Json = dict[str, Any]
COUNT = {"n": {"type": "integer", "initial": 0}}
FAIL = transition("*", "fail")
ENDS: Json = {"pass": {"final": "succeeded"}, "fail": {"final": "failed"}}


def put(value: int) -> Json:
    return {"set": "n", "value": value}


def up() -> Json:
    return {"set": "n", "add": 1}


def is_(value: int) -> Json:
    return {"key": "n", "==": value}


def raising(*names: str) -> list[Json]:
    return [{"raise": name} for name in names]


def verdict(value: int) -> list[Json]:
    """Transitions that pass if n is a value and fail if not."""
    return [transition(to="pass", when=is_(value)), transition(to="fail", when={"not": is_(value)})]


class Assertion(NamedTuple):
    number: int
    sentence: str
    states: Json
    initial: Any = None
    until_s: float = 0.0
    """A tick at this time is what is sent."""
    send: tuple[str, ...] = ()


def regions(**states: Json) -> Json:
    return {"parallel": states}


def compound(initial: Any, states: Json, **words: Any) -> Json:
    return {"initial": initial, "states": states, **words}


PLAN = [
    Assertion(144, "events are taken from the internal queue in the order in which they were raised", {
        "a": {"entry": raising("foo", "bar"), "transitions": [transition("foo", "b"), FAIL]},
        "b": {"transitions": [transition("bar", "pass"), FAIL]},
    }),
    Assertion(158, "executable content is executed in document order", {
        "a": {"entry": raising("event1", "event2"), "transitions": [transition("event1", "b"), FAIL]},
        "b": {"transitions": [transition("event2", "pass"), FAIL]},
    }),
    Assertion(172, "what is raised can depend on what was assigned before it in the same block", {
        "a": {"entry": [put(2), *raising("event1")], "transitions": [transition("event1", "pass", when=is_(2)), FAIL]},
    }),
    Assertion(175, "a delayed event waits for as long as it was logged", {
        "a": {"entry": [{"raise": "event2", "after_s": 1.0}, {"raise": "event1", "after_s": 0.5}],
              "transitions": [transition("event1", "b"), transition("event2", "fail")]},
        "b": {"transitions": [transition("event2", "pass"), FAIL]},
    }, until_s=2.0),
    Assertion(186, "what a delayed event carries is settled when it is sent, not when it comes", {
        "a": {"entry": [{"raise": "later", "after_s": 1.0, "data": {"v": {"from": "n"}}}, put(2)],
              "transitions": [transition("later", "pass", when={"key": "event.v", "==": 0}), FAIL]},
    }, until_s=2.0),
    Assertion(189, "internal events come before external ones", {
        "a": {"transitions": [transition("go", "b", do=[{"raise": "external", "after_s": 0.0}, *raising("internal")])]},
        "b": {"transitions": [transition("internal", "pass"), transition("external", "fail")]},
    }, send=("go", "tick")),
    Assertion(208, "a delayed event that is canceled does not come", {
        "a": {"entry": [{"raise": "event1", "after_s": 1.0, "id": "foo"}, {"raise": "event2", "after_s": 1.5}, {"drop": "foo"}],
              "transitions": [transition("event2", "pass"), FAIL]},
    }, until_s=2.0),
    Assertion(355, "without 'initial' … with one, the state it names is the one entered", {"a": {"transitions": verdict(0)}}),
    Assertion(364, "an initial names deep descendants, one in each region", {
        "s1": compound(["s11p112", "s11p122"], {
            "s11": compound("s111", {"s111": {"transitions": [transition(to="fail", when=is_(0))]}}),
            "s11p1": regions(
                s11p11=compound("s11p111", {"s11p111": {"transitions": [transition(to="fail", when=is_(0))]},
                                            "s11p112": {"entry": raising("in_first")}}),
                s11p12=compound("s11p121", {"s11p121": {"transitions": [transition(to="fail", when=is_(0))]},
                                            "s11p122": {"transitions": [transition("in_first", "pass")]}}),
            ),
        }),
    }),
    Assertion(372, "the end of a compound state is reported after the final's entry and before its exit", {
        "a": compound("end", {"end": {"final": "succeeded", "entry": [put(2)], "exit": [put(3)]}},
                      transitions=[transition("succeeded", "pass", when=is_(2)), transition("succeeded", "fail")]),
    }),
    Assertion(375, "entry effects are executed in document order", {
        "a": {"entry": [*raising("event1"), *raising("event2")], "transitions": [transition("event1", "b"), FAIL]},
        "b": {"transitions": [transition("event2", "pass"), FAIL]},
    }),
    Assertion(377, "exit effects are executed in document order", {
        "a": {"exit": raising("event1", "event2"), "transitions": [transition(to="b", when=is_(0))]},
        "b": {"transitions": [transition("event1", "c"), FAIL]},
        "c": {"transitions": [transition("event2", "pass"), FAIL]},
    }),
    Assertion(387, "a history without memory leads to the default", {
        "a": {"transitions": [transition(to="deep", when=is_(0))]},
        "s": compound("s1", {"deep": {"history": "deep"},
                             "s1": compound("s11", {"s11": {"entry": raising("right")}, "s12": {"entry": raising("wrong")}}),
                             "s2": {}}, transitions=[transition("right", "pass"), transition("wrong", "fail")]),
    }),
    Assertion(388, "shallow history recalls the child, deep history the innermost state", {
        "s0": compound("s012", {
            "s01": compound("s011", {"s011": {"entry": raising("in_s011")}, "s012": {"entry": raising("in_s012")}}),
            "shallow": {"history": "shallow"}, "deep": {"history": "deep"},
        }, entry=[up()], transitions=[
            transition("in_s012", "s1", when=is_(1)), transition("in_s012", "s2", when=is_(2)), transition("in_s011", "pass", when=is_(3)),
            transition(["in_s011", "in_s012"], "fail"),
        ]),
        "s1": {"transitions": [transition(to="deep", when=is_(1))]},
        "s2": {"transitions": [transition(to="shallow", when=is_(2))]},
    }),
    Assertion(396, "the event's name is what transitions are matched with", {
        "a": {"entry": raising("foo"), "transitions": [transition("bar", "fail"), transition("foo", "pass")]},
    }),
    Assertion(403, "an inner transition goes before an outer one; an inner one that is not enabled leaves it to the outer", {
        "s0": compound("s01", {
            "s01": {"entry": raising("event1"), "transitions": [transition("event1", "s02"), FAIL]},
            "s02": {"entry": raising("event2"), "transitions": [transition("event1", "fail"), transition("event2", "fail", when=is_(9))]},
        }, transitions=[transition("event1", "fail"), transition("event2", "pass")]),
    }),
    Assertion(404, "exit is innermost first and last region first, then the transitions' content", {
        "s01p": {**regions(s01p1={"exit": raising("event2")}, s01p2={"exit": raising("event1")}), "exit": raising("event3"),
                 "transitions": [transition(to="s02", when=is_(0), do=raising("event4"))]},
        "s02": {"transitions": [transition("event1", "s03"), FAIL]}, "s03": {"transitions": [transition("event2", "s04"), FAIL]},
        "s04": {"transitions": [transition("event3", "s05"), FAIL]}, "s05": {"transitions": [transition("event4", "pass"), FAIL]},
    }),
    Assertion(405, "the content of transitions is executed after the exits, in document order of the regions", {
        "p": {**regions(
            r=compound("r1", {"r1": {"exit": raising("event2"), "transitions": [transition(to="r2", when=is_(0), do=raising("event3"))]}, "r2": {}}),
            s=compound("t1", {"t1": {"exit": raising("event1"), "transitions": [transition(to="t2", when=is_(0), do=raising("event4"))]}, "t2": {}}),
        ), "transitions": [transition("event1", "b")]},
        "b": {"transitions": [transition("event2", "c"), FAIL]}, "c": {"transitions": [transition("event3", "d"), FAIL]},
        "d": {"transitions": [transition("event4", "pass"), FAIL]},
    }),
    Assertion(406, "entry is outermost first, in document order, after the transitions' content", {
        "a": {"transitions": [transition(to="p", when=is_(0), do=raising("event1"))]},
        "p": {**regions(r={"entry": raising("event3")}, s={"entry": raising("event4")}), "entry": raising("event2"),
              "transitions": [transition("event1", "b"), FAIL]},
        "b": {"transitions": [transition("event2", "c"), FAIL]}, "c": {"transitions": [transition("event3", "d"), FAIL]},
        "d": {"transitions": [transition("event4", "pass"), FAIL]},
    }),
    Assertion(409, "while exits are executed, what was exited before is active no more", {
        "a": compound("b", {"b": compound("c", {"c": {"transitions": [transition(to="e", when=is_(0))]}}, exit=[put(5)])}),
        "e": {"transitions": verdict(5)},
    }),
    Assertion(411, "a state is active only once it is entered: what its parent's entry raises meets it active", {
        "s0": compound("s01", {"s01": {"transitions": [transition("event1", "pass")]}}, entry=raising("event1"), transitions=[FAIL]),
    }),
    Assertion(416, "a final child ends its compound state", {
        "s1": compound("s11", {"s11": compound("end", {"end": {"final": "succeeded"}}, transitions=[transition("succeeded", "pass")])}),
    }),
    Assertion(417, "a parallel state ends when all regions have", {
        "s1": {**regions(r=compound("re", {"re": {"final": "succeeded"}}), s=compound("se", {"se": {"final": "succeeded"}})),
               "transitions": [transition("succeeded", "pass")]},
    }),
    Assertion(419, "transitions without an event go before those with one", {
        "a": {"entry": raising("internal"), "transitions": [transition("internal", "fail"), transition(to="pass", when=is_(0))]},
    }),
    Assertion(421, "internal events are taken until one fires something, before any external one", {
        "a": compound("a1", {
            "a1": {"entry": [{"raise": "external", "after_s": 0.0}, *raising("internal1", "internal2", "internal3")],
                   "transitions": [transition("internal3", "a2")]},
            "a2": {"transitions": [transition("internal4", "pass")]},
        }, transitions=[transition("external", "fail"), transition("internal2", do=raising("internal4"))]),
    }),
    Assertion(423, "external events are taken until one fires something", {
        "a": {"entry": [{"raise": "external1", "after_s": 0.0}, {"raise": "external2", "after_s": 1.0}],
              "transitions": [transition("external2", "pass")]},
    }, until_s=2.0),
    Assertion(503, "a transition without a target leaves and enters nothing", {
        "s2": {"entry": raising("foo", "bar"), "exit": [up()], "transitions": [transition("foo", do=[]), transition("bar", "s3", when=is_(0)), FAIL]},
        "s3": {"transitions": verdict(1)},
    }),
    Assertion(504, "an external transition leaves all that is inside the nearest compound state above both ends", {
        "outer": compound("p", {
            "p": {**regions(ps1={"exit": [up()]}, ps2={"exit": [up()]}), "entry": raising("foo", "bar"), "exit": [up()],
                  "transitions": [transition("foo", "ps1", when=is_(0)), transition("bar", "s4", when=is_(3))]},
            "s4": {"transitions": verdict(6)},
        }),
    }),
    Assertion(505, "an internal transition from a compound state to a state inside it does not leave it", {
        "s1": compound("s11", {"s11": {"exit": [up()]}}, exit=[{"set": "n", "add": 10}], entry=raising("foo", "bar"),
                       transitions=[transition("foo", "s11", internal=True), transition("bar", "s2")]),
        "s2": {"transitions": verdict(12)},
    }),
    Assertion(533, "an internal transition whose source is no compound state is an external one", {
        "p": {**regions(ps1={"exit": [up()]}, ps2={"exit": [up()]}), "entry": raising("foo", "bar"), "exit": [up()],
              "transitions": [transition("foo", "ps1", when=is_(0), internal=True), transition("bar", "s4", when=is_(3))]},
        "s4": {"transitions": verdict(6)},
    }),
    Assertion(570, "the end of a parallel state is reported once all its regions have ended", {
        "p": {**regions(
            a=compound("a1", {"a1": {"transitions": [transition("e1", "af")]}, "af": {"final": "succeeded"}}),
            b=compound("b1", {"b1": {"transitions": [transition("e2", "bf")]}, "bf": {"final": "succeeded"}}),
        ), "entry": raising("e1", "e2"), "transitions": [transition("succeeded", "pass")]},
    }),
    Assertion(576, "the mission's initial may name a state in each region", {
        "s0": {"transitions": [transition(to="fail", when=is_(0))]},
        "s1": compound("s11", {
            "s11": {"transitions": [transition(to="fail", when=is_(0))]},
            "p": regions(
                q=compound("q1", {"q1": {}, "q2": {"entry": raising("in_q2")}}),
                r=compound("r1", {"r1": {}, "r2": {"transitions": [transition("in_q2", "pass")]}}),
            ),
        }),
    }, initial=["q2", "r2"]),
]  # fmt: skip


@pytest.mark.parametrize("plan", PLAN, ids=lambda plan: f"{plan.number}: {plan.sentence}")
def test_an_interpreter_keeps_the_assertion(plan: Assertion) -> None:
    made = chart({**plan.states, **ENDS}, plan.initial, blackboard=COUNT)
    for name in plan.send:
        made.send(Tick(0.0) if name == "tick" else Event(name, 0.0))
    made.send(Tick(plan.until_s))
    assert (made.outcome, set(made.active)) == ("succeeded", {"pass"}), made.why


def test_580_a_history_is_never_active_itself() -> None:
    states = {
        "p": compound("s1", {"s1": {}, "h": {"history": "shallow"}}),
        "start": {"transitions": [transition("go", "h")]},
    }
    made = chart(states, "start")
    step = made.send(Event("go", 0.0))
    assert (made.active, step.entered) == ({"p", "s1"}, ("p", "s1"))


def test_579_a_history_that_remembers_does_not_lead_to_its_default() -> None:
    inside = {
        "back": {"history": "shallow"},
        "default": {"entry": raising("event1"), "transitions": [transition("event1", "other")]},
        "other": {"transitions": [transition(to="away", when=is_(0))]},
    }
    away = {"entry": [up()], "transitions": [transition(to="back", when=is_(1))]}
    made = chart({"s": compound("default", inside), "away": away}, blackboard=COUNT)
    assert made.active == {"s", "other"}


def test_412_the_entry_of_a_state_is_executed_before_that_of_its_initial() -> None:
    states = {"a": compound("b", {"b": {"entry": [{"log": "b"}]}}, entry=[{"log": "a"}])}
    made = chart(states, started=False)
    assert logged(made.start(0.0)) == ("a", "b")
