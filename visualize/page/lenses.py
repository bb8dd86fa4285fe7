# SPDX-License-Identifier: Apache-2.0
"""What a reviewer asks of a mission, answered on its picture: each lens lights some of it and explains the rest.

Rule: a lens is data. It names states, and transitions and options by JSON pointer; what draws them dims all others.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rai_missions.mission.mission import Mission
from rai_missions.states import DecisionSpec, Final, State, answerer_words
from visualize.model import Picture, PictureEdge
from visualize.page.as_json import Json
from visualize.page.decision_sites import DecisionSite, asked_in_turn, asked_of, bound, silence
from visualize.page.reachability import ReachableParts, Roads
from visualize.text import canceled

__all__ = ("lens", "lenses")


def lenses(mission: Mission, picture: Picture) -> list[Json]:
    """The four questions in the order of the page's switches."""
    roads = Roads(mission)
    return [
        _model_lens(mission, picture, roads),
        _operator_lens(mission, picture),
        _stops_lens(mission, picture, roads),
        _invariants_lens(mission, picture, roads),
    ]


def _operator_lens(mission: Mission, picture: Picture) -> Json:
    asked = asked_of(mission, "operator")
    held = [name for _, name, state in mission.walk() if state.control == "operator"]
    transitions = {edge.place for edge in picture.edges for each in asked if edge.source == each.state and edge.option}
    answers = [
        item(f"{each.state}: “{each.asked.question}” – {', '.join(each.asked.options)}", state=each.state)
        for each in asked
    ]
    commands = [
        item("pause and resume: timers keep the time left, goals are canceled and started again, events wait"),
        item(canceled(mission), state=mission.on_cancel or ""),
        item("e-stop: acts at once, before it is written down; the mission ends aborted"),
        item("take and return control; only an operator lifts control from no one"),
    ]
    return lens(
        "operator",
        "What may the operator do?",
        "o",
        label="Operator",
        states=[each.state for each in asked] + held + ([mission.on_cancel] if mission.on_cancel else []),
        transitions=transitions,
        options=[place for each in asked for place in each.options()],
        sections=[
            ("Questions that an operator may answer", answers or [item("none: no decision asks the operator")]),
            ("States that the operator controls", [item(name, state=name) for name in held] or [item("none")]),
            ("At any time", commands),
        ],
    )


def _stops_lens(mission: Mission, picture: Picture, roads: Roads) -> Json:
    ends = [name for name, state in roads.finals.items() if state.final != "succeeded"]
    after = roads.onward([mission.on_cancel]) if mission.on_cancel else None
    moving = [name for _, name, state in mission.walk() if _moves(state)]
    to_ends = [edge for edge in picture.edges if edge.target in ends]
    cancel = [item(canceled(mission), state=mission.on_cancel or "")]
    if after is not None:
        finals = [name for name in roads.states if name in after.states and roads.states[name].word == "final"]
        cancel.append(item(f"from there it may reach {', '.join(finals) or 'no final'}"))
    return lens(
        "stops",
        "Where do e-stop and cancel lead?",
        "e",
        label="E-stop, cancel",
        focus=[*([mission.on_cancel] if mission.on_cancel else []), *ends],
        states=[*ends, *moving, *(after.states if after else ())],
        transitions=[*(edge.place for edge in to_ends), *(after.transitions if after else ())],
        sections=[
            (
                "E-stop",
                [
                    item(
                        "from every state, at once: whatever runs is canceled, control goes to no one, it ends aborted"
                    ),
                    item("an invariant that is false does the same"),
                ],
            ),
            ("Cancel", cancel),
            (
                "Transitions that end the mission otherwise than succeeded",
                [
                    item(
                        f"{edge.source or 'every state'} → {edge.target}: {edge.when} {edge.guard}",
                        transition=edge.place,
                    )
                    for edge in to_ends
                ]
                or [item("none")],
            ),
            ("States with something to be canceled", [item(name, state=name) for name in dict.fromkeys(moving)]),
        ],
    )


def _invariants_lens(mission: Mission, picture: Picture, roads: Roads) -> Json:
    sections, states, transitions = [], set[str](), set[str]()
    for name, guard in mission.invariants.items():
        named = {state for part in guard.walk() for state in part.states()}
        inside = {state for state in roads.states if state in named or named & set(roads.above(state))}
        into = [edge for edge in picture.edges if edge.target in inside and edge.source not in inside]
        states |= inside
        transitions |= {edge.place for edge in into}
        items = [item(f"never false: {guard.words()}")]
        items += [item(f"speaks of '{state}'", state=state) for state in sorted(named)]
        items += [
            item(f"entered by {edge.source or 'every state'}: {edge.when}", transition=edge.place) for edge in into
        ]
        sections.append((name, items))
    none = [("Invariants", [item("none: nothing ends this mission at once but the e-stop")])]
    return lens(
        "invariants",
        "What must never be false?",
        "i",
        label="Invariants",
        states=states,
        transitions=transitions,
        sections=sections or none,
    )


def _moves(state: State) -> bool:
    """Whether it has the robot do something that can be canceled."""
    named = (each.refers.sort for thing in (state, *state.nodes().values()) for each in thing.references())
    return not {"action", "service"}.isdisjoint(named)


def item(text: str, *, state: str = "", transition: str = "") -> Json:
    """A sentence, and what it is about where that can be shown."""
    return {"text": text} | ({"state": state} if state else {}) | ({"transition": transition} if transition else {})


