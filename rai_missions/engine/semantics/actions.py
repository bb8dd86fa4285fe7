# SPDX-License-Identifier: Apache-2.0
"""Written effects compiled to acts on a run.

Rule: an act changes the blackboard, the internal queue or the timers, or adds an effect to the step; nothing is
performed here.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from rai_missions.engine.compiled.program import Program
from rai_missions.engine.compiled.states import Act, WriteAct, Written
from rai_missions.engine.semantics.blackboard import known, note_news, write_key
from rai_missions.engine.semantics.timers import drop, next_number, set_timer
from rai_missions.engine.state import RunState, Trigger
from rai_missions.engine.step import CallService, LogLine, PublishMessage, SayAloud
from rai_missions.engine.templates import SentTemplate, unpublished
from rai_missions.guards.view import Operand, Site
from rai_missions.keys import Key, Stamped, type_error
from rai_missions.plain_data import is_number
from rai_missions.redaction import clipped
from rai_missions.states.effects import Call, Drop, Effect, Log, Publish, Raise, Say, Set

__all__ = ("act_of", "failed_call")

LARGEST = 2**53
"""A whole number up to this can be added without a look at the sum: no run adds it so often that a sum is none."""

_new = tuple.__new__
"""Makes a `Stamped` the short way: this runs in every step that counts."""


def act_of(effect: Effect, place: str, state: str, keys: Mapping[str, Key], *, has_trees: bool) -> Act:
    """The act of an effect at a place of a mission, in a state.

    Args:
        effect: As the mission has it.
        place: Its JSON pointer.
        state: The state that it belongs to.
        keys: The blackboard.
        has_trees: Trees may look at what it writes.
    """
    site = Site(place, keys, state)
    if isinstance(effect, Set):
        return _noted(effect.set, _set(effect, site)) if has_trees else _set(effect, site)
    if isinstance(effect, Raise):
        return _raise(effect, site)
    if isinstance(effect, Drop):
        timer = effect.drop
        return lambda program, run: drop(run, timer)
    return _performed(effect, site)


def _noted(key: str, act: Act) -> Act:
    def noted(program: Program, run: RunState) -> None:
        before = known(program, run, key)
        act(program, run)
        note_news(program, run, key, before)

    return noted


def _set(effect: Set, site: Site) -> Act:
    """A write that is held to the key's type: here where the mission gives the value, else in the step."""
    name, key = effect.set, site.keys.get(effect.set)
    if effect.add is not None:
        return _add(name, key, effect.add)
    if effect.source is not None:
        return _copy(name, effect.source, site)
    value = effect.value
    if key is None or type_error(key, value):
        return partial(_write, name, value)

    written = ((name, value),)

    def write(run: RunState) -> Written:
        run.board[name] = _new(Stamped, (value, run.at))
        return written

    return WriteAct(write, partial(_write, name, value))


def _write(name: str, value: Any, program: Program, run: RunState) -> None:
    write_key(program, run, name, value)


def _copy(name: str, source: str, site: Site) -> Act:
    operand = Operand(source, site)

    def copy(program: Program, run: RunState) -> None:
        value = operand.read(run)
        if value is not None:
            write_key(program, run, name, value)
        else:
            run.draft.notes.append(f"'{name}' was not set: {source} is unknown")

    return copy


def _add(name: str, key: Key | None, amount: float) -> Act:
    """Adds to a number, which is 0 before it is known; a whole amount leaves an integer whole."""
    amount = int(amount) if key is not None and key.type == "integer" and amount == int(amount) else amount
    is_whole = isinstance(amount, int) and abs(amount) <= LARGEST and key is not None and key.type == "integer"
    kind = int if is_whole else None

    def write(run: RunState) -> Written | None:
        board = run.board
        old = board[name][0] if name in board else 0
        if type(old) is not kind:
            return None
        value = old + amount
        board[name] = _new(Stamped, (value, run.at))
        return ((name, value),)

    def add(program: Program, run: RunState) -> None:
        entry = run.board.get(name)
        old = entry.value if entry is not None else 0
        if is_number(old):
            write_key(program, run, name, old + amount)
        else:
            run.draft.notes.append(f"'{name}' was not written: nothing can be added to {clipped(repr(old), 80)}")

    return WriteAct(write, add)


def _raise(effect: Raise, site: Site) -> Act:
    name, after_s, timer = effect.event, effect.after_s, effect.id
    data = SentTemplate("data", effect.data, site)

    def at_once(program: Program, run: RunState) -> None:
        run.draft.internal.append(Trigger(name, data.fill(run).fields if effect.data else {}))

    def later(program: Program, run: RunState) -> None:
        assert after_s is not None
        control = program.graph.nodes[site.state].control if site.state else None
        key = ("raise", timer if timer is not None else run.order + 1)
        set_timer(run, key, after_s, name, data.fill(run).fields if effect.data else None, control)

    return at_once if after_s is None else later


def failed_call(run: RunState, service: str, why: str) -> Trigger:
    """What an effect's call raises that has failed, or could not be sent."""
    run.draft.notes.append(f"call of '{service}' failed: {why}")
    return Trigger("call_failed", {"call": service, "why": why})


def _performed(effect: Effect, site: Site) -> Act:
    """Effects that are carried out once the step is written down."""
    if isinstance(effect, Call):
        service, request = effect.call, SentTemplate("request", effect.request, site)

        def call(program: Program, run: RunState) -> None:
            fields, lack = request.fill(run)
            if lack:
                run.draft.internal.append(failed_call(run, service, lack))
                return
            number = next_number(run)
            run.calls[number] = service
            run.draft.effects.append(CallService(number, "", service, fields))

        return call
    if isinstance(effect, Publish):
        topic, message = effect.publish, SentTemplate("message", effect.message, site)

        def publish(program: Program, run: RunState) -> None:
            fields, lack = message.fill(run)
            if lack:
                run.draft.notes.append(unpublished(topic, lack))
            else:
                run.draft.effects.append(PublishMessage(topic, fields))

        return publish
    if isinstance(effect, Say):
        sentence = SayAloud(effect.say)
        return lambda program, run: run.draft.effects.append(sentence)
    assert isinstance(effect, Log)
    line = LogLine(effect.log)
    return lambda program, run: run.draft.effects.append(line)
