# SPDX-License-Identifier: Apache-2.0
"""Gates and what may happen to them, made up by hypothesis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from hypothesis import strategies as st

from rai_missions.gate.rules import step
from rai_missions.gate.state import (
    COMMANDERS,
    ActuatorCommand,
    Alive,
    Gate,
    GateEffect,
    GateEvent,
    GateRules,
    Request,
    TimeUpdate,
)
from rai_missions.states.control import HOLDERS

__all__ = ("GateMoment", "happenings", "live", "rules")

WHO = st.sampled_from(COMMANDERS)
INSTANTS = st.integers(0, 40).map(lambda tenths: tenths / 10)
rules = st.builds(
    GateRules,
    leases=st.dictionaries(WHO, st.sampled_from([0.1, 0.3, 0.5, 1.0])),
    safe=st.sampled_from(["autonomy", "nobody"]),
    status_s=st.sampled_from([0.3, 1.0]),
)


def _made(at: float) -> st.SearchStrategy[float]:
    return st.one_of(st.just(math.inf), st.floats(0, 0.5).map(lambda age: at - age))


def _command(at: float) -> st.SearchStrategy[ActuatorCommand]:
    return st.builds(ActuatorCommand, st.just(at), WHO, st.sampled_from(["/cmd_vel", "/arm"]), st.just({}), _made(at))


def _one(at: float) -> st.SearchStrategy[GateEvent]:
    return st.one_of(
        _command(at),
        _command(at),
        st.builds(Request, st.just(at), st.sampled_from([*HOLDERS, "bob"]), st.sampled_from([*COMMANDERS, "eve"])),
        st.builds(Alive, st.just(at), WHO),
        st.builds(TimeUpdate, st.just(at)),
    )


happenings = (
    st.integers(0, 40)  # lists are short where their length is not drawn first, and then hardly a command goes through
    .flatmap(lambda count: st.lists(INSTANTS, min_size=count, max_size=count))
    .flatmap(lambda ats: st.tuples(*(_one(at) for at in sorted(ats))))
)


class GateMoment(NamedTuple):
    """One moment of a gate: before, what happened, after, and what was done."""

    before: Gate
    happened: GateEvent
    after: Gate
    done: tuple[GateEffect, ...]


def live(given: GateRules, happened: Sequence[GateEvent]) -> list[GateMoment]:
    """A gate's whole life."""
    gate, lived = Gate(holder=given.safe), []
    for each in happened:
        after, done = step(given, gate, each)
        lived.append(GateMoment(gate, each, after, done))
        gate = after
    return lived
