# SPDX-License-Identifier: Apache-2.0
"""A person asks for facts while they come, age and break: what is answered is what a guard sees at that time.

The oracle keeps the last reading of each fact that fits its key, with its stamp; nothing else is known.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import pytest

from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.talk.doors import TalkLine, TextDoor
from rai_missions.connectors.local import LocalConnector
from rai_missions.conversation import Settings
from rai_missions.engine.step import LogLine, Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.clock import Clock
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner
from tests.agents.talk.scenes import settle
from tests.rigs.turns import Turns

Json = dict[str, Any]
KEYS: Json = {
    "battery": {"type": "number", "max_age_s": 2.0},
    "passed": {"type": "boolean", "max_age_s": 1.0},
    "obstacle": {"type": "object", "max_age_s": 1.5,
                 "fields": {"height_m": "number", "living": "boolean", "kind": "string", "lane": "integer"}},
    "alleys": {"type": "integer", "max_age_s": 2.0},
    "label": {"type": "string"},
}  # fmt: skip
VALUES: Json = {
    "battery": (0.5, 0.25, 1, math.nan, math.inf, -math.inf, None, "0.5", True, 10**400),
    "passed": (True, False, None, 1, "yes", math.nan),
    "alleys": (0, 2, 3, 2.5, math.nan, None, True),
    "label": ("north", "", "south", None, 7),
}
FIELDS: Json = {
    "height_m": (0.25, 0.5, 2, math.nan, math.inf, None, "high"), "living": (True, False, None, "no", 0),
    "kind": ("log", "branch", "", None, 3), "lane": (0, 1, None, 1.5),
}  # fmt: skip
ASKED = {
    "battery": "what is the battery?", "passed": "what is passed?", "alleys": "what is alleys?",
    "label": "what is the label?", "obstacle.height_m": "what is the obstacle height?",
    "obstacle.living": "is the obstacle living?", "obstacle.kind": "what is the obstacle kind?",
    "obstacle.lane": "what is the obstacle lane?", "progress": "how far are you?",
}  # fmt: skip
COUNTED = "alleys"
WORDS = {True: "yes", False: "no", "": "empty"}
PATHS = tuple(path for path in ASKED if path != "progress")
TOTAL, OVER_S, EVERY_S = 5, 10.0, 0.125
GOOD, LAGS = 0.6, (0.0, 0.0, 0.25, 1.0, 3.0)
"""How often a value fits, and how old readings are when they come."""
MOST_ASKED = 18
"""Sentences in a succession that a door lets through."""
FITS: dict[str, Callable[[Any], bool]] = {
    "number": lambda value: type(value) in (int, float) and abs(value) < 1e300,
    "integer": lambda value: type(value) is int,
    "boolean": lambda value: type(value) is bool,
    "string": lambda value: type(value) is str,
}


def probe(path: str) -> str:
    """The event that has a guard look at a fact."""
    return f"look_{path.replace('.', '_')}"


def looks(path: str) -> list[Json]:
    """Transitions that log what a guard sees of a fact, compared with what the event has."""
    equal: Json = {"key": path, "==": {"key": "event.value"}}
    seen = (("equal", equal), ("unequal", {"not": equal}), ("unknown", None))
    return [
        {"on": probe(path), **({"when": guard} if guard else {}), "do": [{"log": f"{path} {word}"}]}
        for word, guard in seen
    ]


def watching() -> Mission:
    """A mission that only looks, and counts alleys."""
    counted: Json = {"key": "alleys", ">=": TOTAL}
    keys: Json = {name: {"source": "robot", "optional": True, **key} for name, key in KEYS.items()}
    return Mission.model_validate(
        {
            "name": "watching",
            "blackboard": keys,
            "initial": "here",
            "events": {probe(path): {} for path in PATHS},
            "states": {
                "here": {"transitions": [each for path in PATHS for each in looks(path)]},
                "done": {"final": "succeeded", "requires": counted},
            },
            "transitions": [{"when": {"held": counted, "for_s": 1e6}, "to": "done"}],
        }
    )


ROBOT = Robot.model_validate(
    {
        "name": "any",
        "blackboard": {name: {"topic": f"/{name}", "type": "x/msg/Stamped", "field": "value"} for name in KEYS},
        "events": {probe(path): {"posted": True} for path in PATHS},
    }
)


class Known(NamedTuple):
    """The last reading of a fact that fits its key."""

    value: Any
    stamp: float


class Watched:
    """A run whose facts come, age and break, while a person asks for them and guards look at them.

    Args:
        seed: The seed of all that happens.
    """

    def __init__(self, seed: int) -> None:
        self.turns = turns = Turns()
        self._rng = rng = random.Random(seed)
        self._known = dict[str, Known]()
        self._lines: list[str] = []
        self.seen: list[str] = []
        self.expected = list[str]()
        self.found = Counter[str]()
        self._connector = LocalConnector(now=turns.now)
        self._connector.start()

        def make(clock: Clock) -> Callable[[], object]:
            self._runner = Runner(
                watching(),
                robot=ROBOT,
                connector=self._connector,
                clock=clock,
                observer=RunObserver(self._step, self._changed),
            )
            return self._runner.run

        turns.begin(make)
        self._agent = agent = ConversationalAgent(Settings(), doors=[TextDoor("terminal", self._show)], now=turns.now)
        agent.attach(self._runner)
        agent.run()
        turns.settle = partial(settle, agent)
        asked = 0
        for number in range(1, int(OVER_S / EVERY_S)):
            kind = rng.choice(["reports", "reports", "reports", "asks"])
            path = rng.choice(list(ASKED))
            if kind == "reports":
                turns.call_at(number * EVERY_S, partial(self._report, rng.choice(list(KEYS)), number * EVERY_S))
            elif kind == "asks" and asked < MOST_ASKED:
                asked += 1
                turns.call_at(number * EVERY_S, partial(self._ask, path))
        turns.call_at(OVER_S, lambda: self._runner.kill())
        turns.play(OVER_S + 1.0)
        agent.stop()

    def _step(self, step: Step) -> None:
        self.seen += [each.text for each in step.effects if isinstance(each, LogLine)]
        self._agent.step(step)

    def _changed(self, status: Any) -> None:
        self._agent.changed(status)

    def _show(self, line: TalkLine) -> None:
        if line.by == "robot":
            self._lines.append(line.text)

    # -- what happens --------------------------------------------------------------------------------------------------

    def _report(self, name: str, at: float) -> None:
        rng = self._rng
        if name in VALUES:
            value = self._drawn(VALUES[name])
        else:
            value = {field: self._drawn(FIELDS[field]) for field in FIELDS if rng.random() < 0.8}
        stamp = max(0.0, at - rng.choice(LAGS))
        header = {"stamp": {"sec": int(stamp), "nanosec": int(stamp % 1 * 1e9)}}
        self._connector.publish(f"/{name}", "x/msg/Stamped", {"header": header, "value": value})
        stamp = stamp or at
        is_older = name in self._known and stamp < self._known[name].stamp
        if not is_older and (kept := reading(KEYS[name], value)) is not None:
            self._known[name] = Known(kept, stamp)

    def _drawn(self, values: tuple[Any, ...]) -> Any:
        """Mostly a value that fits."""
        return self._rng.choice(values[:2] if self._rng.random() < GOOD else values)

    def _ask(self, path: str) -> None:
        """A person asks, and a guard looks at the same instant."""
        before, value = len(self._lines), self._value(path)
        assert not self._agent.receive(ASKED[path], role="operator", channel="terminal", author="Anna")
        self._agent.wait_answered(20.0)
        answer = self._lines[before:][-1]
        if value is None:
            assert "unknown" in answer, (self.turns.at, path, answer)
        else:
            words = WORDS.get(value, str(value)) if isinstance(value, bool | str) else f"{value:g}"
            assert "unknown" not in answer and f": {words}" in answer.replace(" of 5", ""), (
                self.turns.at,
                path,
                answer,
            )
        path = COUNTED if path == "progress" else path
        guess = self._rng.choice([value, *(VALUES.get(path) or FIELDS[path.partition(".")[2]])[:2]])
        guess = 0 if guess is None else guess
        self._runner.post(Event(probe(path), self.turns.at, {"value": guess}))
        self.expected.append(f"{path} {'unknown' if value is None else 'equal' if guess == value else 'unequal'}")
        self.found[self.expected[-1]] += 1

    def _value(self, path: str) -> Any:
        """What is known of a fact now."""
        name, _, field = (COUNTED if path == "progress" else path).partition(".")
        known = self._known.get(name)
        if known is None or self.turns.at >= known.stamp + KEYS[name].get("max_age_s", math.inf):
            return None
        return known.value.get(field) if field else known.value


def reading(key: Json, value: Any) -> Any:
    """What a key has of a reading; None where it does not fit."""
    if key["type"] != "object":
        return value if FITS[key["type"]](value) else None
    kinds = key.get("fields", {})
    finite = {
        name: None if isinstance(each, float) and not math.isfinite(each) else each for name, each in value.items()
    }
    fits = all(each is None or FITS[kinds[name]](each) for name, each in finite.items() if name in kinds)
    return finite if fits else None


def agree(seed: int) -> Counter[str]:
    """Hold the guards of a run against the oracle, which its answers were held against; what was asked."""
    watched = Watched(seed)
    assert watched.seen == watched.expected, seed
    return watched.found


@pytest.mark.parametrize("seed", range(4))
def test_what_is_answered_is_what_a_guard_sees(seed: int) -> None:
    assert agree(seed)


@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_what_is_answered_in_many_runs_is_what_a_guard_sees() -> None:
    found = sum((agree(seed) for seed in range(1_000)), Counter[str]())
    assert min(found.values()) > 100, found
