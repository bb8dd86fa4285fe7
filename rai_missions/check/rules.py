# SPDX-License-Identifier: Apache-2.0
"""The table of all rules, and the one function that applies it.

Rule: a rule is a small function over a `MissionIndex`; it knows neither its severity nor the other rules.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterable
from typing import NamedTuple

from rai_missions.check import bounds, cycles, keys, loops, names, outcomes, surprises, types
from rai_missions.check import grounding as facts
from rai_missions.check import reachability as reach
from rai_missions.check import shadowed_transitions as shadowed
from rai_missions.check import staleness as stale
from rai_missions.check import structure as shape
from rai_missions.check.finding import Finding, Severity, document_order
from rai_missions.check.index import MissionIndex
from rai_missions.mission.mission import Mission

__all__ = ("RULES", "CheckRule", "check")


class CheckRule(NamedTuple):
    """One rule that every mission is held to."""

    name: str
    severity: Severity
    find: Callable[[MissionIndex], Iterable[tuple[str, str]]]
    """Place and sentence of each breach."""

    @property
    def summary(self) -> str:
        """What holds where the rule is kept, in a sentence."""
        return (inspect.getdoc(self.find) or "").partition("\n\n")[0]


RULES: tuple[CheckRule, ...] = (
    CheckRule("duplicate-state", "error", names.duplicate_states),
    CheckRule("unknown-state", "error", names.unknown_states),
    CheckRule("unknown-event", "error", names.unknown_events),
    CheckRule("unknown-id", "error", names.unknown_ids),
    CheckRule("unknown-predicate", "error", names.unknown_predicates),
    CheckRule("colliding-name", "error", names.colliding_names),
    CheckRule("unknown-key", "error", keys.unknown_keys),
    CheckRule("unknown-payload", "error", keys.unknown_payload),
    CheckRule("forbidden-write", "error", keys.forbidden_writes),
    CheckRule("unwritten-key", "error", keys.unwritten_keys),
    CheckRule("mismatched-comparison", "error", types.mismatched_comparisons),
    CheckRule("mismatched-pose", "error", types.mismatched_poses),
    CheckRule("mismatched-list", "error", types.mismatched_lists),
    CheckRule("mismatched-write", "error", types.mismatched_writes),
    CheckRule("initial-outside", "error", shape.initial_outside),
    CheckRule("history-default", "error", shape.history_defaults),
    CheckRule("target-list", "error", shape.target_lists),
    CheckRule("misplaced-state", "error", shape.misplaced_states),
    CheckRule("misused-internal", "error", shape.misused_internal),
    CheckRule("inactive-state", "error", shape.words_in_vain),
    CheckRule("unreachable-state", "error", reach.unreachable_states),
    CheckRule("dead-end", "error", reach.dead_ends),
    CheckRule("waiting-room", "error", reach.waiting_rooms),
    CheckRule("unhandled-option", "error", outcomes.unhandled_options),
    CheckRule("unhandled-success", "error", outcomes.unhandled_success),
    CheckRule("overlapping-transition", "error", shadowed.overlapping_transitions),
    CheckRule("impossible-guard", "error", shadowed.impossible_guards),
    CheckRule("unwatched-held", "error", shadowed.unwatched_holds),
    CheckRule("endless-cycle", "error", cycles.endless_cycles),
    CheckRule("waitless-loop", "error", loops.waitless_loops),
    CheckRule("long-loop", "error", loops.long_loops),
    CheckRule("missing-requires", "error", facts.missing_requires),
    CheckRule("unfounded-success", "error", facts.unfounded_success),
    CheckRule("unbounded-action", "error", bounds.unbounded_actions),
    CheckRule("unbounded-decision", "error", bounds.unbounded_decisions),
    CheckRule("wrong-parameters", "error", bounds.wrong_parameters),
    CheckRule("blind-transition", "warning", stale.blind_transitions),
    CheckRule("possible-cycle", "warning", cycles.possible_cycles),
    CheckRule("deaf-transition", "warning", outcomes.deaf_transitions),
    CheckRule("empty-wildcard", "warning", outcomes.unused_wildcards),
    CheckRule("crossing-transition", "warning", shape.crossing_transitions),
    CheckRule("lost-timer", "warning", surprises.lost_timers),
    CheckRule("rival-action", "warning", surprises.rival_actions),
    CheckRule("unbounded-call", "warning", bounds.unbounded_calls),
    CheckRule("misspelled-answerer", "warning", bounds.misspelled_answerers),
    CheckRule("unused-key", "warning", keys.unused_keys),
    CheckRule("unused-event", "warning", keys.unused_events),
)
"""In this order where they are at one place."""


def check(mission: Mission, *, named: Collection[str] | None = None) -> tuple[Finding, ...]:
    """Everything that is wrong or odd in a mission, in document order.

    Args:
        mission: One that is well formed; inclusions are better expanded before, for their outcomes are not known else.
        named: The names of the registered predicates; left out, `named` guards are taken on trust.
    """
    survey, order = MissionIndex(mission, named), document_order(mission)
    found = [
        Finding(place, sentence, rule.severity, rule.name) for rule in RULES for place, sentence in rule.find(survey)
    ]
    return tuple(sorted(dict.fromkeys(found), key=lambda finding: order(finding.place)))
