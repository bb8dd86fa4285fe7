# SPDX-License-Identifier: Apache-2.0
"""What joins the parts of a drawn mission: targets in several regions, histories with defaults, outcomes of others."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

from rai_missions.mission.mission import BUILT_IN_EVENTS

__all__ = ("link",)

Json = dict[str, Any]
ENDS = (["failed", "unverified", "timed_out"], ["rejected", "canceled", "aborted"], ["succeeded"])
COUNT: Json = {"set": "n", "add": 1}


def link(rng: random.Random, states: Json) -> None:
    """Join the states of a mission in ways that one state does not show.

    Args:
        rng: What decides.
        states: Of the mission, as JSON has them; they are changed.
    """
    every = list(_walk(states, {}))
    names = [name for name, _, _ in every]
    several = [
        [[region, *_within(state)] for region, state in each["parallel"].items()]
        for _, each, _ in every
        if "parallel" in each
    ]
    for name, state, parent in every:
        if "history" in state:
            _default(rng, name, state, parent)
            continue
        for transition in state.get("transitions", ()):
            _lead(rng, state, transition, several)
            _read(rng, transition)
        if transitions := state.get("transitions"):
            for trigger in (
                {"on": rng.choice(ENDS), "of": _reporter(rng, every, name)},
                {"on": rng.choice(BUILT_IN_EVENTS)},
            ):
                if rng.random() < 0.15:
                    leads = {"to": rng.choice(names)} if rng.random() < 0.6 else {"do": [COUNT]}
                    transitions.insert(rng.randint(0, len(transitions)), {**trigger, **leads})
        if "states" in state and rng.random() < 0.15:
            state["initial"] = rng.choice(_entered(state))


def _walk(states: Json, parent: Json) -> Iterator[tuple[str, Json, Json]]:
    for name, state in states.items():
        yield name, state, parent
        yield from _walk({**state.get("states", {}), **state.get("parallel", {})}, state)


def _within(state: Json) -> list[str]:
    return [name for name, _, _ in _walk({**state.get("states", {}), **state.get("parallel", {})}, {})]


def _entered(state: Json) -> list[str]:
    """The states within a state that are no history."""
    return [name for name, each, _ in _walk(state["states"], {}) if "history" not in each]


def _reporter(rng: random.Random, every: list[tuple[str, Json, Json]], name: str) -> str:
    return rng.choice([each for each, state, _ in every if not state.keys() & {"final", "history"}] or [name])


def _default(rng: random.Random, name: str, history: Json, parent: Json) -> None:
    if "states" in parent and (targets := _entered(parent)) and rng.random() < 0.4:
        history["transitions"] = [{"to": rng.choice(targets)}]
        if rng.random() < 0.4:
            parent["initial"] = name


def _lead(rng: random.Random, state: Json, transition: Json, several: list[list[list[str]]]) -> None:
    if transition.get("to") in _within(state) and rng.random() < 0.5:
        transition["internal"] = True
    if several and "on" in transition and "to" in transition and rng.random() < 0.12:
        transition["to"] = [rng.choice(region) for region in rng.choice(several)]


def _read(rng: random.Random, transition: Json) -> None:
    """Have it write what its event or answer brought along."""
    sources = {"a": "event.k", "b": "event.k", "left": "answer.given", "right": "answer.given"}
    on = transition.get("on")
    if isinstance(on, str) and on in sources and rng.random() < 0.3:
        transition.setdefault("do", []).append({"set": "n", "from": sources[on]})