def lens(
    name: str,
    title: str,
    key: str,
    *,
    label: str,
    states: Iterable[str],
    transitions: Iterable[str],
    options: Iterable[str] = (),
    sections: Iterable[tuple[str, list[Json]]] = (),
    focus: Iterable[str] | None = None,
) -> Json:
    """A switch of the page.

    Args:
        name: What links name it.
        title: The question that it answers.
        key: The key that turns it.
        label: The question in a word or two, as the switch has it.
        states: The names of those that stay lit.
        transitions: The JSON pointers of those that stay lit.
        options: The JSON pointers of those that stay lit.
        sections: Heading and sentences, for next to the picture.
        focus: The states that the window moves to, the most important first; left out, all that stay lit.
    """
    lit = sorted(set(states))
    return {
        "name": name,
        "title": title,
        "key": key,
        "label": label,
        "focus": list(dict.fromkeys(focus)) if focus is not None else lit,
        "states": lit,
        "transitions": sorted(set(transitions)),
        "options": sorted(set(options)),
        "sections": [{"heading": heading, "items": items} for heading, items in sections],
    }


def _model_lens(mission: Mission, picture: Picture, roads: Roads) -> Json:
    """The switch that dims all that no model decides."""
    asked = asked_of(mission, "agent")
    sections, transitions, direct = [], set[str](), set[str]()
    for each in asked:
        edges = [edge for edge in picture.edges if edge.source == each.state and (edge.option or each.in_tree)]
        transitions |= {edge.place for edge in edges}
        direct |= {edge.target for edge in edges if edge.target}
        sections.append((f"{each.state}: “{each.asked.question}”", list(_decision_items(each, edges, roads))))
    after = roads.onward(direct)
    at_once = roads.at_once(direct)
    ends = [item(_end_words(name, state, direct, at_once, after), state=name) for name, state in roads.finals.items()]
    sections.append(("Ends", [*ends, *_success_words(roads, at_once)]))
    none = [("Decisions", [item("none: no model is asked anything in this mission")])]
    states = [*(each.state for each in asked), *direct, *(name for name in roads.finals if name in after.states)]
    return lens(
        "model",
        "Where does the model decide?",
        "m",
        label="Model",
        focus=[*(each.state for each in asked), *sorted(direct)],
        states=states if asked else (),
        transitions=transitions,
        options=[place for each in asked for place in each.options()],
        sections=sections if asked else none,
    )


def _decision_items(each: DecisionSite, edges: list[PictureEdge], roads: Roads) -> Iterator[Json]:
    asked = each.asked
    often = f"{asked.attempts} attempts" if asked.attempts > 1 else "1 attempt"
    yield item(silence(each, roads), state=each.state)
    yield item(f"bounded: {asked_in_turn(asked)}, {often} each, {_within(asked)}", state=each.state)
    for name, option in asked.options.items():
        fired = [edge for edge in edges if edge.option == name]
        to = [edge.target for edge in fired if edge.target]
        leads = f"leads to {', '.join(to)}" if to else "continues in its tree" if each.in_tree else "does not leave"
        if fired:
            yield item(f"{name}: {bound(option)}; {leads}{_ends_after(to, roads)}", transition=fired[0].place)
        else:
            yield item(f"{name}: {bound(option)}; {leads}", state=each.state)


def _within(asked: DecisionSpec) -> str:
    """How long it takes at the most, and how that is split among those who are asked."""
    most = f"at most {asked.deadline_s:g} s" if asked.deadline_s is not None else "no deadline"
    if asked.within_s is not None:
        return f"{most}, {asked.within_s:g} s at most for an attempt"
    if asked.deadline_s is None or len(asked.ask) == 1:
        return most
    share = asked.deadline_s / len(asked.ask)
    shares = ", ".join(
        f"{share:.3g} s{'' if index else ' of these'} for {answerer_words(who)}" for index, who in enumerate(asked.ask)
    )
    return f"{most}, {shares}; an attempt has an equal share of the time that is left by then"


def _success_words(roads: Roads, at_once: frozenset[str]) -> list[Json]:
    words = ["no answer sets the state"]
    for name, state in roads.finals.items():
        if name in at_once and state.final == "succeeded":
            held = f"where {state.requires.words()} already holds, " if state.requires is not None else ""
            words.append(f"{held}the answer ends the mission as succeeded, in '{name}'")
    return (
        [item(each) for each in words] if words[1:] else [item(f"{words[0]}, and none alone makes a mission succeed")]
    )


def _ends_after(targets: list[str], roads: Roads) -> str:
    if targets and all(name in roads.finals for name in targets):
        return ", which ends the mission"
    after = roads.onward(targets).states
    missed = [name for name in roads.finals if name not in after]
    if not targets or not missed:
        return ""
    return f"; from there never {', '.join(missed)}"


def _end_words(name: str, state: Final, direct: set[str], at_once: frozenset[str], after: ReachableParts) -> str:
    facts = f", and only if {state.requires.words()}" if state.requires is not None else ""
    if name in at_once:
        behind = "" if name in direct else " where the transitions behind it hold already"
        return f"{name} ({state.final}): an answer leads there at once{behind}{facts}"
    if name in after.states:
        needed = "an event, what the robot reports, or time that passes must lead there"
        return f"{name} ({state.final}): not by an answer alone: {needed}{facts}"
    return f"{name} ({state.final}): out of reach of every answer"
