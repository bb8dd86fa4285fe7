# SPDX-License-Identifier: Apache-2.0
"""The rules of the gate, pure: a `Gate` and what happens give the next `Gate` and what is done.

Rule: whatever happens, first the holder whose time is up loses control. So no command can be quicker than a lapse.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from rai_missions.errors import UsageError
from rai_missions.gate.state import (
    COMMANDERS,
    ActuatorCommand,
    Alive,
    Answer,
    ControlChange,
    Gate,
    GateEffect,
    GateEvent,
    GateRules,
    Pass,
    PublishStatus,
    Refuse,
    Request,
)
from rai_missions.runtime.lifecycle import Control

__all__ = ("step",)

Turn = tuple[Gate, tuple[GateEffect, ...]]


def step(rules: GateRules, gate: Gate, happening: GateEvent) -> Turn:
    """What a gate is after something has happened, and what is done, in this order.

    Time never runs backwards: what happens before the last instant known happens at it.
    """
    gate, lapsed = _lapse(rules, gate._replace(at=max(gate.at, happening.at)))
    if isinstance(happening, Request):
        gate, done = _request(gate, happening)
    elif isinstance(happening, ActuatorCommand):
        gate, done = _command(rules, gate, happening)
    else:
        gate, done = (_alive(gate, happening.who) if isinstance(happening, Alive) else gate), ()
    done = (*lapsed, *done)
    if gate.at >= gate.published + rules.status_s or any(isinstance(each, ControlChange | Answer) for each in done):
        gate = gate._replace(published=gate.at)
        done = (*done, PublishStatus(gate))
    return gate, done


def _lapse(rules: GateRules, gate: Gate) -> Turn:
    """A holder that is silent for longer than its lease loses control to the safe one.

    Where the safe one or the operator does, no one has it: only the operator gives back what the operator had.
    """
    if gate.at < gate.lapses_at(rules):
        return gate, ()
    control = Control(gate.holder, kept=gate.kept)
    control.acknowledge(rules.safe if gate.holder not in (rules.safe, "operator") else "nobody")
    return _changed(gate, control, f"{gate.holder} was silent for {rules.leases[gate.holder]:g} s")


def _request(gate: Gate, request: Request) -> Turn:
    control = Control(gate.holder, kept=gate.kept)
    try:
        why = control.request(request.to, "operator" if request.by == "operator" else "software")
    except UsageError as error:
        why = str(error)
    if request.by not in COMMANDERS:
        why = f"no one called '{request.by}' can ask for control; there is: {', '.join(COMMANDERS)}"
    if why:
        note = f"{request.by} asked for control to go to {request.to}: {why}"
        if request.by in COMMANDERS:  # of others there is no end
            gate = gate._replace(requests_refused=_counted(gate.requests_refused, request.by))
        gate = gate._replace(last_refusal=note)
        return gate, (Answer(gate.revision, request, why),)
    changes: tuple[GateEffect, ...] = ()
    if request.to != gate.holder:
        control.acknowledge(request.to)
        gate, changes = _changed(gate, control, f"{request.by} asked for it")
    gate = gate._replace(kept=control.kept)
    return gate, (*changes, Answer(gate.revision, request, ""))


def _command(rules: GateRules, gate: Gate, command: ActuatorCommand) -> Turn:
    who, command = command.who, command._replace(at=gate.at)
    why = _stops(gate, command) or ("" if command.topic in rules.unlooked else _no_finite(command.data))
    gate = _alive(gate, who)._replace(commanded={**gate.commanded, who: gate.at})
    if why:
        gate = gate._replace(refused=_counted(gate.refused, who), last_refusal=f"{who} on {command.topic}: {why}")
        return gate, (Refuse(gate.revision, command, why),)
    return gate._replace(passed=_counted(gate.passed, who)), (Pass(gate.revision, command),)


def _stops(gate: Gate, command: ActuatorCommand) -> str:
    """Why a command goes no further; empty if it is passed on."""
    if command.who != gate.holder:
        return f"{gate.holder} holds control"
    if command.made < gate.since:
        return f"it was made {gate.since - command.made:.3g} s before control was handed over, or by another clock"
    return ""


def _alive(gate: Gate, who: str) -> Gate:
    return gate._replace(alive={**gate.alive, who: gate.at})


def _changed(gate: Gate, control: Control, why: str) -> Turn:
    change = ControlChange(gate.revision + 1, gate.holder, control.holder, why)
    after = gate._replace(holder=control.holder, kept=control.kept, revision=change.revision, since=gate.at, why=why)
    return after, (change,)


def _counted(counts: Mapping[str, int], who: str) -> Mapping[str, int]:
    return {**counts, who: counts.get(who, 0) + 1}


def _no_finite(data: Any, path: str = "") -> str:
    """Which field holds no finite number, in a sentence; empty if none does."""
    if isinstance(data, float):
        return "" if math.isfinite(data) else f"'{path}' is {data}, which is no finite number"
    items: Iterable[tuple[object, Any]] = ()
    if isinstance(data, Mapping):
        items = data.items()
    elif isinstance(data, list | tuple):
        items = enumerate(data)
    elif hasattr(data, "tolist"):  # arrays and their numbers, of the standard library and of numpy
        plain = data.tolist()
        return _no_finite(plain, path)
    return next((why for name, item in items if (why := _no_finite(item, f"{path}.{name}".lstrip(".")))), "")
