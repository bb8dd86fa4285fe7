# SPDX-License-Identifier: Apache-2.0
"""The machine of a reading: the grammar, once; after a question that offered goals, first as the answer to it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.engine.activities.activity import Bench, machine_of
from rai_missions.engine.activities.computing import ComputedResult, ComputingMachine
from rai_missions.errors import DefinitionError
from rai_missions.states.read import Read

__all__ = ()


def _read(request: Any, seen: Any, last: Any) -> ComputedResult:
    from rai_missions.planning import read_scene
    from rai_missions.planning.reading import RequestReading, read_answer, reading_data  # a grammar with its languages

    offered = last.get("candidates") if isinstance(last, Mapping) else None
    try:
        value = read_answer(str(request), offered or (), read_scene(seen))
    except DefinitionError as error:
        why = f"what is seen cannot be read: {error.faults[0]}"
        value = reading_data(RequestReading(reason="unreadable", about=why))
    outcome = "succeeded" if value["goal"] is not None else "unclear" if value["question"] else "refused"
    return ComputedResult(outcome, value, value["about"])


@machine_of.register(Read)
def _(definition: Read, bench: Bench) -> ComputingMachine:
    given = (definition.read_, definition.over)
    return ComputingMachine(bench.owner, bench.site(), given, definition.into, _read, follows=True)
