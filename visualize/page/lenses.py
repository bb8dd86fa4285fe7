# SPDX-License-Identifier: Apache-2.0
"""What a reviewer asks of a mission, answered on its picture: each lens lights some of it and says the rest in words.

Rule: a lens is data. It names states, and rows and options by JSON pointer; whoever draws dims all the others.
"""

from __future__ import annotations

from rai_missions.guards.in_state import In
from rai_missions.mission.mission import Mission
from rai_missions.states import Final
from visualize.model import Picture
from visualize.page.as_json import Json
from visualize.page.lens import item, lens
from visualize.page.model_lens import asked_of, say_lens
from visualize.page.reachability import Roads

__all__ = ("lenses",)


def lenses(mission: Mission, picture: Picture) -> list[Json]:
    """The four questions in the order of the page's switches."""
    roads = Roads(mission)
    return [
        say_lens(mission, picture, roads),
        _operator(mission, picture),
        _stops(mission, picture, roads),
        _invariants(mission, picture, roads),
    ]


def _operator(mission: Mission, picture: Picture) -> Json:
    asked = asked_of(mission, "operator")
    held = [name for _, name, state in mission.walk() if state.control == "operator"]
    rows = {edge.place for edge in picture.edges for each in asked if edge.source == each.state and edge.option}
    answers = [
        item(f"{each.state}: “{each.asked.question}” – {', '.join(each.asked.options)}", state=each.state)
        for each in asked
    ]
    commands = [
        item("pause and resume: timers keep the time left, goals are canceled and started again, events wait"),
        item(_cancel_words(mission), state=mission.on_cancel or ""),
        item("e-stop (kill): acts at once, before it is written down; the mission ends aborted"),
        item("take and return control; only an operator lifts control from nobody"),
    ]
    return lens(
        "operator", "What may the operator do?", "o",
        states=[each.state for each in asked] + held + ([mission.on_cancel] if mission.on_cancel else []),
        rows=rows, options=[place for each in asked for place in each.options()],
        sections=[
            ("Questions that an operator may answer", answers or [item("none: no decision asks the operator")]),
            ("States that the operator controls", [item(name, state=name) for name in held] or [item("none")]),
            ("At any time", commands),
        ],
    )  # fmt: skip


def _cancel_words(mission: Mission) -> str:
    if mission.on_cancel:
        return f"cancel: goes to '{mission.on_cancel}', which has {mission.cancel_s:g} s; the mission ends canceled"
    return "cancel: everything is left and its goals are canceled; the mission ends canceled"


def _stops(mission: Mission, picture: Picture, roads: Roads) -> Json:
    ends = [name for name, state in mission.states.items() if isinstance(state, Final) and state.final != "succeeded"]
    after = roads.onward([mission.on_cancel]) if mission.on_cancel else None
    moving = [node.name for node in picture.nodes if node.kind in ("action", "call")]
    moving += [node.name for node in picture.nodes if any(twig.kind in ("action", "call") for twig in node.twigs)]
    to_ends = [edge for edge in picture.edges if edge.target in ends]
    cancel = [item(_cancel_words(mission), state=mission.on_cancel or "")]
    if after is not None:
        finals = [name for name in roads.states if name in after.states and roads.states[name].word == "final"]
        cancel.append(item(f"from there it may reach {', '.join(finals) or 'no final'}"))
    return lens(
        "stops", "Where do e-stop and cancel lead?", "e",
        states=[*ends, *moving, *(after.states if after else ())],
        rows=[*(edge.place for edge in to_ends), *(after.rows if after else ())],
        sections=[
            ("E-stop (kill)", [
                item("from every state, at once: whatever runs is canceled, control goes to nobody, it ends aborted"),
                item("an invariant that is false does the same"),
            ]),
            ("Cancel", cancel),
            ("Rows that end the mission otherwise than succeeded", [
                item(f"{edge.source or 'every state'} → {edge.target}: {edge.when} {edge.guard}", row=edge.place)
                for edge in to_ends
            ] or [item("none")]),
            ("States with something to be canceled", [item(name, state=name) for name in dict.fromkeys(moving)]),
        ],
    )  # fmt: skip


def _invariants(mission: Mission, picture: Picture, roads: Roads) -> Json:
    sections, states, rows = [], set[str](), set[str]()
    for name, guard in mission.invariants.items():
        named = {part.state for part in guard.walk() if isinstance(part, In)}
        inside = {state for state in roads.states if state in named or named & set(roads.above(state))}
        into = [edge for edge in picture.edges if edge.target in inside and edge.source not in inside]
        states |= inside
        rows |= {edge.place for edge in into}
        said = [item(f"never false: {guard.words()}")]
        said += [item(f"speaks of '{state}'", state=state) for state in sorted(named)]
        said += [item(f"entered by {edge.source or 'every state'}: {edge.when}", row=edge.place) for edge in into]
        sections.append((name, said))
    none = [("Invariants", [item("none: nothing ends this mission at once but the e-stop")])]
    return lens(
        "invariants", "What must never be false?", "i", states=states, rows=rows, sections=sections or none
    )  # fmt: skip
