# SPDX-License-Identifier: Apache-2.0
"""The parts of a written mission, for those that list or compare them.

Rule: a state is what is written in it, without the states inside it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rai_missions.model import MissionModel
from rai_missions.states import State

__all__ = ("document_of", "parts")


def parts(thing: MissionModel, place: str = "") -> Iterator[tuple[str, MissionModel]]:
    """A written thing and all that is written inside it, but for states, each with its JSON pointer."""
    yield place, thing
    for here, inner in thing.inside(place):
        if not isinstance(inner, State):
            yield from parts(inner, here)


def document_of(state: State) -> dict[str, Any]:
    """A state as JSON has it; for a behaviour of the user's program, which JSON cannot hold, its name."""
    own = state.with_children({})
    if not (program := own.program()):
        return own.written()
    words = own.model_dump(mode="json", exclude={"tree"})
    return {"behaviour": program, **words}
