# SPDX-License-Identifier: Apache-2.0
"""What the page's chart draws: the states, transitions and beginnings of a picture, with all that is written of them.

Rule: every state and every transition of the picture is in the data exactly once; only what is empty is left out.
"""

from __future__ import annotations

from collections.abc import Iterable

from rai_missions.mission.mission import Mission
from rai_missions.plain_data import plain
from rai_missions.states import State
from visualize.model import Picture, PictureEdge, PictureNode
from visualize.page.as_json import Json, without_empty
from visualize.parts import document_of, parts
from visualize.text import controlled

__all__ = ("chart_data",)


def chart_data(picture: Picture, mission: Mission, old: Mission | None = None) -> Json:
    """A picture as the page's chart takes it.

    Args:
        picture: What is drawn; its marks are kept.
        mission: Whose picture it is.
        old: The mission it is compared with, for what is gone.
    """
    states = {name: state for each in (old, mission) if each is not None for _, name, state in each.walk()}
    return {
        "name": picture.name,
        "version": picture.version,
        "about": picture.about,
        "compared": picture.compared,
        "notes": list(picture.notes),
        "states": [_state(node, states[node.name], mission) for node in picture.nodes],
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


def _definition(state: State) -> Json:
    """A state as it is written, with the names of the states inside it."""
    inside = {state.child_place(): list(state.children())} if state.children() else {}
    return {name: plain(value) for name, value in {**document_of(state), **inside}.items()}


def _state(node: PictureNode, state: State, mission: Mission) -> Json:
    reads, writes = keys_of(state, mission.blackboard)
    fields = node._asdict()
    fields["choices"] = [without_empty(choice._asdict()) for choice in node.choices]
    fields["twigs"] = [
        {**without_empty(twig._asdict()), "path": twig.path, "parent": twig.parent}
        | ({"choices": [without_empty(choice._asdict()) for choice in twig.choices]} if twig.choices else {})
        for twig in node.twigs
    ]
    fields.pop("entered")
    fields.pop("ended_here")
    return without_empty(
        {
            **fields,
            "controlled": controlled(node.control),
            "definition": _definition(state),
            "reads": reads,
            "writes": writes,
        }
    )


def _transition(edge: PictureEdge, source: State | None) -> Json:
    fields = edge._asdict()
    fields.pop("taken")
    fields.pop("option")
    return without_empty({**fields, "when": edge.when, "options": options_of(source, edge.place)})


def options_of(source: State | None, place: str) -> list[str]:
    """The options of a state's own decision that fire its transition."""
    index = int(place.rpartition("/")[2])
    if source is None or index >= len(source.transitions):  # of two states of one name, in a mission with faults
        return []
    transition = source.transitions[index]
    return [name for name in transition.on if name in source.options and transition.of is None]


def keys_of(state: State, keys: Iterable[str]) -> tuple[list[str], list[str]]:
    """The keys that a state reads and those that it writes, in the order of the blackboard."""
    written = [part for _, part in parts(state)]
    reads = {
        name.partition(".")[0] for part in written for refers, name, _ in part.references() if refers.sort == "path"
    }
    writes = {each.key for part in written for each in part.writes()}
    return [name for name in keys if name in reads], [name for name in keys if name in writes]
