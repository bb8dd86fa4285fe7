# SPDX-License-Identifier: Apache-2.0
"""Every kind of thing that a run can be about when it is killed: it ends as if it had not been."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import py_trees
import pytest
from py_trees.common import Status

from rai_missions import Mission, On
from rai_missions.event import Event
from rai_missions.states.final import Final
from rai_missions.states.tree import Behaviour, Sequence, Tree, Wait
from tests.replay.farm import FARMER, Farm
from tests.replay.mortal import Fate, Wish, live
from tests.replay.test_kills import entered, holds, lived
from tests.rigs.runs import ReplyingAnswerer

KEYS = {
    "hauls": {"type": "integer", "source": "robot", "max_age_s": 5, "optional": True},
    "tows": {"type": "integer", "source": "robot", "max_age_s": 5, "optional": True},
    "battery": {"type": "number", "source": "robot", "max_age_s": 2},
    "stops": {"type": "list", "source": "argument", "initial": ["a", "b", "c"]},
    "stop": {"type": "string", "source": "mission", "initial": ""},
    "count": {"type": "integer", "source": "mission", "initial": 0},
}
ALWAYS = [{"when": {"not": {"fresh": "battery"}}, "to": "lost"}]
"""A protective row, as missions have them: a battery that no one is notified of ends the run."""


def made(states: dict[str, Any], **words: Any) -> Mission:
    states = {**states, "lost": {"final": "aborted"}}
    words = {"initial": next(iter(states)), "events": {"go": {}, "poke": {}}, **words}
    return Mission.model_validate(
        {"name": "kind", "blackboard": KEYS, "transitions": ALWAYS, "states": states, **words}
    )


def do(name: str, **words: Any) -> dict[str, Any]:
    """A state that does something and continues to `then`."""
    then = words.pop("then", "done")
    return {**words, "timeout_s": 60, "transitions": [{"on": "succeeded", "to": then}], "action": name}


DONE = {"done": {"final": "canceled"}}


class Kind(NamedTuple):
    """A mission, and what happens around it."""

    mission: Mission
    wishes: tuple[Wish, ...] = ()
    lasts_s: Mapping[str, float] = {}
    ends: Mapping[str, str] = {}
    named: Mapping[str, Callable[..., bool]] = {}


def is_mode(mode: str) -> Callable[[Any], bool]:
    return lambda runner: runner.view.mode == mode or runner.view.outcome is not None


def is_in(state: str) -> Callable[[Any], bool]:
    return lambda runner: state in runner.view.active or runner.view.outcome is not None


def post(name: str) -> Callable[[Any], None]:
    return lambda runner: runner.post(Event(name, runner.view.now()))


PAUSED = (
    Wish(2.0, lambda runner: runner.pause(), is_mode("paused")),
    Wish(6.0, lambda runner: runner.resume(), is_mode("running")),
)


class Work(py_trees.behaviour.Behaviour):
    """Runs for four ticks."""

    ticks = 0

    def update(self) -> Status:
        self.ticks += 1
        return Status.SUCCESS if self.ticks >= 4 else Status.RUNNING


def in_python() -> Mission:
    tree = Sequence([Behaviour(lambda: Work("work"), 0.5), Wait(1.0)])
    states = {"working": Tree(tree, timeout_s=60, transitions=[On("succeeded", to="over")]), "over": Final("canceled")}
    return Mission("python", initial="working", states=states)


KINDS = {
    "paused": Kind(made({"moving": do("move"), **DONE}), PAUSED),
    "paused_and_kept": Kind(made({"looking": do("kept"), **DONE}), PAUSED),
    "canceled": Kind(
        made({"moving": do("move", then="done"), "tidying": do("turn"), **DONE}, on_cancel="tidying", cancel_s=30),
        (Wish(2.0, lambda runner: runner.cancel(), is_mode("canceling")),),
    ),
    "handed_over": Kind(
        made({"first": do("move", control="agent", then="second"), "second": do("turn", control="autonomy"), **DONE})
    ),
    "each": Kind(
        made(
            {
                "tour": {
                    "each": "stops",
                    "as": "stop",
                    "initial": "going",
                    "states": {"going": do("move", then="there"), "there": {"final": "succeeded"}},
                    "transitions": [{"on": "succeeded", "to": "done"}],
                },
                **DONE,
            }
        )
    ),
    "history": Kind(
        made(
            {
                "working": {
                    "initial": "one",
                    "states": {"one": do("move", then="two"), "two": do("turn"), "back": {"history": "deep"}},
                    "transitions": [{"on": "poke", "when": {"key": "count", "<": 1}, "to": "aside"}],
                },
                "aside": {"entry": [{"set": "count", "add": 1}], "transitions": [{"after_s": 2, "to": "back"}]},
                **DONE,
            }
        ),
        (Wish(4.0, post("poke"), lambda runner: runner.view.board["count"].value == 1),),
    ),
    "raised_later": Kind(
        made(
            {
                "first": {
                    "entry": [{"raise": "go", "after_s": 6, "id": "x"}],
                    "transitions": [{"after_s": 2, "to": "second"}],
                },
                "second": {"transitions": [{"on": "go", "to": "done"}]},
                **DONE,
            }
        )
    ),
    "effects": Kind(
        made(
            {
                "first": {
                    "entry": [{"call": "horn"}, {"say": "go"}, {"publish": "light", "message": {"data": True}}],
                    "transitions": [{"after_s": 2, "to": "done", "do": [{"say": "over"}]}],
                },
                **DONE,
            }
        )
    ),
    "composed_and_repeatable": Kind(made({"towing": do("tow"), **DONE})),
    "python": Kind(in_python()),
    "named": Kind(
        made(
            {
                "moving": do("move", then="asking"),
                "asking": {
                    "transitions": [
                        {"when": {"named": "is_good"}, "to": "done"},
                        {"when": {"not": {"named": "is_good"}}, "to": "lost"},
                    ]
                },
                **DONE,
            }
        ),
        named={"is_good": lambda known, **_: known.get("battery", 0.0) > 0.5},
    ),
    "goal_open_at_the_end": Kind(
        made({"moving": {"action": "move", "timeout_s": 60, "transitions": [{"on": "poke", "to": "done"}]}, **DONE}),
        (Wish(1.0, post("poke"), is_in("done")),),
    ),
    "decided_late": Kind(
        made(
            {
                "moving": do("move", then="asking"),
                "asking": {
                    "decision": {
                        "question": "?",
                        "options": {"on": {"about": "", "when": {"key": "battery", ">": 0.5}}, "off": {"about": "off"}},
                        "ask": ["someone"],
                        "deadline_s": 20,
                        "fallback": "off",
                    },
                    "transitions": [{"on": "on", "to": "done"}, {"on": "off", "to": "lost"}],
                },
                **DONE,
            }
        )
    ),
    "held": Kind(
        made(
            {
                "waiting": {
                    "transitions": [{"when": {"held": {"key": "battery", ">": 0.5}, "for_s": 3}, "to": "done"}]
                },
                **DONE,
            }
        )
    ),
}


def farm(kind: Kind) -> Farm:
    return Farm(kind.wishes, kind.lasts_s, kind.ends)


@pytest.mark.parametrize("name", KINDS)
def test_a_run_that_is_killed_ends_as_if_it_had_not_been(tmp_path: Path, name: str) -> None:
    killed_at_all(tmp_path, name, every=29)


@pytest.mark.drill
@pytest.mark.parametrize("name", KINDS)
def test_a_run_that_is_killed_at_each_thing_it_does_ends_as_if_it_had_not_been(tmp_path: Path, name: str) -> None:
    killed_at_all(tmp_path, name, every=1)


def killed_at_all(tmp_path: Path, name: str, *, every: int) -> None:
    """Kill a run at every so manyth thing that it does, right before it and right after it."""
    kind, fate, there = KINDS[name], Fate(), farm(KINDS[name])
    answerers = {"someone": ReplyingAnswerer("on")}
    whole = tmp_path / "whole.journal"
    result = live(whole, there, kind.mission, FARMER, answerers, fate, kind.named)
    assert result is not None and result.outcome == "canceled"
    states = Counter(entered(whole))
    goals = Counter(action for action, _ in there.started)
    for turn in range(0, 2 * fate.count, every):
        at, is_done = divmod(turn, 2)
        path, again = tmp_path / f"{turn}.journal", farm(kind)
        ended = lived(path, again, [Fate(at, is_done=bool(is_done))], kind.mission, FARMER, 0.0, answerers, kind.named)
        where = f"killed {'after' if is_done else 'before'} {at} of {fate.count}"
        assert ended == (result.outcome, result.why), where
        assert Counter(entered(path)) == states, where
        assert Counter(a for a, _ in again.started if a != "tow") == Counter(
            {action: count for action, count in goals.items() if action != "tow"}
        ), where
        holds(path, again, kind.mission)
