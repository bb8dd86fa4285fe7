# SPDX-License-Identifier: Apache-2.0
"""The machine of a decision: whom to ask next, what is offered now, and what becomes of an answer.

Rule: options are worked out again for each attempt, and an answer counts only by `judge`, now.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rai_missions.engine.activities.activity import ActivityHost, Bench, Machine, Outcome, Turn, machine_of, remembered
from rai_missions.engine.decision import Evidence, Limits, Offer, Proposal, Question, Verdict, VerdictNote, judge
from rai_missions.engine.step import Ask, Withdraw
from rai_missions.event import Event
from rai_missions.guards.view import Operand, Site, View
from rai_missions.keys import type_error
from rai_missions.mission.option_parameters import listed_parameters
from rai_missions.redaction import clipped
from rai_missions.states.decision import DecisionFields, DecisionSpec

__all__ = ("DecisionActivity", "DecisionMachine")


@remembered("Asking")
class DecisionActivity(NamedTuple):
    """A question is open."""

    question: Question
    turn: int
    """Which of `ask` is asked, from 0."""
    deadline: float
    """When the whole decision is over."""


class DecisionMachine(Machine):
    """Asks one decision's question."""

    def __init__(self, asked: DecisionSpec, owner: str, site: Site) -> None:
        self.asked, self.owner = asked, owner
        self.tests = {name: guard.compiled(site, True) for name, guard in asked.guards()}
        self.shown = [(path, Operand(path, Site(site.place, site.keys))) for path in asked.evidence]
        self.keys = site.keys
        self.listed = {name: listed_parameters(option.parameters) for name, option in asked.options.items()}
        budget = asked.budget
        self.budget = Limits(budget.calls, budget.tokens, budget.seconds)

    def begin(self, host: ActivityHost) -> Turn:
        deadline = host.begins_at + self.asked.deadline_s if self.asked.deadline_s is not None else math.inf
        return self._ask(host, turn=0, attempt=1, deadline=deadline, refused=())

    def _ask(self, host: ActivityHost, *, turn: int, attempt: int, deadline: float, refused: tuple[str, ...]) -> Turn:
        view = host.view
        question = Question(
            number=host.next_number(),
            owner=self.owner,
            asked=self.asked.ask[turn],
            text=self.asked.question,
            options=self._offers(view),
            evidence=self._evidence(view),
            attempt=attempt,
            at=view.at,
            until=self._until(host.begins_at, turn, deadline),
            refused=refused,
            tools=self.asked.tools,
            budget=self.budget,
        )
        return Turn(DecisionActivity(question, turn, deadline), (Ask(question),))

    def _offers(self, view: View) -> tuple[Offer, ...]:
        return tuple(
            Offer(name, option.about, option.parameters)
            for name, option in self.asked.options.items()
            if name not in self.tests or self.tests[name](view) is True
        )

    def _until(self, begins_at: float, turn: int, deadline: float) -> float:
        if self.asked.within_s is not None:
            return min(deadline, begins_at + self.asked.within_s)
        return begins_at + (deadline - begins_at) / (len(self.asked.ask) - turn)

    def _evidence(self, view: View) -> tuple[Evidence, ...]:
        return tuple(self._shown(path, operand, view) for path, operand in self.shown)

    def _shown(self, path: str, operand: Operand, view: View) -> Evidence:
        entry = view.board.get(operand.key)
        if entry is None:
            return Evidence(path, None, None, fresh=False)
        value = operand.read(view)
        return Evidence(path, value, max(0.0, view.at - entry.at), fresh=value is not None)

    def receive(self, state: DecisionActivity, event: Event, host: ActivityHost) -> Turn | None:
        if event.kind == "tick":
            return self._time(state, host)
        if event.kind != "proposal" or event.number != state.question.number:
            return None
        if host.view.at >= state.deadline or host.view.at >= state.question.until:
            return self._time(state, host)
        return self._answered(state, event, host)

    def _answered(self, state: DecisionActivity, event: Event, host: ActivityHost) -> Turn:
        question, data = state.question, event.data
        who = f"question {question.number}: {question.asked}"
        if "absent" in data:
            verdict = Verdict(False, str(data["absent"]), "absent", question.number, event.name)
            turn = self._next(state, host, turn=state.turn + 1, attempt=1)
            return _noted(turn, verdict, f"{who} is absent: {data['absent']}")
        if not isinstance(data.get("option"), str):
            why = clipped(str(data.get("failed", "nothing")), 300)
            verdict, text = Verdict(False, why, "failed", question.number, event.name), f"{who} gave no answer: {why}"
            return self._again(state, host, verdict, text, refusal=text)
        given = data.get("parameters")
        proposal = Proposal(data["option"], given if isinstance(given, Mapping) else {})
        verdict = judge(question, proposal, host.view, self.tests)
        if verdict.accepted and (why := self._parameter_fault(proposal)):
            verdict = Verdict(False, f"the parameters of '{proposal.option}' are not valid: {why}")
        option = clipped(proposal.option, 60)
        verdict = verdict._replace(number=question.number, by=event.name, option=option)
        text = f"{who} proposed '{option}'"
        if not verdict.accepted:
            return self._again(state, host, verdict, f"{text}: refused, {verdict.why}", refusal=verdict.why)
        outcome = Outcome(proposal.option, dict(proposal.parameters))
        writes = tuple(self._written(proposal))
        return _noted(Turn(None, outcome=outcome, writes=writes), verdict, f"{text}: accepted")

    def _written(self, proposal: Proposal) -> Iterator[tuple[str, Any]]:
        """What an accepted answer writes: keys whose source is the answer, by parameters that its option lists."""
        listed = self.listed[proposal.option]
        for name, value in proposal.parameters.items():
            key = self.keys.get(name)
            if key is not None and key.source == "answer" and (listed is None or name in listed):
                yield name, value

    def _parameter_fault(self, proposal: Proposal) -> str:
        """Why a parameter cannot be written to its key; empty if each can."""
        each = (
            f"{name}: {why}" for name, value in self._written(proposal) if (why := type_error(self.keys[name], value))
        )
        return next(each, "")

    def _again(self, state: DecisionActivity, host: ActivityHost, verdict: Verdict, text: str, *, refusal: str) -> Turn:
        again = state._replace(question=state.question._replace(refused=(*state.question.refused, refusal)))
        return _noted(self._next(again, host, turn=state.turn, attempt=state.question.attempt + 1), verdict, text)

    def _next(self, state: DecisionActivity, host: ActivityHost, *, turn: int, attempt: int) -> Turn:
        if attempt > self.asked.attempts:
            turn, attempt = turn + 1, 1
        if turn >= len(self.asked.ask):
            return self._fall_back("nobody gave an answer that counts", state.question.number)
        return self._ask(host, turn=turn, attempt=attempt, deadline=state.deadline, refused=state.question.refused)

    def _time(self, state: DecisionActivity, host: ActivityHost) -> Turn | None:
        question = state.question
        if host.view.at >= state.deadline:
            over = self._fall_back("the deadline has passed", question.number)
        elif host.view.at >= question.until:
            why = "gave no answer in time"
            verdict = Verdict(False, why, "timed_out", question.number, question.asked)
            over = self._next(state, host, turn=state.turn + 1, attempt=1)
            over = _noted(over, verdict, f"question {question.number}: {question.asked} {why}")
        else:
            return None
        return over._replace(effects=(Withdraw(question.number), *over.effects))

    def _fall_back(self, why: str, number: int) -> Turn:
        option = self.asked.fallback
        if option is None:
            return Turn(None, outcome=Outcome("failed", why=f"{why}, and there is no fallback"))
        verdict = Verdict(False, why, "fallback", number, "", option)
        turn = Turn(None, outcome=Outcome(option, why=f"fallback: {why}"))
        return _noted(turn, verdict, f"fallback '{option}': {why}")

    def leave(self, state: DecisionActivity, host: ActivityHost) -> Turn:
        return Turn(None, (Withdraw(state.question.number),))

    def wake_at(self, state: DecisionActivity, view: View) -> float:
        return min(state.deadline, state.question.until)

    def awaits(self, state: DecisionActivity) -> frozenset[int]:
        return frozenset({state.question.number})

    def shift(self, state: DecisionActivity, by_s: float) -> DecisionActivity:
        question = state.question._replace(until=state.question.until + by_s)
        return state._replace(question=question, deadline=state.deadline + by_s)


@machine_of.register(DecisionFields)
def _(definition: DecisionFields, bench: Bench) -> DecisionMachine:
    return DecisionMachine(definition.decision, bench.owner, bench.site("decision"))


def _noted(turn: Turn, verdict: Verdict, text: str) -> Turn:
    """A turn with the note of a verdict in front."""
    return turn._replace(notes=(VerdictNote(verdict, text), *turn.notes))
