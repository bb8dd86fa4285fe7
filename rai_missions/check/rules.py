# SPDX-License-Identifier: Apache-2.0
"""The table of all rules, and the one function that applies it.

Rule: a rule is a small function over a `MissionIndex`; it knows neither its severity nor the other rules.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterable, Mapping
from types import NoneType
from typing import Any, Literal, NamedTuple

from rai_missions.check import bounds, cycles, keys, loops, names, outcomes, surprises, types
from rai_missions.check import grounding as facts
from rai_missions.check import reachability as reach
from rai_missions.check import shadowed_transitions as shadowed
from rai_missions.check import staleness as stale
from rai_missions.check import structure as shape
from rai_missions.check.finding import Finding, Severity, document_order
from rai_missions.check.index import MissionIndex
from rai_missions.errors import steps_of
from rai_missions.given import check_given
from rai_missions.mission.garbage import few_collections
from rai_missions.mission.legible import LegiblePart, is_entry, words_in
from rai_missions.mission.mission import Mission, given_mission
from rai_missions.mission.origins import as_written

__all__ = ("RULES", "CheckRule", "check", "check_part", "holds_anyway")


class CheckRule(NamedTuple):
    """One rule that every mission is held to."""

    name: str
    severity: Severity
    find: Callable[[MissionIndex], Iterable[tuple[str, str]]]
    """Place and sentence of each breach."""
    scope: Literal["place", "state", "structure", "mission"] = "mission"
    """What must be readable for it: what is written at a place, or the state or key around that, and what their names
    mean; the state around a place and those around it, whatever names mean; or the mission whole."""

    @property
    def summary(self) -> str:
        """What holds where the rule is kept, in a sentence."""
        return (inspect.getdoc(self.find) or "").partition("\n\n")[0]


RULES: tuple[CheckRule, ...] = (
    CheckRule("duplicate-state", "error", names.duplicate_states, "place"),
    CheckRule("unknown-state", "error", names.unknown_states, "place"),
    CheckRule("unknown-event", "error", names.unknown_events, "place"),
    CheckRule("unknown-id", "error", names.unknown_ids, "place"),
    CheckRule("unknown-predicate", "error", names.unknown_predicates, "place"),
    CheckRule("colliding-name", "error", names.colliding_names, "place"),
    CheckRule("unknown-key", "error", keys.unknown_keys, "place"),
    CheckRule("unknown-payload", "error", keys.unknown_payload, "place"),
    CheckRule("forbidden-write", "error", keys.forbidden_writes, "place"),
    CheckRule("unwritten-key", "error", keys.unwritten_keys),
    CheckRule("mismatched-comparison", "error", types.mismatched_comparisons, "place"),
    CheckRule("mismatched-pose", "error", types.mismatched_poses, "place"),
    CheckRule("mismatched-list", "error", types.mismatched_lists, "place"),
    CheckRule("mismatched-item", "error", types.mismatched_items, "place"),
    CheckRule("mismatched-activity", "error", types.mismatched_activities, "place"),
    CheckRule("mismatched-write", "error", types.mismatched_writes, "place"),
    CheckRule("unreadable-goal", "error", types.unreadable_goals, "place"),
    CheckRule("initial-outside", "error", shape.initial_outside, "place"),
    CheckRule("history-default", "error", shape.history_defaults, "place"),
    CheckRule("target-list", "error", shape.target_lists, "place"),
    CheckRule("misplaced-state", "error", shape.misplaced_states, "structure"),
    CheckRule("misused-internal", "error", shape.misused_internal, "place"),
    CheckRule("inactive-state", "error", shape.words_in_vain, "place"),
    CheckRule("unreachable-state", "error", reach.unreachable_states, "place"),
    CheckRule("dead-end", "error", reach.dead_ends),
    CheckRule("waiting-room", "error", reach.waiting_rooms),
    CheckRule("unhandled-option", "error", outcomes.unhandled_options, "state"),
    CheckRule("unhandled-success", "error", outcomes.unhandled_success, "state"),
    CheckRule("overlapping-transition", "error", shadowed.overlapping_transitions, "state"),
    CheckRule("impossible-guard", "error", shadowed.impossible_guards, "place"),
    CheckRule("unwatched-held", "error", shadowed.unwatched_holds, "place"),
    CheckRule("endless-cycle", "error", cycles.endless_cycles),
    CheckRule("waitless-loop", "error", loops.waitless_loops),
    CheckRule("long-loop", "error", loops.long_loops, "place"),
    CheckRule("missing-requires", "error", facts.missing_requires, "structure"),
    CheckRule("unfounded-success", "error", facts.unfounded_success),
    CheckRule("early-result", "error", facts.early_results),
    CheckRule("unbounded-action", "error", bounds.unbounded_actions, "structure"),
    CheckRule("unbounded-decision", "error", bounds.unbounded_decisions, "structure"),
    CheckRule("wrong-parameters", "error", bounds.wrong_parameters, "place"),
    CheckRule("odd-pose", "warning", types.odd_poses, "place"),
    CheckRule("blind-transition", "warning", stale.blind_transitions),
    CheckRule("possible-cycle", "warning", cycles.possible_cycles),
    CheckRule("deaf-transition", "warning", outcomes.deaf_transitions),
    CheckRule("unhandled-failure", "warning", outcomes.unhandled_failures),
    CheckRule("empty-wildcard", "warning", outcomes.unused_wildcards),
    CheckRule("crossing-transition", "warning", shape.crossing_transitions),
    CheckRule("lost-timer", "warning", surprises.lost_timers),
    CheckRule("hasty-retry", "warning", surprises.hasty_retries),
    CheckRule("lost-fallback", "warning", loops.lost_fallbacks),
    CheckRule("rival-action", "warning", surprises.rival_actions),
    CheckRule("unbounded-call", "warning", bounds.unbounded_calls),
    CheckRule("unreachable-limit", "warning", bounds.unreachable_limits, "structure"),
    CheckRule("unknown-tool", "warning", bounds.unknown_tools, "place"),
    CheckRule("literal-reference", "warning", names.literal_references, "place"),
    CheckRule("repeated-name", "warning", names.repeated_names, "place"),
    CheckRule("misspelled-answerer", "warning", bounds.misspelled_answerers, "place"),
    CheckRule("unlisted-answerer", "warning", bounds.unlisted_answerers, "mission"),
    CheckRule("unused-key", "warning", keys.unused_keys),
    CheckRule("unused-event", "warning", keys.unused_events),
)
"""In this order where they are at one place."""


@few_collections()
def check(mission: Mission, *, named: Collection[str] | None = None) -> tuple[Finding, ...]:
    """Everything that is wrong or odd in a mission, in document order.

    Args:
        mission: One that is well formed; inclusions are better expanded before, for their outcomes are not known else.
        named: The names of the registered predicates, or name → function, whose parameters are held against the uses;
            left out, `named` guards are taken on trust.

    Raises:
        UsageError: It is no mission.
    """
    given_mission(mission, "check")
    check_given(named, (Collection, NoneType), "named", "the names of predicates")
    index, order = MissionIndex(mission, named), document_order(mission)
    found = [
        Finding(place, sentence, rule.severity, rule.name) for rule in RULES for place, sentence in rule.find(index)
    ]
    return tuple(sorted(dict.fromkeys(found), key=lambda finding: order(finding.place)))


def check_part(
    part: LegiblePart, document: Mapping[str, Any], *, named: Collection[str] | None = None
) -> tuple[Finding, ...]:
    """What is wrong in the legible part of a mission, whatever the rest of it turns out to be.

    Args:
        part: What could be read.
        document: The JSON document of the whole.
        named: As in `check`.
    """
    scopes = {rule.name: rule.scope for rule in RULES}
    found = (each for each in check(part.mission, named=named) if scopes[each.rule] != "mission")
    placed = (each._replace(place=as_written(document, each.place)) for each in found)
    return tuple(each for each in placed if holds_anyway(each, scopes[each.rule], part, document))


def holds_anyway(finding: Finding, scope: str, part: LegiblePart, document: Mapping[str, Any]) -> bool:
    """Whether it would be found as well if the rest could be read.

    Args:
        finding: What is wrong; one of no rule, such as an inclusion's, depends on names at its own place alone.
        scope: As in `CheckRule`.
        part: What could be read.
        document: The JSON document of the whole.
    """
    if part.hides(finding.place) or (scope in ("state", "structure") and part.touches(finding.place)):
        return False
    known = {
        "unknown-state": part.has_states,
        "unreachable-state": part.has_targets,
        "unknown-event": part.has_words_of(finding.place),
    }
    if not known.get(finding.rule, True):
        return False
    steps = steps_of(finding.place)
    here: Any = document
    around: Any = document
    for word in steps:
        around = here
        here = here.get(word) if isinstance(here, Mapping) else _item(here, word)
        if here is None:
            return False
    if scope == "structure":
        return True
    name: Any = here
    if is_entry(steps):
        name = steps[-1]
    elif isinstance(around, Mapping) and finding.rule and not finding.rule.startswith("unknown-"):
        name = around
    return not any(part.mentions(each) for each in words_in(name))


def _item(listed: Any, word: str) -> Any:
    return listed[int(word)] if isinstance(listed, list) and word.isdigit() and int(word) < len(listed) else None
