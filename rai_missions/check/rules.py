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
from rai_missions.check import shadowed_rows as rows
from rai_missions.check import staleness as stale
from rai_missions.check import structure as shape
from rai_missions.check.finding import Finding, Severity, document_order
from rai_missions.check.index import MissionIndex
from rai_missions.mission.mission import Mission

__all__ = ("RULES", "Rule", "check")


class Rule(NamedTuple):
    """One rule that every mission is held to."""

    name: str
    severity: Severity
    find: Callable[[MissionIndex], Iterable[tuple[str, str]]]
    """Place and sentence of each breach."""

    @property
    def summary(self) -> str:
        """What holds where the rule is kept, in a sentence."""
        return (inspect.getdoc(self.find) or "").partition("\n\n")[0]


RULES: tuple[Rule, ...] = (
    Rule("duplicate-state", "error", names.duplicate_states),
    Rule("unknown-state", "error", names.unknown_states),
    Rule("unknown-event", "error", names.unknown_events),
    Rule("unknown-id", "error", names.unknown_ids),
    Rule("unknown-predicate", "error", names.unknown_predicates),
    Rule("colliding-name", "error", names.colliding_names),
    Rule("unknown-key", "error", keys.unknown_keys),
    Rule("unknown-payload", "error", keys.unknown_payload),
    Rule("forbidden-write", "error", keys.forbidden_writes),
    Rule("unwritten-key", "error", keys.unwritten_keys),
    Rule("mismatched-comparison", "error", types.mismatched_comparisons),
    Rule("mismatched-pose", "error", types.mismatched_poses),
    Rule("mismatched-list", "error", types.mismatched_lists),
    Rule("mismatched-write", "error", types.mismatched_writes),
    Rule("initial-outside", "error", shape.initial_outside),
    Rule("history-default", "error", shape.history_defaults),
    Rule("target-list", "error", shape.target_lists),
    Rule("misplaced-state", "error", shape.misplaced_states),
    Rule("misused-internal", "error", shape.misused_internal),
    Rule("inactive-state", "error", shape.words_in_vain),
    Rule("unreachable-state", "error", reach.unreachable_states),
    Rule("dead-end", "error", reach.dead_ends),
    Rule("waiting-room", "error", reach.waiting_rooms),
    Rule("unhandled-option", "error", outcomes.unhandled_options),
    Rule("unhandled-success", "error", outcomes.unhandled_success),
    Rule("overlapping-row", "error", rows.overlapping_rows),
    Rule("impossible-guard", "error", rows.impossible_guards),
    Rule("unwatched-held", "error", rows.unwatched_holds),
    Rule("endless-cycle", "error", cycles.endless_cycles),
    Rule("waitless-loop", "error", loops.waitless_loops),
    Rule("long-loop", "error", loops.long_loops),
    Rule("missing-requires", "error", facts.missing_requires),
    Rule("unfounded-success", "error", facts.unfounded_success),
    Rule("unbounded-action", "error", bounds.unbounded_actions),
    Rule("unbounded-decision", "error", bounds.unbounded_decisions),
    Rule("wrong-parameters", "error", bounds.wrong_parameters),
    Rule("blind-row", "warning", stale.blind_rows),
    Rule("possible-cycle", "warning", cycles.possible_cycles),
    Rule("deaf-row", "warning", outcomes.deaf_rows),
    Rule("empty-wildcard", "warning", outcomes.unused_wildcards),
    Rule("crossing-row", "warning", shape.crossing_rows),
    Rule("lost-timer", "warning", surprises.lost_timers),
    Rule("rival-action", "warning", surprises.rival_actions),
    Rule("unbounded-call", "warning", bounds.unbounded_calls),
    Rule("misspelled-answerer", "warning", bounds.misspelled_answerers),
    Rule("unused-key", "warning", keys.unused_keys),
    Rule("unused-event", "warning", keys.unused_events),
)
"""In this order where they stand at one place."""


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
