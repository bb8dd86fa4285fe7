# SPDX-License-Identifier: Apache-2.0
"""Proof: every run of a mission, explored; what is promised of all of them is proved, or refuted by a shortest run."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from rai_missions.journal import Header
from rai_missions.mission import Mission
from rai_missions.prove.claims import CLAIMS, Claim, claims
from rai_missions.prove.free import Free
from rai_missions.prove.space import Space
from rai_missions.prove.witness import Player, Scene, scenes
from rai_missions.states.terms import Terms
from rai_missions.states.ticker import Trees

__all__ = ("CLAIMS", "MOST_STATES", "Claim", "Proof", "Scene", "prove", "record")

MOST_STATES = 1_000_000


class Proof(NamedTuple):
    """What was found out about a mission."""

    claims: tuple[Claim, ...]
    ways: dict[str, list[Scene]]
    """Claim that was refuted → the shortest run to where it is broken, if there is one in which the operator leaves
    the mission alone, then of these; none for what no single run shows."""
    states: int
    steps: int
    depth: int
    """Steps of the longest of the shortest runs to the states."""
    farthest: int
    """So many steps at the most lie between a state and the nearest end."""
    is_whole: bool
    """Every state was explored."""
    assumed: tuple[str, ...]
    """Invariants that speak of the robot alone: they are watched in a run, and were assumed to hold here."""
    in_pause: tuple[str, ...]
    """Invariants that what the robot says can break while the mission is paused, when no rule of it can act."""
    predicates: tuple[str, ...]
    """The user's predicates: each was free to say anything whenever it was asked."""
    sampled: tuple[str, ...]
    """The paths of which some values were tried, though guards can tell more apart: nothing is called proved then."""
    never: tuple[str, ...]
    """States that no run enters; known only where everything was explored."""
    seconds: float

    @property
    def verdict(self) -> str:
        """`refuted` if any claim is, else `proved`, or `explored` where a bound was hit."""
        said = {claim.verdict for claim in self.claims}
        return "refuted" if "refuted" in said else "explored" if "explored" in said else "proved"


def prove(
    mission: Mission, ticker: Trees | None = None, *, terms: Terms | None = None, most: int = MOST_STATES,
    progress: Callable[[int, int], None] = lambda found, done: None,
) -> Proof:  # fmt: skip
    """Explore every run of a mission.

    Values are told apart as far as the mission's guards do; timers run out in any order; named guards are free. The
    operator pauses, resumes, takes control and gives it to anybody. A cancel and an emergency stop are tried in every
    state, those of a pause included.

    Args:
        mission: One that `check` finds no fault in.
        ticker: Who ticks trees; needed where the mission has one.
        terms: What is known of the robot: without a profile all actions exclude each other, and have servers.
        most: States at the most; a kilobyte or two each.
        progress: Told of states found and states done, every thousand states.
    """
    with _few_collections():
        return _prove(mission, ticker, terms, most, progress)


@contextmanager
def _few_collections() -> Iterator[None]:
    """What is explored is kept, and in no circles: looking for garbage in it over and over finds none."""
    before = gc.get_threshold()
    gc.set_threshold(100_000, 50, 1000)
    try:
        yield
    finally:
        gc.set_threshold(*before)


def _prove(
    mission: Mission, ticker: Trees | None, terms: Terms | None, most: int, progress: Callable[[int, int], None]
) -> Proof:
    began = time.perf_counter()
    chart = Free(mission, ticker, terms=terms)
    space = Space(chart, most, progress)
    space.explore()
    sampled = chart.values.learned.sampled
    found = claims(mission, space, is_sampled=bool(sampled))
    ways = {each.name: scenes(space, each) for each in found if each.has_run}
    if ways:
        found, ways = _calmly(found, ways, mission, _calm(mission, ticker, terms, most))
    names = [name for _, name, state in mission.walk() if state.word != "history"]
    return Proof(
        claims=tuple(found), ways=ways, states=space.states, steps=space.steps, depth=space.depth,
        farthest=max(space.distances(space.ends), default=0), is_whole=space.is_whole,
        assumed=tuple(sorted(chart.assumed)), in_pause=tuple(sorted(space.in_pause)),
        predicates=tuple(sorted(chart.predicates)), sampled=sampled,
        never=tuple(name for name in names if name not in space.entered) if space.is_whole else (),
        seconds=time.perf_counter() - began,
    )  # fmt: skip


def _calm(mission: Mission, ticker: Trees | None, terms: Terms | None, most: int) -> Space:
    """What was explored of a mission whose operator leaves it alone."""
    chart = Free(mission, ticker, terms=terms)
    chart.is_calm = True
    space = Space(chart, most)
    space.explore()
    return space


def _calmly(
    found: list[Claim], ways: dict[str, list[Scene]], mission: Mission, calm: Space
) -> tuple[list[Claim], dict[str, list[Scene]]]:
    """Refutations for which the operator is not needed, where there are such: they are the author's first affair."""
    better = {each.name: each for each in claims(mission, calm) if each.has_run and each.name in ways}
    told = {name: scenes(calm, each) for name, each in better.items()}
    return [better.get(each.name, each) for each in found], {**ways, **told}


def record(
    path: Path, header: Header, mission: Mission, told: list[Scene], ticker: Trees | None = None, *,
    terms: Terms | None = None,
) -> bool:  # fmt: skip
    """Have a chart that keeps time do the run of a refutation, into a new journal.

    Returns:
        Whether it comes to the same states, and the same outcome, as was told: an order of timers that their durations
        do not allow shows here.

    Raises:
        UsageError: The file is there already, or none can be written there.
    """
    return Player(mission, ticker, terms).record(path, header, told)
