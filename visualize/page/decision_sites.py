# SPDX-License-Identifier: Apache-2.0
"""Where a mission asks, whom, and what follows: with an answer, and without one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rai_missions.mission.mission import Mission
from rai_missions.states import DecisionSpec, Final, Option, Transition, answerer_words
from rai_missions.states.state import OUTCOMES
from visualize.page.reachability import Roads
from visualize.text import child_pointer

__all__ = ("DecisionSite", "asked_in_turn", "asked_of", "bound", "fired", "leads", "questions", "silence", "unanswered")


class DecisionSite(NamedTuple):
    """A question where it is."""

    state: str
    place: str
    """JSON pointer of what holds the question."""
    asked: DecisionSpec
    owner: str
    """As its questions name it: the state, or `state#path` in a tree."""

    @property
    def in_tree(self) -> bool:
        """A tree asks it, and continues by itself."""
        return "#" in self.owner

    def options(self) -> list[str]:
        """The JSON pointers of its options."""
        return [child_pointer(f"{self.place}/decision", "options", name) for name in self.asked.options]


def asked_of(mission: Mission, who: str) -> list[DecisionSite]:
    """The questions that someone is asked, in document order."""
    return [each for each in questions(mission) if who in each.asked.ask]


def questions(mission: Mission) -> Iterator[DecisionSite]:
    """Every question of a mission, in document order."""
    for place, name, state in mission.walk():
        for part, asked in state.decisions().items():
            yield DecisionSite(name, place + state.within(part), asked, name + part)


def fired(outcome: str, site: DecisionSite, roads: Roads) -> list[tuple[str, Transition]]:
    """The transitions of its state, with their JSON pointers, that an outcome of a question fires."""
    own = roads.transitions[site.state]
    return [(place, each) for place, each in own if outcome in each.on and each.of is None and not site.in_tree]


def leads(outcome: str, site: DecisionSite, roads: Roads) -> str:
    """Where an option, or the failure of a question, leads: `crossing`, `given_up (aborted)`."""
    if site.in_tree:
        return "continues in its tree"
    found = [target for _, each in fired(outcome, site, roads) for target in each.to or (site.state,)]
    if found:
        return " or ".join(_named(name, roads.mission) for name in dict.fromkeys(found))
    return "what the states around do" if outcome in OUTCOMES else "does not leave the state"


def silence(site: DecisionSite, roads: Roads) -> str:
    """What happens without an answer that counts: `no valid answer within 20 s: abort → given_up (aborted)`."""
    outcome = site.asked.fallback or "failed"
    return f"{unanswered(site.asked)}: {outcome} → {leads(outcome, site, roads)}"


def asked_in_turn(asked: DecisionSpec) -> str:
    """Who is asked: `asks the model, then the operator`."""
    return f"asks {', then '.join(map(answerer_words, asked.ask))}"


def bound(option: Option) -> str:
    """When an option is offered: `only when obstacle.living is false`, or `always open`."""
    return f"only when {option.when.words()}" if option.when is not None else "always open"


def unanswered(asked: DecisionSpec) -> str:
    """The words for no valid answer, and within which time."""
    return "no valid answer" + (f" within {asked.deadline_s:g} s" if asked.deadline_s is not None else "")


def _named(name: str, mission: Mission) -> str:
    """A state, with its outcome where it ends the mission."""
    state = mission.states.get(name)
    return f"{name} ({state.final})" if isinstance(state, Final) else name
