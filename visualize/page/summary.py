# SPDX-License-Identifier: Apache-2.0
"""A mission in the time that a reader has at first: what it is for, where a model is asked, and how it may end.

Rule: each sentence follows from the mission by a rule; nothing is guessed, and every place that it names is in the
chart. What is empty here, such as an end that nothing leads to, is shown as that.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import NamedTuple, get_args

from rai_missions.mission.mission import Mission
from rai_missions.states import Final, History, Transition
from rai_missions.states.final import FinalOutcome
from rai_missions.states.state import OUTCOMES
from visualize.page.decision_sites import (
    DecisionSite,
    asked_in_turn,
    bound,
    fired,
    leads,
    questions,
    silence,
    unanswered,
)
from visualize.page.reachability import Roads
from visualize.text import canceled, controlled, effects, trigger

__all__ = ("DecisionSummary", "EndSummary", "Fact", "InvariantSummary", "MissionSummary", "OptionSummary", "summary")

BEFORE = 6
"""Transitions into the state before an end that are given one by one."""
INTERRUPTIONS = (
    "e-stop, or an invariant that is false: everything is canceled at once, control is with no one, it ends aborted",
    "an outcome other than succeeded that no transition waits for: it ends failed",
)


class Fact(NamedTuple):
    """A sentence, and the place in the chart where it can be checked."""

    text: str
    transition: str = ""
    """JSON pointer; empty for none."""
    state: str = ""


class InvariantSummary(NamedTuple):
    """What must never be false."""

    name: str
    guard: str


class OptionSummary(NamedTuple):
    """An answer, when it may be given, and where it leads."""

    name: str
    about: str
    bound: str
    """`only when obstacle.living is false`, or `always open`."""
    leads: str
    """`crossing`, `given_up (aborted)`."""
    transition: str = ""


class DecisionSummary(NamedTuple):
    """A question: who is asked, what may be answered, and what happens without an answer."""

    state: str
    question: str
    by_model: bool
    asked: str
    """`asks the model, then the operator; 2 attempts each`."""
    silence: str
    """`no valid answer within 20 s: abort → given_up (aborted)`."""
    options: tuple[OptionSummary, ...]


class EndSummary(NamedTuple):
    """An end of the mission."""

    state: str
    outcome: str
    about: str
    causes: tuple[Fact, ...]
    before: tuple[Fact, ...]
    """What leads to the states from which the end is reached, where one acts on its own before."""
    does: tuple[str, ...]
    """Its effects: `call halt`."""
    proof: tuple[str, ...]
    """What the robot must report before the end counts."""
    by_answer: bool
    """An answer alone may lead there at once."""


class MissionSummary(NamedTuple):
    """What a reader should know first."""

    purpose: str
    asked: str
    """Where a model is asked, in a sentence."""
    invariants: tuple[InvariantSummary, ...]
    decisions: tuple[DecisionSummary, ...]
    outcomes: tuple[str, ...]
    """The ends of each outcome in a line: `failed: stranded, unfinished_home`."""
    ends: tuple[EndSummary, ...]
    interruptions: tuple[str, ...]
    """What ends the mission from any state, without a transition."""
    controllers: tuple[Fact, ...]
    """Who commands the actuators, and in which states."""
    words: tuple[str, ...]
    """The words to explain: `model`, `rules` where they are asked, `mission` where it commands the actuators."""


class _Edge(NamedTuple):
    """A transition with the state whose it is; empty for the mission's own."""

    source: str
    place: str
    transition: Transition


def summary(mission: Mission) -> MissionSummary:
    """The mission, shortly."""
    return _Reader(mission).summary()


