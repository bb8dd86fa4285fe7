# SPDX-License-Identifier: Apache-2.0
"""From a mission, and the steps of a run, to what is drawn.

Rule: the edges of a picture are exactly the mission's transitions, each once for each of its targets; none is left out.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping

from rai_missions.engine.step import Move, Step, step_count
from rai_missions.mission.mission import Mission, given_mission
from rai_missions.states import Compound, Each, Final, History, State
from rai_missions.states.state import descendants
from rai_missions.states.transition import Transition
from visualize.model import Initial, Path, Picture, PictureEdge, PictureNode
from visualize.text import choices, effects, trigger, twigs

__all__ = ("parents_of", "picture")


class _Run:
    """Where a run went, by the number of its steps."""

    def __init__(self, steps: Iterable[Step]) -> None:
        self.transitions: dict[str, list[int]] = defaultdict(list)
        self.states: dict[str, list[int]] = defaultdict(list)
        self.entries: list[tuple[int, Move]] = []
        """The moves that entered something."""
        self.last: set[str] = set()
        """The states that were active when the mission ended, or are now."""
        self.outcome, self.why = "", ""
        steps = tuple(steps)
        self.steps = step_count(steps)
        for step in steps:
            self._add(step)

    def _add(self, step: Step) -> None:
        if step.outcome is not None and not self.outcome:
            self.outcome, self.why = step.outcome, step.why
        for move in step.moves:
            for place in move.taken:
                self.transitions[place].append(step.seq)
            for name in move.entered:
                self.states[name].append(step.seq)
            if move.entered:
                self.entries.append((step.seq, move))
            self.last = self.last - set(move.exited) | set(move.entered) or self.last

    def begun(self, parent: str, target: str, inside: frozenset[str], targets: Mapping[str, tuple[str, ...]]) -> Path:
        """When a parent was entered so that it began with its initial state."""
        if not parent:
            return Path(tuple(number for number, move in self.entries[:1] if target in move.entered))
        return Path(
            tuple(
                number
                for number, move in self.entries
                if target in move.entered
                and (parent in move.entered or not move.taken)
                and not any(to in inside for place in move.taken for to in targets.get(place, ()))
            )
        )


def picture(mission: Mission, steps: Iterable[Step] = ()) -> Picture:
    """What is drawn of a mission.

    Args:
        mission: The graph.
        steps: Of a run, or of a journal, in order: they are counted on the states and transitions of their path.

    Raises:
        UsageError: It is no mission.
    """
    given_mission(mission, "a picture")
    parents = parents_of(mission)
    run = _Run(steps)
    ended = run.last - {parents.get(name, "") for name in run.last}
    edges = [
        edge for place, name, state in mission.walk() for edge in _edges(place, name, state.transitions, state, run)
    ]
    return Picture(
        name=mission.name,
        version=mission.version,
        about=mission.about,
        nodes=tuple(_node(place, name, state, parents, run, ended) for place, name, state in mission.walk()),
        edges=(*edges, *_edges("", "", mission.transitions, None, run)),
        initials=tuple(_initials(mission, run)),
        invariants=tuple((name, guard.words()) for name, guard in mission.invariants.items()),
        steps=run.steps,
        outcome=run.outcome,
        why=run.why,
    )


def parents_of(mission: Mission) -> dict[str, str]:
    """State → the state around it, empty at the top. Of two with one name the first counts: none is inside itself."""
    found = dict.fromkeys(mission.states, "")
    for _, name, state in mission.walk():
        for child in state.children():
            found.setdefault(child, name)
    return found


def _node(place: str, name: str, state: State, parents: dict[str, str], run: _Run, ended: set[str]) -> PictureNode:
    parent = parents.get(name, "")
    asked = state.decisions().get("")
    return PictureNode(
        name=name,
        place=place,
        kind=state.word,
        parent=parent,
        region=place.rpartition("/")[0].endswith("/parallel"),
        title=state.title(),
        lines=tuple(state.lines()),
        about=state.about,
        control=state.control or "",
        outcome=state.final if isinstance(state, Final) else state.history if isinstance(state, History) else "",
        choices=choices(asked, f"{place}/decision") if asked else (),
        fallback=(asked.fallback or "") if asked else "",
        twigs=tuple(twigs(state, place)),
        entered=Path(tuple(run.states.get(name, ()))),
        ended_here=name in ended,
    )


def _edges(
    place: str, source: str, transitions: tuple[Transition, ...], state: State | None, run: _Run
) -> Iterator[PictureEdge]:
    options = state.options if state is not None else {}
    for index, transition in enumerate(transitions):
        here = f"{place}/transitions/{index}"
        for target in transition.to or ("",):
            yield PictureEdge(
                place=here,
                source=source,
                target=target,
                trigger=trigger(transition),
                guard=transition.when.words() if transition.when is not None else "",
                do=effects(transition.do),
                internal=transition.internal,
                about=transition.about,
                option=transition.on[0]
                if len(transition.on) == 1 and transition.on[0] in options and transition.of is None
                else "",
                taken=Path(tuple(run.transitions.get(here, ()))),
            )


def _initials(mission: Mission, run: _Run) -> Iterator[Initial]:
    targets = {place: transition.to for place, transition in mission.every_transition()}
    for target in mission.initial:
        yield Initial("", target, run.begun("", target, frozenset(), targets))
    for _, name, state in mission.walk():
        if isinstance(state, Compound | Each):
            inside = frozenset(inner for _, inner, _ in descendants(state.children()))
            for target in state.initial:
                yield Initial(name, target, run.begun(name, target, inside, targets))
