# SPDX-License-Identifier: Apache-2.0
"""Small missions with the verdict of every claim, each found by hand from what the semantics state.

Rule: claims that a row does not name are proved. A verdict is changed only with the reason next to it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

__all__ = ("TABLE", "Row")

Json = dict[str, Any]

KEYS: Json = {
    "battery": {"type": "number", "source": "robot", "max_age_s": 5},
    "clear": {"type": "boolean", "source": "robot", "max_age_s": 5},
    "at_home": {"type": "boolean", "source": "robot", "max_age_s": 5},
    "n": {"type": "integer", "initial": 0},
    "flag": {"type": "boolean", "initial": False},
    "order": {"type": "string", "source": "answer"},
    "jobs": {"type": "list", "source": "argument", "initial": ["a"]},
    "job": {"type": "string", "initial": ""},
}
EVENTS = ("go", "back", "stop", "ping")
BAD = ["failed", "timed_out", "rejected", "unverified"]
OVER: Json = {"final": "aborted"}
DONE: Json = {"final": "succeeded", "requires": {"key": "at_home", "==": True}}
CLEAR: Json = {"key": "clear", "==": True}
CALL: Json = {"call": "horn", "timeout_s": 3}
BEEP: Json = {"publish": "beep", "message": {}}
STOP: Json = {"on": "stop", "to": "over"}
LOST: Json = {"transitions": [{"when": {"key": "n", "<": 0}, "to": "over"}]}
"""A trap that `check` does not see: n is never below 0."""
ADD: Json = {"set": "n", "add": 1}


class Row(NamedTuple):
    """A mission, and what is to be reported about it."""

    name: str
    why: str
    """The reason for the verdicts, from the semantics."""
    mission: Json
    refuted: frozenset[str]
    """The claims that are refuted."""


TABLE: list[Row] = []


def row(name: str, refuted: str, why: str, states: Json, **words: Any) -> None:
    """Note a mission; finals `over` and `done`, keys and events come along where they are named."""
    finals = {each: state for each, state in (("over", OVER), ("done", DONE)) if f"'{each}'" in repr([states, words])}
    text = repr([states, words, finals])
    keys = {key: value for key, value in KEYS.items() if f"'{key}'" in text or f"'{key}." in text}
    events = {event: {} for event in EVENTS if f"'{event}'" in text}
    mission = {"format": 1, "name": "small", "initial": next(iter(states)), "blackboard": keys, "events": events,
               "states": {**finals, **states}, **words}  # fmt: skip
    TABLE.append(Row(name, why, mission, frozenset(filter(None, refuted.split(", ")))))


def waits(*rows: Json, **words: Any) -> Json:
    return {"transitions": list(rows), **words}


def tree(node: Json, *rows: Json, **words: Any) -> Json:
    return {"tree": node, "transitions": list(rows), **words}


def ended(*ends: str, to: str = "over") -> Json:
    return {"on": list(ends or ("succeeded", "failed")), "to": to}


def asks(options: Json, *rows: Json, **words: Any) -> Json:
    asked = {"question": "What now?", "options": options, "ask": ["agent"], "deadline_s": 10,
             "fallback": next(reversed(options)), **words}  # fmt: skip
    return {"decision": asked, "transitions": list(rows)}


DRIVE: Json = {"action": "drive", "timeout_s": 60, "achieved": {"key": "at_home", "==": True},
               "transitions": [{"on": "succeeded", "to": "done"}, {"on": BAD, "to": "over"}]}  # fmt: skip

# -- ends ------------------------------------------------------------------------------------------------------------

row("an event ends it", "", "the event can come at any time", {"here": waits(STOP)})
row("nothing ends it", "ends", "the event is of no transition that ends it",
    {"here": waits({"on": "go", "do": [{"log": "noted"}]}, *LOST["transitions"])})  # fmt: skip
row("a trap behind an event", "ends", "from `lost` nothing leads on", {"here": waits(STOP, {"on": "go", "to": "lost"}),
                                                                      "lost": LOST})  # fmt: skip
row("two states without a way out", "ends", "go and back lead to each other alone; events do not come by themselves",
    {"here": waits({"on": "go", "to": "there"}), "there": waits({"on": "back", "to": "here"})})  # fmt: skip
row("a way out of one of two", "", "from each the event of the other leads to it",
    {"here": waits({"on": "go", "to": "there"}), "there": waits({"on": "back", "to": "here"}, STOP)})  # fmt: skip
row("a timer ends it", "", "the timer runs out", {"here": waits({"after_s": 5, "to": "over"})})
row("a timer whose guard is false is lost", "ends", "were it not clear at its instant, nothing ends it",
    {"here": waits({"after_s": 5, "when": CLEAR, "to": "over"})})  # fmt: skip
row("a timer that is lost, and another", "", "the second has no guard",
    {"here": waits({"after_s": 5, "when": CLEAR, "to": "over"}, {"after_s": 9, "to": "over"})})  # fmt: skip
row("a fact ends it", "", "the robot can report that it is clear", {"here": waits({"when": CLEAR, "to": "over"})})
row("a count that never comes", "ends", "nothing counts n up to 3",
    {"here": waits({"on": "go", "when": {"key": "n", "<": 2}, "do": [ADD]},
                   {"when": {"key": "n", ">=": 3}, "to": "over"})})  # fmt: skip
row("a count that comes", "", "three events count n up to 3",
    {"here": waits({"on": "go", "when": {"key": "n", "<": 3}, "do": [ADD]},
                   {"when": {"key": "n", ">=": 3}, "to": "over"})})  # fmt: skip
row("a count of a thousand", "", "each event counts; no round is left out",
    {"here": waits({"on": "go", "when": {"key": "n", "<": 300}, "do": [ADD]},
                   {"when": {"key": "n", ">=": 300}, "to": "over"})})  # fmt: skip
row("an action that ends in each way", "", "every outcome has a transition", {"driving": DRIVE})
row("an outcome without a transition", "", "an outcome that is unhandled at the top ends the mission failed",
    {"driving": {**DRIVE, "transitions": [{"on": "succeeded", "to": "done"}]}})  # fmt: skip
row("an action whose failure leads into a trap", "ends", "the server can fail",
    {"driving": {**DRIVE, "transitions": [{"on": "succeeded", "to": "done"}, {"on": BAD, "to": "lost"}]},
     "lost": LOST})  # fmt: skip
row("a call that succeeds and is not waited for", "ends", "'succeeded' without a transition ends nothing",
    {"calling": {"call": "horn", "timeout_s": 3, "transitions": [
        {"on": BAD[:3], "to": "over"}, {"on": "succeeded", "do": [{"log": "noted"}]}]}})  # fmt: skip
row("a region that ends late", "", "both regions reach their finals by events; then the state has succeeded",
    {"both": {"parallel": {
        "one": {"initial": "a", "states": {"a": waits({"on": "go", "to": "fa"}), "fa": {"final": "succeeded"}}},
        "two": {"initial": "b", "states": {"b": waits({"on": "back", "to": "fb"}), "fb": {"final": "succeeded"}}},
    }, "transitions": [ended("succeeded")]}})  # fmt: skip
row("a region that never ends", "ends", "the second region has no final, so the state never succeeds",
    {"both": {"parallel": {
        "one": {"initial": "a", "states": {"a": waits({"on": "go", "to": "fa"}), "fa": {"final": "succeeded"}}},
        "two": {"initial": "b", "states": {"b": LOST}},
    }, "transitions": [ended("succeeded")]}})  # fmt: skip
row("a list that is gone over", "", "each item ends by an event, and the list has an end",
    {"all": {"each": "jobs", "as": "job", "initial": "one", "states": {
        "one": waits({"on": "go", "to": "ok"}), "ok": {"final": "succeeded"}},
        "transitions": [ended("succeeded")]}})  # fmt: skip
row("a history that leads back", "", "the way out is open wherever the history leads",
    {"work": {"initial": "a", "states": {"a": waits({"on": "go", "to": "b"}), "b": {}, "h": {"history": "deep"}},
              "transitions": [{"on": "stop", "to": "paused"}]},
     "paused": waits({"on": "back", "to": "h"}, STOP)})  # fmt: skip
row("control that never comes", "", "without the handover the start is rejected after handover_s",
    {"driving": {**DRIVE, "control": "agent"}})  # fmt: skip

# -- comes to rest ---------------------------------------------------------------------------------------------------

row("two timers that lead to each other", "comes to rest", "time alone goes round for ever",
    {"here": waits({"after_s": 5, "to": "there"}, STOP), "there": waits({"after_s": 5, "to": "here"})})  # fmt: skip
row("a timer that leads to its own state", "comes to rest", "it is entered again, and its timer begins again",
    {"here": waits({"after_s": 5, "to": "here"}, STOP)})  # fmt: skip
row("a timer without a target", "", "after_s fires once an entry, and the state is not left",
    {"here": waits({"after_s": 5, "do": [{"log": "late"}]}, STOP)})  # fmt: skip
row("a round with a way out by time", "", "of the two timers of `there` the one that leads out runs out first",
    {"here": waits({"after_s": 5, "to": "there"}),
     "there": waits({"after_s": 5, "to": "here"}, {"after_s": 3, "to": "over"})})  # fmt: skip
row("a timer that begins again with its state", "comes to rest", "each time the longer one begins again, too",
    {"around": {"initial": "a", "states": {"a": waits({"after_s": 5, "to": "around"})},
                "transitions": [{"after_s": 9, "to": "over"}, STOP]}})  # fmt: skip
row("a round that only a fact ends", "comes to rest", "while it is not clear, time leads round",
    {"here": waits({"after_s": 5, "to": "there"}),
     "there": waits({"when": CLEAR, "to": "over"}, {"after_s": 5, "to": "here"})})  # fmt: skip
row("a round that continues while a fact is fresh", "", "a silent robot's word grows stale, and then the timer is lost",
    {"here": waits({"after_s": 5, "to": "there"}),
     "there": waits({"after_s": 5, "when": {"fresh": "clear"}, "to": "here"}, STOP)})  # fmt: skip
row("a round that an event closes", "", "without the event it waits",
    {"here": waits({"after_s": 5, "to": "there"}, STOP), "there": waits({"on": "go", "to": "here"})})  # fmt: skip
row("a delayed event that raises itself", "comes to rest", "each raise brings the next one by time alone",
    {"here": {**waits({"on": "ping", "do": [{"raise": "ping", "after_s": 5}]}, STOP),
              "entry": [{"raise": "ping", "after_s": 5}]}})  # fmt: skip
row("a delayed event", "", "it comes once", {"here": {**waits({"on": "ping", "to": "over"}),
                                                      "entry": [{"raise": "ping", "after_s": 5}]}})  # fmt: skip
row("a fallback that asks again", "comes to rest", "the deadline passes, the fallback asks again, for ever",
    {"asking": asks({"stop_here": {}, "again": {}}, {"on": "stop_here", "to": "over"},
                    {"on": "again", "to": "asking"})})  # fmt: skip
row("a fallback that ends", "", "the deadline passes, the fallback ends it",
    {"asking": asks({"again": {}, "stop_here": {}}, {"on": "stop_here", "to": "over"},
                    {"on": "again", "to": "asking"})})  # fmt: skip
row(
    "an action that is tried again by its timeout",
    "comes to rest",
    "a silent server: it starts for ever",
    {"driving": {**DRIVE, "transitions": [{"on": "succeeded", "to": "done"}, {"on": BAD, "to": "driving"}]}},
)
row("an action that is tried three times", "", "the count ends the round",
    {"driving": {**DRIVE, "entry": [ADD], "transitions": [
        {"on": "succeeded", "to": "done"}, {"on": BAD, "when": {"key": "n", "<": 3}, "to": "driving"},
        {"on": BAD, "to": "over"}]}})  # fmt: skip
row("a tree that publishes every two seconds", "comes to rest", "each wait is followed by the next, for ever",
    {"beeping": tree({"repeat": -1, "child": {"sequence": [{"wait_s": 2}, BEEP]}}, STOP, ended())})  # fmt: skip
row("a tree that publishes and never ends", "ends, comes to rest", "and nothing leads out of it",
    {"beeping": tree({"repeat": -1, "child": {"sequence": [{"wait_s": 2}, BEEP]}}, ended())})  # fmt: skip
row("a tree that waits round after round", "comes to rest", "a round by time is a round, whether it does anything",
    {"waiting": tree({"repeat": -1, "child": {"wait_s": 2}}, STOP, ended())})  # fmt: skip
row("a tree that publishes until its time is over", "", "the state's own timeout ends it",
    {"beeping": tree({"repeat": -1, "child": {"sequence": [{"wait_s": 2}, BEEP]}}, ended("timed_out"), ended(),
                     timeout_s=60)})  # fmt: skip
row("a tree that publishes within a timeout", "", "the tree's timeout makes it fail",
    {"beeping": tree({"timeout": 9, "child": {"repeat": -1, "child": {"sequence": [{"wait_s": 2}, BEEP]}}},
                     ended())})  # fmt: skip
row("a call that is made again and again", "comes to rest", "a silent service: timeout, call, timeout, …",
    {"calling": tree({"repeat": -1, "child": {"failure_is_success": CALL}}, STOP, ended())})  # fmt: skip
row("a call with a fallback whose goal is refused", "comes to rest",
    "an orphan refuses the goal, and the memoryless selector calls again, in the state that it was in",
    {"calling": tree({"selector": [CALL, {"action": "lift", "timeout_s": 3}]}, STOP, ended())})  # fmt: skip
row("an action that is started again and again", "", "a silent server: its orphan refuses each start",
    {"going": tree({"repeat": -1, "child": {"failure_is_success": {"action": "lift", "timeout_s": 3}}},
                   STOP, ended())})  # fmt: skip
row("a poll", "comes to rest", "as long as it is not clear, it looks every second, by time alone",
    {"looking": tree({"repeat": -1, "child": {"sequence": [
        {"wait_s": 1}, {"inverter": {"check": CLEAR}}]}}, ended())})  # fmt: skip
row("a check that is waited for", "", "the tree is ticked when the fact changes, not by time",
    {"looking": tree({"failure_is_running": {"check": CLEAR}}, ended("succeeded"))})  # fmt: skip
row("a loop that rests between facts", "", "a round that ends at once lets the tree rest until a fact changes",
    {"looking": tree({"repeat": -1, "child": {"sequence": [BEEP, {"failure_is_success": {"check": CLEAR}}]}},
                     STOP, ended())})  # fmt: skip
row("a tree that writes what it reads, without end", "comes to rest", "its own write ticks it until the step's limit",
    {"counting": tree({"failure_is_running": {"sequence": [ADD, {"check": {"key": "n", "<": 0}}]}},
                      STOP, ended())})  # fmt: skip
row("a tree that writes what it reads, to an end", "", "after three writes the check holds",
    {"counting": tree({"failure_is_running": {"sequence": [ADD, {"check": {"key": "n", ">": 2}}]}},
                      ended("succeeded"))})  # fmt: skip
row("two checks that turn a flag", "comes to rest", "each turns what the other has set, until the step's limit",
    {"turning": tree({"failure_is_running": {"selector": [
        {"sequence": [{"check": {"key": "flag", "==": True}}, {"set": "flag", "value": False},
                      {"check": {"key": "flag", "==": True}}]},
        {"sequence": [{"set": "flag", "value": True}, {"check": {"key": "flag", "==": False}}]},
    ], "memory": False}}, STOP, ended())})  # fmt: skip
row("a loop with a number", "", "three rounds, then it has succeeded",
    {"beeping": tree({"repeat": 3, "child": {"sequence": [{"wait_s": 2}, BEEP]}}, ended("succeeded"))})  # fmt: skip
row("a loop of ten thousand", "", "ten thousand rounds are rounds with an end",
    {"beeping": tree({"repeat": 10000, "child": {"sequence": [{"wait_s": 2}, BEEP]}}, ended("succeeded"))})  # fmt: skip
row("a round of one region, an end of another", "", "the other region's timer leads out of both",
    {"both": {"parallel": {
        "one": {"initial": "a", "states": {"a": waits({"after_s": 1, "to": "a2"}),
                                                  "a2": waits({"after_s": 1, "to": "a"})}},
        "two": {"initial": "b", "states": {"b": waits({"after_s": 9, "to": "over"})}},
    }}})  # fmt: skip
row("a round of one region, rest in another", "comes to rest", "the first region never rests",
    {"both": {"parallel": {
        "one": {"initial": "a", "states": {"a": waits({"after_s": 1, "to": "a2"}),
                                                  "a2": waits({"after_s": 1, "to": "a"})}},
        "two": {"initial": "b", "states": {"b": waits(STOP)}},
    }}})  # fmt: skip

NEVER: Json = {"check": {"key": "n", "<": 0}}
row("an instant circle through a tree's loop", "ends, comes to rest",
    "at the limit of a step the tree rests and continues in the next: an event can come between",
    {"looking": tree({"retry": 20, "child": NEVER}, ended("succeeded"), ended("failed", to="looking"), STOP,
                     {"on": "go", "to": "lost"}), "lost": LOST})  # fmt: skip
row("an instant circle through a loop of few rounds", "comes to rest",
    "the limit of microsteps comes before that of rounds: the mission fails before anything can be reported",
    {"looking": tree({"retry": 3, "child": NEVER}, ended("succeeded"), ended("failed", to="looking"), STOP,
                     {"on": "go", "to": "lost"}), "lost": LOST})  # fmt: skip

# -- waits of one tree -----------------------------------------------------------------------------------------------


def branches(first: float, second: float, *before: Json) -> Json:
    """Two waits in parallel; the tree succeeds if the first is over before the second, and fails if not."""
    return {"parallel": [{"sequence": [{"wait_s": first}, {"set": "n", "value": 1}]},
                         {"sequence": [*before, {"wait_s": second}, {"check": {"key": "n", "==": 1}}]}]}  # fmt: skip


LATER: Json = {"sequence": [{"failure_is_running": {"check": CLEAR}}, {"check": {"key": "n", "==": 0}}]}
row("a shorter wait that begins with a longer one", "", "the shorter is always over first",
    {"both": tree(branches(5, 3), ended("failed"), ended("succeeded", to="lost")), "lost": LOST})  # fmt: skip
row("a shorter wait that begins after a longer one", "ends", "if it is clear after 4 s, the longer is over first",
    {"both": tree(branches(5, 3, LATER), ended("failed"), ended("succeeded", to="lost")), "lost": LOST})  # fmt: skip
row("a longer wait that begins after a shorter one", "", "it is always over last: what it then checks is true",
    {"both": tree(branches(3, 5, {"failure_is_running": {"check": CLEAR}}),
                  ended("succeeded"), ended("failed", to="lost")), "lost": LOST})  # fmt: skip

# -- loops with numbers ----------------------------------------------------------------------------------------------

WAIT_CLEAR: Json = {"sequence": [{"wait_s": 1}, {"check": CLEAR}]}
row("a retry of three", "", "at the third failure it fails, which ends it",
    {"calling": tree({"retry": 3, "child": CALL}, ended())})  # fmt: skip
row("a retry of ten thousand", "", "a service that fails so often makes it fail; both ends end it",
    {"calling": tree({"retry": 10000, "child": CALL}, ended())})  # fmt: skip
row("a retry of three into a trap", "ends", "three failures lead into it",
    {"looking": tree({"retry": 3, "child": WAIT_CLEAR}, ended("succeeded"), ended("failed", to="lost")),
     "lost": LOST})  # fmt: skip
row("a retry of two hundred into a trap", "ends", "two hundred failures lead into it",
    {"looking": tree({"retry": 200, "child": WAIT_CLEAR}, ended("succeeded"), ended("failed", to="lost")),
     "lost": LOST})  # fmt: skip
row("a retry that cannot fail", "", "the child never fails, so the trap is never reached",
    {"looking": tree({"retry": 200, "child": {"failure_is_success": CALL}}, ended("succeeded"),
                     ended("failed", to="lost")), "lost": LOST})  # fmt: skip
row("a repeat that is broken off", "", "one failure ends it, and so does the last round",
    {"calling": tree({"repeat": 200, "child": CALL}, ended())})  # fmt: skip
row("a loop within a loop", "", "both have numbers",
    {"calling": tree({"retry": 50, "child": {"repeat": 50, "child": CALL}}, ended())})  # fmt: skip

# -- invariants ------------------------------------------------------------------------------------------------------

NEVER_THERE: Json = {"never": {"not": {"in": "there"}}}
row("a state that must not be", "invariants", "the event leads there",
    {"here": waits({"on": "go", "to": "there"}, STOP), "there": waits(STOP)}, invariants=NEVER_THERE)  # fmt: skip
row("a state that cannot be", "", "the count that leads there never comes",
    {"here": waits({"on": "go", "when": {"key": "n", "<": 2}, "do": [ADD]},
                   {"when": {"key": "n", ">": 2}, "to": "there"}, STOP), "there": waits(STOP)},
    invariants=NEVER_THERE)  # fmt: skip
row("a count that is bounded", "", "the guard keeps n at 3",
    {"here": waits({"on": "go", "when": {"key": "n", "<": 3}, "do": [ADD]}, STOP)},
    invariants={"few": {"key": "n", "<=": 3}})  # fmt: skip
row("a count that is bounded too late", "invariants", "the guard lets n become 4",
    {"here": waits({"on": "go", "when": {"key": "n", "<=": 3}, "do": [ADD]}, STOP)},
    invariants={"few": {"key": "n", "<=": 3}})  # fmt: skip
row("a count up and down within bounds", "", "both guards hold it between 0 and 3",
    {"here": waits({"on": "go", "when": {"key": "n", "<": 3}, "do": [ADD]},
                   {"on": "back", "when": {"key": "n", ">": 0}, "do": [{"set": "n", "add": -1}]}, STOP)},
    invariants={"within": {"all": [{"key": "n", ">=": 0}, {"key": "n", "<=": 3}]}})  # fmt: skip
row("a fact that a transition answers at once", "", "the mission leaves before the invariant is looked at",
    {"driving": {**DRIVE, "transitions": [{"when": {"key": "battery", "<": 0.1}, "to": "over"},
                                          *DRIVE["transitions"]]}},
    invariants={"charged": {"not": {"all": [{"in": "driving"}, {"key": "battery", "<": 0.1}]}}})  # fmt: skip
row("a fact that no transition answers", "invariants", "the battery can be low while it drives",
    {"driving": DRIVE},
    invariants={"charged": {"not": {"all": [{"in": "driving"}, {"key": "battery", "<": 0.1}]}}})  # fmt: skip
row("a fact of the robot alone", "", "no transition can keep it: it is assumed",
    {"driving": DRIVE}, invariants={"charged": {"key": "battery", ">": 0.05}})  # fmt: skip
row("an invariant over the age of the mission", "invariants", "time passes while it waits",
    {"here": waits(STOP)}, invariants={"soon": {"not": {"elapsed_s": 30}}})  # fmt: skip
row("a tree's count", "", "two rounds count from 0 to 2, also where a pause has the tree begin again",
    {"counting": tree({"sequence": [{"set": "n", "value": 0}, {"repeat": 2, "child": {"sequence": [ADD, CALL]}}]},
                      ended())},
    invariants={"few": {"key": "n", "<=": 2}})  # fmt: skip
row("a tree's count that a pause lets grow", "invariants", "resumed, the tree begins again, and n is not set to 0",
    {"counting": tree({"repeat": 2, "child": {"sequence": [ADD, CALL]}}, ended())},
    invariants={"few": {"key": "n", "<=": 2}})  # fmt: skip
row("a tree's count beyond", "invariants", "three rounds count to 3",
    {"counting": tree({"repeat": 3, "child": {"sequence": [ADD, CALL]}}, ended())},
    invariants={"few": {"key": "n", "<=": 2}})  # fmt: skip
row("a tree's count, late", "invariants", "the thirtieth round counts to 30",
    {"counting": tree({"repeat": 100, "child": {"sequence": [ADD, CALL]}}, ended())},
    invariants={"few": {"key": "n", "<": 30}})  # fmt: skip
row("a result", "invariants", "the service may answer any number",
    {"calling": {"call": "count", "timeout_s": 3, "result": {"n": "many"},
                 "transitions": [ended("succeeded", to="here"), ended(*BAD[:3])]}, "here": waits(STOP)},
    invariants={"few": {"key": "n", "<": 5}})  # fmt: skip

# -- answers, options, rules -----------------------------------------------------------------------------------------

row("an option that drives", "", "the success rests on the robot's word",
    {"asking": asks({"drive": {}, "stop_here": {}},
                    {"on": "drive", "to": "driving"}, {"on": "stop_here", "to": "over"}),
     "driving": DRIVE})  # fmt: skip
row("an option into a trap", "ends", "the model may choose it",
    {"asking": asks({"wait": {}, "stop_here": {}}, {"on": "wait", "to": "lost"}, {"on": "stop_here", "to": "over"}),
     "lost": LOST})  # fmt: skip
row("an option that asks for a count", "options, rules", "n is 0 wherever it is asked, so it is never offered",
    {"asking": asks({"wait": {"when": {"key": "n", ">": 3}}, "stop_here": {}}, {"on": "wait", "to": "over"},
                    {"on": "stop_here", "to": "over"})})  # fmt: skip
row("an option that asks for a fact", "", "it is clear or not",
    {"asking": asks({"wait": {"when": CLEAR}, "stop_here": {}}, {"on": "wait", "to": "over"},
                    {"on": "stop_here", "to": "over"})})  # fmt: skip
row("an option's guard that is always true", "rules", "the question is asked in its own state alone",
    {"asking": asks({"wait": {"when": {"in": "asking"}}, "stop_here": {}}, {"on": "wait", "to": "over"},
                    {"on": "stop_here", "to": "over"})})  # fmt: skip
row("an option after three signals", "", "the option is offered while n is less than 3",
    {"asking": asks({"signal": {"when": {"key": "n", "<": 3}}, "stop_here": {}},
                    {"on": "signal", "do": [ADD], "to": "asking"}, {"on": "stop_here", "to": "over"})})  # fmt: skip
row("a question in a tree", "", "its two options end the tree",
    {"asking": tree({"decision": {"question": "What now?", "options": {"beep": {}, "stop_here": {}}, "ask": ["agent"],
                                  "deadline_s": 10, "fallback": "stop_here"}, "then": {"beep": BEEP}},
                    ended())})  # fmt: skip
row("a check behind a set", "ends", "what the tree has written leaves the other facts as open as they were",
    {"looking": tree({"sequence": [ADD, {"check": CLEAR}]}, {"on": "succeeded", "to": "lost"},
                     {"on": ["failed"], "to": "over"}), "lost": LOST})  # fmt: skip
row("a wait behind a goal that is never confirmed", "comes to rest",
    "the lost goal keeps the next one from starting, and the memoryless sequence waits again and again",
    {"lifting": tree({"sequence": [{"inverter": {"action": "lift", "timeout_s": 3}}, {"wait_s": 1}, {"wait_s": 5}],
                      "memory": False}, STOP, ended())})  # fmt: skip
row("a question in a loop", "comes to rest", "the deadline, the fallback, and the question again, for ever",
    {"asking": tree({"repeat": -1, "child": {"decision": {
        "question": "What now?", "options": {"beep": {}, "stop_here": {}}, "ask": ["agent"], "deadline_s": 10,
        "fallback": "stop_here"}, "then": {"beep": BEEP}}}, STOP, ended())})  # fmt: skip
row("a requires that never holds", "rules", "n is never above 3",
    {"driving": DRIVE, "done": {"final": "succeeded", "requires": {
        "all": [{"key": "at_home", "==": True}, {"key": "n", ">": 3}]}}})  # fmt: skip

# -- stop, cancel, stopped -------------------------------------------------------------------------------------------

row("a cancel that drives home", "", "the goal's end, or cancel_s, ends the cancel",
    {"here": waits(STOP), "driving": DRIVE}, on_cancel="driving")  # fmt: skip
row("a cancel that goes round", "", "cancel_s ends it; by then time has not gone round for ever",
    {"here": waits(STOP), "tidying": waits({"after_s": 5, "to": "again"}),
     "again": waits({"after_s": 5, "to": "tidying"})}, on_cancel="tidying")  # fmt: skip
row("two goals side by side", "", "both are ended with the mission",
    {"both": {"parallel": {
        "one": {"initial": "a", "states": {"a": {"action": "lift", "timeout_s": 9, "transitions": [
            {"on": ["succeeded", *BAD[:3]], "to": "over"}]}}},
        "two": {"initial": "b", "states": {"b": waits(STOP)}},
    }}})  # fmt: skip