class _Reader:
    """What the parts of a summary look up."""

    def __init__(self, mission: Mission) -> None:
        self.mission, self.roads = mission, Roads(mission)
        self.into: dict[str, list[_Edge]] = defaultdict(list)
        for source, transitions in self.roads.transitions.items():
            for place, transition in transitions:
                for target in dict.fromkeys(transition.to):
                    self.into[target].append(_Edge(source, place, transition))

    def summary(self) -> MissionSummary:
        mission, sites = self.mission, [*questions(self.mission)]
        answered = {target for site in sites if "agent" in site.asked.ask for target in self._answers(site)}
        at_once = self.roads.at_once(answered)
        used = {
            "model": any("agent" in site.asked.ask for site in sites),
            "rules": any("rules" in site.asked.ask for site in sites),
            "mission": any(state.control == "agent" for _, _, state in mission.walk()),
        }
        return MissionSummary(
            purpose=mission.about or "What this mission is for is not written: give it an 'about'.",
            asked=self._asked(sites),
            invariants=tuple(InvariantSummary(name, guard.words()) for name, guard in mission.invariants.items()),
            decisions=tuple(map(self._decision, sites)),
            outcomes=tuple(_outcome_lines(self.roads)),
            ends=tuple(
                self._end(name, state, by_answer=name in answered or (name in at_once and self._behind(name, at_once)))
                for name, state in self.roads.finals.items()
            ),
            interruptions=(*INTERRUPTIONS, canceled(mission)),
            controllers=tuple(_controllers(mission)),
            words=tuple(word for word, is_used in used.items() if is_used),
        )

    def _asked(self, sites: list[DecisionSite]) -> str:
        by_model = list(dict.fromkeys(site.state for site in sites if "agent" in site.asked.ask))
        if not by_model:
            return "No model is asked anything in this mission."
        entered = sum(not isinstance(state, History) for state in self.roads.states.values())
        where = f"{len(by_model)} of {entered} states"
        return (
            f"A model is asked in {where}: {', '.join(by_model)}. It proposes an option there; the mission judges it."
        )

    # -- decisions ------------------------------------------------------------------------------------------------

    def _decision(self, site: DecisionSite) -> DecisionSummary:
        asked = site.asked
        often = f"; {asked.attempts} attempts each" if asked.attempts > 1 else ""
        return DecisionSummary(
            state=site.state,
            question=asked.question,
            by_model="agent" in asked.ask,
            asked=f"{asked_in_turn(asked)}{often}",
            silence=silence(site, self.roads),
            options=tuple(
                OptionSummary(
                    name,
                    option.about,
                    bound(option),
                    leads(name, site, self.roads),
                    next((place for place, _ in fired(name, site, self.roads)), ""),
                )
                for name, option in asked.options.items()
            ),
        )

    def _answers(self, site: DecisionSite) -> Iterator[str]:
        """Where an answer leads at once."""
        for _, each in self.roads.transitions[site.state]:
            if site.in_tree or (each.of is None and not site.asked.options.keys().isdisjoint(each.on)):
                yield from each.to

    def _behind(self, name: str, entered: frozenset[str]) -> bool:
        """Whether a transition of a state that was entered leads to an end, and not only one tried from everywhere."""
        return any(edge.source in entered for edge in self.into[name])

    # -- ends -----------------------------------------------------------------------------------------------------

    def _end(self, name: str, state: Final, *, by_answer: bool) -> EndSummary:
        into = self.into[name]
        causes = [Fact("the mission begins here", state=name)] if name in self.mission.initial else []
        causes += [Fact(self._cause(edge), edge.place) for edge in into]
        causes += [Fact("a cancel leads here", state=name)] if name == self.mission.on_cancel else []
        return EndSummary(
            state=name,
            outcome=state.final,
            about=state.about,
            causes=tuple(causes),
            before=tuple(self._before(into)),
            does=effects(state.entry),
            proof=tuple(dict.fromkeys(self._proof(state, into))),
            by_answer=by_answer,
        )

    def _before(self, into: list[_Edge]) -> Iterator[Fact]:
        """What leads to the states that an end is entered from, but for decisions, which are explained themselves."""
        sources = dict.fromkeys(edge.source for edge in into if edge.source)
        found = [(name, edge) for name in sources if not self.roads.states[name].options for edge in self.into[name]]
        for name, edge in found[:BEFORE]:
            yield Fact(f"{name} ← {self._cause(edge)}", edge.place)
        if len(found) > BEFORE:
            yield Fact(f"and {len(found) - BEFORE} more transitions")

    def _cause(self, edge: _Edge) -> str:
        """What takes a transition, in a sentence: `returning: go_home succeeded, and unfinished is true`."""
        source, transition = self.roads.states.get(edge.source), edge.transition
        guard = transition.when.words() if transition.when is not None else ""
        where, words = edge.source or "from any state", trigger(transition)
        if not words:
            return f"{where}: as soon as {guard}" if guard else f"{where}: at once"
        if source is not None and transition.of is None and not source.options.keys().isdisjoint(transition.on):
            asked = source.question()
            silent = asked is not None and asked.fallback in transition.on
            words = f"answered {words}" + (f", or {unanswered(asked)}" if asked is not None and silent else "")
        elif source is not None and transition.of is None and _outcomes(transition):
            words = f"{source.title()} {words}".strip()
        elif transition.after_s is None and not _outcomes(transition):
            words = f"event {words}"
        return f"{where}: {words}" + (f", and {guard}" if guard else ", in other cases" if self._is_rest(edge) else "")

    def _is_rest(self, edge: _Edge) -> bool:
        """Whether a transition before it waits for the same, with a guard."""
        for place, each in self.roads.transitions[edge.source]:
            if place == edge.place:
                return False
            if each.when is not None and not set(each.on).isdisjoint(edge.transition.on):
                return True
        return False

    def _proof(self, state: Final, into: list[_Edge]) -> Iterator[str]:
        """What the robot must report: of the end itself, and before a success that leads to it is believed."""
        if state.requires is not None:
            yield f"requires {state.requires.words()}; else it ends failed"
        for edge in into:
            source, by_success = self.roads.states.get(edge.source), edge.transition.on == ("succeeded",)
            if source is not None and by_success and edge.transition.of is None and source.proof():
                yield source.proof()


def _outcomes(transition: Transition) -> bool:
    """Whether it waits for outcomes alone."""
    return bool(transition.on) and set(transition.on) <= set(OUTCOMES)


def _outcome_lines(roads: Roads) -> Iterator[str]:
    found: dict[str, list[str]] = {}
    for name, state in roads.finals.items():
        found.setdefault(state.final, []).append(name)
    for outcome in sorted(found, key=get_args(FinalOutcome).index):
        yield f"{outcome}: {', '.join(found[outcome])}"


def _controllers(mission: Mission) -> Iterator[Fact]:
    """Each who is named by `control`, and where."""
    found: dict[str, list[str]] = {}
    for _, name, state in mission.walk():
        if state.control:
            found.setdefault(state.control, []).append(name)
    for holder, names in found.items():
        yield Fact(f"{controlled(holder)}: {', '.join(names)}", state=names[0])
