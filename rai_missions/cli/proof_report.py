# SPDX-License-Identifier: Apache-2.0
"""What `rai-missions prove` prints and writes: verdicts, the runs that refute a claim, and the limits of a proof."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.cli.long_work import WorkPace
from rai_missions.errors import ConnectorError, UsageError, counted
from rai_missions.event import Event
from rai_missions.mission.files import journal_text
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import plain
from rai_missions.prove import MOST_STATES, Proof, record

if TYPE_CHECKING:
    from rai_missions.profile import Robot

__all__ = ("as_json", "how_far", "limits_of", "report", "write_journals")

FIELDS = (
    "states", "steps", "depth", "farthest", "is_whole", "stopped", "varieties", "done", "assumed", "in_pause",
    "predicates", "sampled", "alike", "never", "seconds",
)  # fmt: skip
"""What the JSON object holds of a proof."""
WIDTH = 14
MOST_KEYS = 4
"""How many of the keys that multiply the states are named."""


def limits_of(states: int | None, seconds: float, memory_mb: float) -> dict[str, Any]:
    """What the exploration may cost.

    Raises:
        UsageError: A limit is not above 0.
    """
    most = MOST_STATES if states is None else states
    if most < 1:
        raise UsageError(f"{most} states are none; give --states a number above 0")
    if not seconds > 0:
        raise UsageError(f"{seconds:g} seconds are none; give --max-seconds a number above 0")
    if not memory_mb > 0:
        raise UsageError(f"{memory_mb:g} MiB are none; give --max-memory a number above 0")
    return {"most": most, "seconds": seconds, "memory_mb": memory_mb}


def how_far(pace: WorkPace) -> str:
    """How far an exploration is: `3,194 states found, 1,000 of them explored, 2,194 left, 950 states/s`."""
    if not pace.total:
        return f"exploring, {pace.elapsed_s:.0f} s"
    left = pace.total - pace.done
    return f"{pace.total:,} states found, {pace.done:,} of them explored, {left:,} left, {pace.rate:,.0f} states/s"


def write_journals(proof: Proof, mission: Mission, robot: Robot | None, output: str | None) -> dict[str, Any]:
    """Claim that was refuted → the journal of the run that refutes it, and whether it shows there too.

    A journal that cannot be written takes no proof away: it is None, and `unwritten` has the reason.

    Args:
        proof: What was found.
        mission: The mission.
        robot: Its profile.
        output: The file to write; without it, one is named for the mission and the claim.
    """
    written: dict[str, Any] = {}
    profile, facts = "", None
    if not proof.ways:
        return written
    from rai_missions.journal import Header  # it takes 9 ms, and a proof without a refutation does without

    if robot is not None:
        from rai_missions.profile import dump_profile, robot_facts  # few proofs need it, and it takes 20 ms

        profile, facts = dump_profile(robot), robot_facts(robot)
    for name, trace in proof.ways.items():
        arguments = {
            key: value
            for traced in trace[:1]
            for key, value in traced.facts.items()
            if mission.blackboard[key].source == "argument"
        }
        header = Header(journal_text(mission), profile, arguments, versions=mission.packages())
        path = _path(output, mission, name, only=len(proof.ways) == 1)
        try:
            shows = record(path, header, mission, trace, robot_facts=facts)
        except (UsageError, ConnectorError) as error:
            written[name] = {"journal": None, "unwritten": str(error)}
        else:
            written[name] = {"journal": str(path), "shows": shows}
    return written


def _path(output: str | None, mission: Mission, claim: str, *, only: bool) -> Path:
    """Where a refutation is written: as was asked, with the claim's name where there are several; never over a file."""
    word = re.sub(r"\W+", "_", claim)
    if output is None:
        wanted = Path(f"{mission.stem}-{word}.journal")
    else:
        wanted = Path(output)
        wanted = wanted if only else wanted.with_name(f"{wanted.stem}-{word}{wanted.suffix}")
    path, number = wanted, 1
    while path.exists():
        number += 1
        path = wanted.with_name(f"{wanted.stem}-{number}{wanted.suffix}")
    return path


def report(mission: Mission, proof: Proof, journals: dict[str, Any]) -> Iterable[str]:
    """The lines to print."""
    how = (
        "every state" if proof.is_whole else f"{STOPPED.get(proof.stopped, 'not every state')}, at depth {proof.depth}"
    )
    explored = f"{counted(proof.states, 'state')}, {counted(proof.steps, 'step')}, {proof.seconds:.1f} s; {how}"
    yield f"{mission.name} {mission.version}: {explored}"
    if not proof.is_whole:
        yield from _covered(proof)
    for claim in proof.claims:
        verdict = claim.verdict if claim.verdict != "explored" else f"explored {counted(proof.states, 'state')}"
        yield f"  {verdict:<{WIDTH}} {claim.name}: {claim.words}"
        if claim.verdict == "refuted":
            yield from _refutation(claim.sentence, proof.ways.get(claim.name, ()), journals.get(claim.name))
    if proof.verdict == "proved" and not proof.alike:
        yield f"these {proof.states} states are all that there are: a run of any length stays in them"
    yield from _limits(proof)


