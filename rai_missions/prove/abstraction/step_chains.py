# SPDX-License-Identifier: Apache-2.0
"""Long ways within a step that another step has gone: a counter is counted up once, not once from each of its values.

Rule: nothing is computed; a step that comes to a place that an earlier step has passed, with everything as it was, is
put forward to the last such place of that step, which differs in the mission's own keys alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.engine.semantics.macrostep import MOST_MICROSTEPS
from rai_missions.engine.state import StepDraft
from rai_missions.engine.step import Move
from rai_missions.guards.view import Truth
from rai_missions.prove.abstraction.activity_key import plain
from rai_missions.prove.abstraction.instruments import Instruments
from rai_missions.prove.abstraction.open_world import OpenWorld
from rai_missions.prove.abstraction.store import fingerprint

__all__ = ("StepChains", "unpolled")

REMEMBERED = 50_000
"""Places within steps that are remembered; past that all are forgotten."""


class StepChain:
    """The places of one step that differ in the mission's own keys alone, in the order in which it passed them."""

    __slots__ = ("guards", "looked", "microsteps", "moves", "own", "seen", "written")

    def __init__(self, draft: StepDraft) -> None:
        self.own: Mapping[str, Any] = {}
        """Own key → its entry in the last place."""
        self.microsteps = 0
        """How many the step had made there."""
        self.looked, self.written = set[str](), set[str]()
        self.moves, self.guards = dict[Move, int](), dict[tuple[str, Truth], int]()
        """Move, and guard with its value → the microsteps at the last place after it."""
        self.seen = len(draft.written), len(draft.moves), len(draft.looked)
        """How many writes, moves and guards of the draft are known."""

    def add(self, own: Mapping[str, Any], looked: set[str], draft: StepDraft) -> None:
        """The step has come to another place."""
        self.own, self.microsteps = own, draft.microsteps
        self.looked |= looked
        writes, moves, guards = self.seen
        self.written.update(key for key, _ in draft.written[writes:])
        self.moves.update(dict.fromkeys(draft.moves[moves:], draft.microsteps))
        self.guards.update(dict.fromkeys(draft.looked[guards:], draft.microsteps))
        self.seen = len(draft.written), len(draft.moves), len(draft.looked)


def unpolled(draft: StepDraft) -> tuple[Any, ...]:
    """What has changed since the activities last looked."""
    keys = sorted({key for key, _ in draft.written[draft.polled :]})
    return keys, sorted(draft.presence_changes), sorted(draft.news.items()), draft.goal_ended


class Link(NamedTuple):
    """A place in a chain."""

    chain: StepChain
    microsteps: int


class StepChains:
    """What steps have passed, and how far they went.

    Args:
        world: What the surroundings can be.
        instruments: Learns at which keys was looked on the ways that are left out.
    """

    def __init__(self, world: OpenWorld, instruments: Instruments) -> None:
        self._world, self._instruments = world, instruments
        self._links: dict[bytes, Link] = {}
        self._here: dict[tuple[str, int], StepChain] = {}
        """The chains of the macrostep in hand: place but for own keys, and how often trees were ticked → chain."""

    def begin(self) -> None:
        """Begin another macrostep."""
        self._here = {}

    def take(self, draft: StepDraft, place: str) -> None:
        """Put the step in hand forward, where an earlier one has passed this place, and remember the place.

        Args:
            draft: What the step has gathered.
            place: All that the next microsteps depend on but the mission's own keys.
        """
        own = self._world.own()
        place = repr((place, unpolled(draft)))
        mark = fingerprint((place, sorted((key, plain(entry[0])) for key, entry in own.items() if entry is not None)))
        chain = self._here.setdefault((place, self._instruments.ticks), StepChain(draft))
        link = self._links.get(mark)
        if link is None:
            if len(self._links) >= REMEMBERED:
                self._links.clear()
            self._links[mark] = Link(chain, draft.microsteps)
        elif link.chain is not chain:
            own = self._put_forward(own, link, draft)
        chain.add(own, self._world.board.looked, draft)

    def _put_forward(self, own: dict[str, Any], link: Link, draft: StepDraft) -> dict[str, Any]:
        """What the own keys hold at the end of a chain; no farther than the limit of microsteps allows."""
        chain, after = link.chain, draft.microsteps + link.chain.microsteps - link.microsteps
        written = chain.written & chain.own.keys()
        if after >= MOST_MICROSTEPS or not written.isdisjoint(self._world.items.shapes):
            return own
        draft.microsteps = after
        draft.moves += [move for move, at in chain.moves.items() if at > link.microsteps]
        draft.looked += [guard for guard, at in chain.guards.items() if at > link.microsteps]
        for key in written:
            self._world.board.put(key, chain.own[key])
        self._instruments.asked.update((chain.looked | chain.written) & self._world.stored)
        self._world.board.looked |= chain.looked
        return self._world.own()
