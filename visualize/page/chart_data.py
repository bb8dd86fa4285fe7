# SPDX-License-Identifier: Apache-2.0
"""What the page's chart draws: the states, transitions and beginnings of a picture, with all that is written of them.

Rule: every state and every transition of the picture is in the data exactly once; only what is empty is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rai_missions.mission.mission import Mission
from rai_missions.plain_data import plain
from rai_missions.states import State
from rai_missions.states.state import descendants
from visualize.model import Picture, PictureEdge, PictureNode
from visualize.page.as_json import Json, without_empty

__all__ = ("chart_data",)

READING, WRITING = ("key", "fresh", "near", "from", "evidence", "each"), ("set", "as")
"""The words of the format under which a key is read or written."""


def chart_data(picture: Picture, mission: Mission, old: Mission | None = None) -> Json:
    """A picture as the page's chart takes it.

    Args:
        picture: What is drawn; its marks are kept.
        mission: Whose picture it is.
        old: The mission it is compared with, for what is gone.
    """
    written = dict(_definitions(old)) if old is not None else {}
    written |= dict(_definitions(mission))
    states = {name: state for each in (old, mission) if each is not None for _, name, state in each.walk()}
    return {
        "name": picture.name,
        "version": picture.version,
        "about": picture.about,
        "compared": picture.compared,
        "notes": list(picture.notes),
        "states": [_state(node, written.get(node.name, {}), mission) for node in picture.nodes],
        "transitions": [_transition(edge, states.get(edge.source)) for edge in picture.edges],
        "initials": [[initial.parent, initial.target] for initial in picture.initials],
        "own": [plain(transition.written()) for transition in mission.transitions],
        "keys": {name: plain(key.written()) for name, key in mission.blackboard.items()},
        "events": {name: plain(event.written()) for name, event in mission.events.items()},
        "invariants": [
            {"name": name, "guard": guard.words(), "definition": plain(guard.written())}
            for name, guard in mission.invariants.items()
        ],
    }


def _definitions(mission: Mission) -> Iterator[tuple[str, Json]]:
    """Each state as it is written, without the states inside it."""
    for _, name, state in mission.walk():
        inside = {state.child_place(): list(state.children())} if state.children() else {}
        yield name, plain({**_written(state), **inside})


def _written(state: State) -> Json:
    """As JSON has it; of a behaviour of the user's program, which JSON cannot hold, the name."""
    within = (each for _, _, each in descendants(state.children()))
    if not any(each.program() for each in (state, *within)):
        return state.written()
    apart = {"states", "parallel", "tree"}
    found = state.model_dump(mode="json", by_alias=True, exclude_defaults=True, exclude=apart)  # type: ignore[call-arg]
    return {"behaviour": state.program(), **found} if state.program() else found


def _state(node: PictureNode, written: Json, mission: Mission) -> Json:
    reads, writes = keys_of(written, mission.blackboard)
    fields = node._asdict()
    fields["choices"] = [without_empty(choice._asdict()) for choice in node.choices]
    fields["twigs"] = [
        {**without_empty(twig._asdict()), "path": twig.path, "parent": twig.parent}
        | ({"choices": [without_empty(choice._asdict()) for choice in twig.choices]} if twig.choices else {})
        for twig in node.twigs
    ]
    fields.pop("entered")
    fields.pop("ended_here")
    return without_empty({**fields, "definition": written, "reads": reads, "writes": writes})


def _transition(edge: PictureEdge, source: State | None) -> Json:
    fields = edge._asdict()
    fields.pop("taken")
    fields.pop("option")
    return without_empty({**fields, "when": edge.when, "options": options_of(source, edge.place)})


def options_of(source: State | None, place: str) -> list[str]:
    """The options of a state's own decision that fire its transition."""
    if source is None:
        return []
    transition = source.transitions[int(place.rpartition("/")[2])]
    return [name for name in transition.on if name in source.options and transition.of is None]


def keys_of(written: Any, keys: Mapping[str, Any]) -> tuple[list[str], list[str]]:
    """The keys that a definition reads and those that it writes, in the order of the blackboard."""
    reads: set[str] = set()
    writes: set[str] = set()

    def note(value: Any, found: set[str]) -> None:
        for item in value if isinstance(value, list) else [value]:
            if isinstance(item, str) and item.partition(".")[0] in keys:
                found.add(item.partition(".")[0])

    def look(value: Any) -> None:
        if isinstance(value, dict):
            for word, item in value.items():
                if word in READING:
                    note(item, reads)
                elif word in WRITING:
                    note(item, writes)
                elif word == "result" and isinstance(item, dict):
                    note(list(item), writes)
                look(item)
        elif isinstance(value, list):
            for item in value:
                look(item)

    look(written)
    return [name for name in keys if name in reads], [name for name in keys if name in writes]
