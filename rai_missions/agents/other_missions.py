# SPDX-License-Identifier: Apache-2.0
"""Which other missions command the same robot: each program reports what its run commands, and compares.

Rule: it finds and names; what becomes of the two missions is for a person to decide.
"""

from __future__ import annotations

import json
import threading
from collections import deque
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from rai_missions.errors import DefinitionError
from rai_missions.mission.json_reader import parse_json
from rai_missions.redaction import cut

__all__ = ("RUNS_TOPIC", "OtherMissions", "RunClaim", "warning_of")

RUNS_TOPIC = "/rai_missions/runs"
"""Where every program reports its run, once a second."""
FORGET_S = 5.0
"""A run of which nothing was received for so long, in seconds, is over."""
MOST, LONGEST, NAMED = 64, 200, 4
"""Runs that are known at a time, and pairs that were named; characters of a text of others; names in a sentence."""


class RunClaim(NamedTuple):
    """What a run commands while it lasts."""

    instance: str
    """Of the program."""
    node: str
    """Its full name; empty for a program without a node."""
    mission: str
    run: str
    commands: frozenset[str] = frozenset()
    """Full names of actions, services and topics; empty while no mission is under way."""

    def text(self) -> str:
        """As it is published."""
        return json.dumps(self._asdict() | {"commands": sorted(self.commands)})


class OtherMissions:
    """The runs of other programs, as far as they have reported."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._seen: dict[str, tuple[RunClaim, float]] = {}
        self._named: deque[tuple[str, str, str]] = deque(maxlen=MOST)
        """What was named last: the own run, the other's instance and its run."""

    def receive(self, text: str, at: float) -> None:
        """A program has reported its run.

        Args:
            text: What was published; anything else is left out.
            at: Seconds on the clock of `rivals`.
        """
        try:
            claim = _claim_in(parse_json(text.encode("utf-8", "replace")))
        except DefinitionError:
            return
        with self._lock:
            if claim is not None and (claim.instance in self._seen or len(self._seen) < MOST):
                self._seen[claim.instance] = claim, at

    def rivals(self, own: RunClaim, at: float) -> tuple[RunClaim, ...]:
        """The others that command what this run commands; `commands` of each has only what both do.

        Args:
            own: What this program publishes.
            at: Seconds on the clock of `receive`.
        """
        with self._lock:
            self._seen = {name: seen for name, seen in self._seen.items() if at - seen[1] < FORGET_S}
            others = [claim for claim, _ in self._seen.values() if claim.instance != own.instance]
        common = (each._replace(commands=each.commands & own.commands) for each in others)
        return tuple(sorted(each for each in common if each.commands))

    def news(self, own: RunClaim, rivals: Iterable[RunClaim]) -> tuple[RunClaim, ...]:
        """The rivals that this run has not named yet; they count as named now."""
        pairs = {(own.run, each.instance, each.run): each for each in rivals}
        new = [pair for pair in pairs if pair not in self._named]
        self._named.extend(new)
        return tuple(pairs[pair] for pair in new)


def warning_of(rival: RunClaim) -> str:
    """The sentence that names another mission and what both command."""
    names = sorted(rival.commands)
    left = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    who = f"the node {rival.node}" if rival.node else "a program without a node"
    return (
        f"{who} commands the same robot (mission {rival.mission}, run {rival.run}): "
        f"{', '.join(names[:NAMED])}{left}; cancel one of the two missions"
    )


def _claim_in(found: Any) -> RunClaim | None:
    if not isinstance(found, Mapping) or not isinstance(found.get("commands"), list):
        return None
    instance, node, mission, run = (
        cut(found.get(name, ""), LONGEST) for name in ("instance", "node", "mission", "run")
    )
    commands = frozenset(cut(each, LONGEST) for each in found["commands"] if isinstance(each, str))
    return RunClaim(instance, node, mission, run, commands)
