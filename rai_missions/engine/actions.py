# SPDX-License-Identifier: Apache-2.0
"""Written effects compiled to acts on a chart.

Rule: an act changes the blackboard, the internal queue or the timers, or adds an effect to the step; it tells nobody.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from rai_missions.engine.nodes import Act
from rai_missions.engine.step import CallService, LogLine, PublishMessage, SayAloud
from rai_missions.guards.guard import Operand, Site, View
from rai_missions.keys import Key, Stamped, fits, is_number
from rai_missions.redaction import clipped
from rai_missions.states.effects import Call, Drop, Effect, Log, Publish, Raise, Say, Set, filled

__all__ = ("Act", "ActionTarget", "act_of")


class ActionTarget(Protocol):
    """What acts work on: the chart."""

    @property
    def view(self) -> View: ...

    written: list[tuple[str, Any]]
    effects: list[Any]
    notes: list[str]

    def raise_event(self, name: str, data: Mapping[str, Any]) -> None: ...

    def raise_later(
        self, name: str, data: Mapping[str, Any], after_s: float, timer: str | None, state: str = ""
    ) -> None: ...

    def drop(self, timer: str) -> None: ...

    def write_key(self, key: str, value: Any) -> bool: ...

    def next_call(self, service: str) -> int: ...


_new = tuple.__new__


def stamped(value: Any, at: float) -> Stamped:
    """A `Stamped`, made the short way: this runs in every step that counts."""
    return _new(Stamped, (value, at))


def act_of(effect: Effect, place: str, state: str, keys: Mapping[str, Key]) -> Act:
    """The act of an effect that stands at a place of a mission, in a state."""
    site = Site(place, keys, state)
    if isinstance(effect, Set):
        return _set(effect, site)
    if isinstance(effect, Raise):
        return _raise(effect, site)
    if isinstance(effect, Drop):
        timer = effect.drop
        return lambda chart: chart.drop(timer)
    return _told(effect, site)


def _set(effect: Set, site: Site) -> Act:
    """A write that is held to the key's type: here where the mission says the value, else in the step."""
    name, key = effect.set, site.keys.get(effect.set)
    if effect.add is not None:
        return _add(name, key, effect.add)
    if effect.source is not None:
        return _copy(name, effect.source, site)
    value = effect.value
    if key is None or fits(key, value):
        return lambda chart: chart.write_key(name, value)

    def put(chart: ActionTarget) -> None:
        chart.view.board[name] = stamped(value, chart.view.at)
        chart.written.append((name, value))

    return put


def _copy(name: str, source: str, site: Site) -> Act:
    operand = Operand(source, site)

    def copy(chart: ActionTarget) -> None:
        value = operand.read(chart.view)
        if value is not None:
            chart.write_key(name, value)
        else:
            chart.notes.append(f"'{name}' was not set: {source} is unknown")

    return copy


def _add(name: str, key: Key | None, amount: float) -> Act:
    """Adds to a number, which is 0 before it is known; a whole amount leaves an integer whole."""
    amount = int(amount) if key is not None and key.type == "integer" and amount == int(amount) else amount
    kind = int if isinstance(amount, int) and key is not None and key.type == "integer" else None

    def add(chart: ActionTarget) -> None:
        view = chart.view
        board = view.board
        entry = board.get(name)
        old = entry[0] if entry is not None else 0
        if old.__class__ is kind:
            value = old + amount
            board[name] = stamped(value, view.at)
            chart.written.append((name, value))
        elif is_number(old):
            chart.write_key(name, old + amount)
        else:
            chart.notes.append(f"'{name}' was not written: nothing can be added to {clipped(repr(old), 80)}")

    return add


def _raise(effect: Raise, site: Site) -> Act:
    name, data, after_s, timer = effect.event, dict(effect.data), effect.after_s, effect.id
    if after_s is None:
        return lambda chart: chart.raise_event(name, filled(data, chart.view, site) if data else {})
    state = site.state
    return lambda chart: chart.raise_later(name, filled(data, chart.view, site) if data else {}, after_s, timer, state)


def _told(effect: Effect, site: Site) -> Act:
    """Effects that the performer carries out."""
    if isinstance(effect, Call):
        service, request = effect.call, effect.request

        def call(chart: ActionTarget) -> None:
            number = chart.next_call(service)
            chart.effects.append(CallService(number, "", service, filled(request, chart.view, site)))

        return call
    if isinstance(effect, Publish):
        topic, message = effect.publish, effect.message
        return lambda chart: chart.effects.append(PublishMessage(topic, filled(message, chart.view, site)))
    if isinstance(effect, Say):
        said = SayAloud(effect.say)
        return lambda chart: chart.effects.append(said)
    assert isinstance(effect, Log)
    line = LogLine(effect.log)
    return lambda chart: chart.effects.append(line)