STOPPED = {
    "states": "as many states as were allowed (--states)",
    "seconds": "out of time (--max-seconds)",
    "memory": "out of memory (--max-memory)",
    "refuted": "ended after a refutation (--all explores the other claims to the limits)",
    "work": "as many steps as were allowed",
}
"""The limit that ended an exploration → what is printed."""


def _covered(proof: Proof) -> Iterable[str]:
    """What was covered before the limit, and what is open."""
    yield f"of these {proof.states} states {proof.done} were explored with all that can happen in them"
    for word, verdict in (("refuted", "refuted"), ("proved", "proved"), ("open", "explored")):
        names = [each.name for each in proof.claims if each.verdict == verdict]
        yield f"{word}: {', '.join(names) or 'none'}"
    yield from _multiplied(proof)


def _multiplied(proof: Proof) -> Iterable[str]:
    """Which keys multiply the states, where a limit left some out, and what would make them fewer."""
    most = [f"{key}: {many} values" for key, many in islice(proof.varieties.items(), MOST_KEYS)]
    if most:
        yield f"what multiplies most: {' × '.join(most)}"
        yield (
            "fewer: compare fewer fields of an item, set a count again where its task ends, give an argument a "
            "'minimum' and 'maximum' or an 'enum'"
        )


def _refutation(sentence: str, trace: Iterable[Any], journal: dict[str, Any] | None) -> Iterable[str]:
    yield f"      {sentence}"
    before: frozenset[str] = frozenset()
    for number, traced in enumerate(trace, 1):
        ends = f"{traced.outcome}: {traced.why}" if traced.outcome else ", ".join(sorted(traced.active - before))
        facts = [f"{key} {_exact(value)}" for key, value in sorted(traced.facts.items())]
        known = ", ".join(([f"control is with {traced.control.name}"] if traced.control is not None else []) + facts)
        happens = traced.words + _brought(traced.event)
        yield f"      {number}. {happens}" + (f"  → {ends}" if ends else "") + (f"  [{known}]" if known else "")
        before = traced.active
    if journal is not None and journal["journal"] is None:
        yield f"      {journal['unwritten']}"
    elif journal is not None:
        shows = "" if journal["shows"] else "; with the times as written it comes to something else there"
        yield f"      journal: {journal['journal']}{shows}"


def _brought(event: Event | None) -> str:
    """What an event, a result or an answer brings along; empty for nothing."""
    if event is None or event.kind not in ("event", "result", "proposal"):
        return ""
    data = event.data.get("parameters") or {} if event.kind == "proposal" else event.data
    listed = ", ".join(f"{name} {_exact(value)}" for name, value in sorted(data.items()))
    return f" ({listed})" if listed else ""


def _exact(value: Any) -> str:
    """A value with all its digits: a refutation may turn on the last, which `quoted` rounds away."""
    if value is None:
        return "unknown"
    return value if isinstance(value, str) else json.dumps(plain(value), ensure_ascii=False)


def _limits(proof: Proof) -> Iterable[str]:
    loops = [f"'{loop}' ({rounds} rounds)" for loop, rounds in sorted(proof.alike.items())]
    listed = {
        "assumed of the robot, and watched in a run": proof.assumed,
        "a few rounds represent all, which are alike": loops,
        "while paused or held, transitions wait and invariants do not, so the robot can end it by": proof.in_pause,
        "free to give any result whenever asked": proof.predicates,
        "tried with some values only, so nothing is called proved": proof.sampled,
        "no run enters": proof.never,
    }
    yield from (f"{limit}: {', '.join(names)}" for limit, names in listed.items() if names)
    yield "in every state the operator may pause, stop, resume, take control or give it; timers run out in any order"
    yield "comes to rest assumes that an operator who has taken control gives it back"
    yield "not explored: a process that is killed and resumed"


def as_json(mission: Mission, proof: Proof, journals: dict[str, Any]) -> dict[str, Any]:
    """A proof as JSON, for programs."""
    claims = [
        {
            "claim": each.name,
            "words": each.words,
            "verdict": each.verdict,
            "sentence": each.sentence,
            "run": [
                {
                    "happens": traced.words,
                    "facts": plain(traced.facts),
                    "active": sorted(traced.active),
                    "outcome": traced.outcome,
                    "why": traced.why,
                }
                for traced in proof.ways.get(each.name, ())
            ],
            **journals.get(each.name, {}),
        }
        for each in proof.claims
    ]
    counts = {name: getattr(proof, name) for name in FIELDS}
    return {"mission": mission.name, "version": mission.version, "verdict": proof.verdict, **counts, "claims": claims}
