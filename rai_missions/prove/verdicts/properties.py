# SPDX-License-Identifier: Apache-2.0
"""What is claimed of a mission, and what its states show: proved, refuted, or as far as was looked.

Rule: only what was explored whole is called proved; a refutation is valid wherever the exploration ended.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, NamedTuple

from rai_missions.mission.mission import Mission
from rai_missions.prove.exploration.explorer import Edge, Space
from rai_missions.prove.verdicts.circles import circling

__all__ = ("CLAIMS", "ClaimVerdict", "Property", "claims", "lost", "stuck")

ClaimVerdict = Literal["proved", "refuted", "explored"]
CLAIMS = {
    "ends": "from every state the mission can still end",
    "comes to rest": "no run goes round for ever by itself",
    "invariants": "every invariant holds in every state, without the run-time backstop",
    "answers": "no answer alone makes the mission succeed",
    "options": "every option and every fallback can be taken",
    "rules": "each 'requires', 'achieved' and option guard can be true, and each option guard can be false",
    "stop": "an e-stop ends the mission in every state",
    "cancel": "a cancel ends the mission from every state",
    "stopped": "every action that was started is ended with the mission",
}


class Property(NamedTuple):
    """One claim and its verdict."""

    name: str
    verdict: ClaimVerdict
    sentence: str = ""
    """What refutes it."""
    state: int = -1
    """The state in which it is refuted; -1 is before the start."""
    way: Edge | None = None
    """What happens there to refute it."""

    @property
    def words(self) -> str:
        """What is claimed."""
        return CLAIMS[self.name]

    @property
    def has_run(self) -> bool:
        """A single run shows that it is refuted."""
        return self.verdict == "refuted" and (self.state >= 0 or self.way is not None)


def claims(mission: Mission, space: Space, *, is_sampled: bool = False) -> list[Property]:
    """What the states that were explored show of each claim.

    Args:
        mission: The mission.
        space: What was explored of it.
        is_sampled: Not every value that guards distinguish was tried.
    """
    found = {
        each.promise: Property(each.promise, "refuted", each.sentence, each.state, each.way)
        for each in space.findings.flaws.values()
    }
    is_whole = space.is_whole and not is_sampled
    for claim in (
        *_ends(space),
        *_rests(space),
        *(_options(mission, space) if is_whole else ()),
        *(_rules(space) if is_whole else ()),
    ):
        found.setdefault(claim.name, claim)
    rest: ClaimVerdict = "proved" if is_whole else "explored"
    return [found.get(name) or Property(name, rest) for name in CLAIMS]


def stuck(space: Space) -> list[int]:
    """The states from which nothing leads to an end."""
    far = space.distances([*space.ends, *space.unfinished])
    return [number for number in range(space.states) if far[number] < 0]


def lost(space: Space) -> list[int]:
    """The states from which time alone never leads to an end, or to a state in which the mission waits."""
    if not space.has_time:
        return []
    moving = {source for source, _ in space.edges(time_only=True)}
    resting = [number for number in range(space.states) if number not in moving]
    far = space.distances([*resting, *space.unfinished], time_only=True)
    return [number for number in range(space.states) if far[number] < 0]


def _ends(space: Space) -> Iterator[Property]:
    found = stuck(space)
    if found:
        yield Property("ends", "refuted", "nothing that can happen from here on ends the mission", found[0])
    canceling = [number for number in found if number in space.canceling]
    if canceling:
        yield Property("cancel", "refuted", "the cancel never ends from here on", canceling[0])


def _rests(space: Space) -> Iterator[Property]:
    """By time alone a run comes to an end, or to a state in which it waits for someone."""
    found = lost(space) or circling(space)
    if found:
        yield Property("comes to rest", "refuted", "while nothing is reported, timers lead round for ever", found[0])


def _options(mission: Mission, space: Space) -> Iterator[Property]:
    for owner, options in _asked(mission):
        for option in options:
            if (owner, option) not in space.environment.instruments.answered:
                yield Property("options", "refuted", f"'{option}' of '{owner}' can never be taken")


def _asked(mission: Mission) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Who asks, and what is offered."""
    for _, name, state in mission.walk():
        for part, asked in state.decisions().items():
            yield name + part, tuple(asked.options)


def _rules(space: Space) -> Iterator[Property]:
    for place, values in sorted(space.environment.instruments.seen.items()):
        if not place.endswith(("/requires", "/achieved", "/when")):
            continue
        if True not in values:
            yield Property("rules", "refuted", f"{place} can never be true")
        elif values == {True} and place.endswith("/when"):  # the others are nets, which may never be needed
            yield Property("rules", "refuted", f"{place} is always true where it is asked")
