# SPDX-License-Identifier: Apache-2.0
"""One cell: the question of its scene, as its embodiment and order of options show it, asked and judged.

Rule: what is judged of an answer is what the store keeps of it, so a recorded answer is judged as it was.
Rule: the verdict is the mission's. The answer goes as an event into a branch of the chart that asks, and what that
step makes of it is what a run would make of it at that instant.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rai_missions.campaign.budget import CallPace
from rai_missions.campaign.cells import Cell, ordered
from rai_missions.campaign.embodiments import RobotView
from rai_missions.campaign.file import CampaignFile, PriceEntry
from rai_missions.campaign.models import CampaignModels, CellReply, is_chat, provider_of
from rai_missions.campaign.questions import AskedScene
from rai_missions.campaign.records import CellRecord, QuestionRecord, graded, is_tried
from rai_missions.engine.decision import Evidence, Question, Verdict
from rai_missions.event import Event
from rai_missions.redaction import Redaction, cut, redacted

__all__ = ("CellAsker", "kept", "question_record", "raw_text", "shown_question")

MILLION = 1_000_000
LONGEST = 20_000
"""Characters of a raw answer that are kept, and of a text of one."""
JUDGED = ("option", "parameters")
"""What the mission judges of an answer: kept whole, or the answer is too long."""
FREE = PriceEntry()
GONE = "Absent"
"""The type by which a model that cannot be opened is known: asking it again would open it no better."""
LONGEST_PAUSE_S = 300.0
"""A provider that wants to be left alone for longer is asked by the next run."""


def shown_question(question: Question, body: RobotView, order: str) -> Question:
    """A question with its options in an order, and with what the documents of an embodiment state on it."""
    names = ordered([each.name for each in question.options], order)
    offers = {each.name: each for each in question.options}
    quotes = tuple(Evidence("documents", quote, 0.0, True) for quote in body.documents)
    return question._replace(options=tuple(offers[name] for name in names), evidence=question.evidence + quotes).apart()


def question_record(asked: AskedScene, embodiment: str, body: RobotView) -> QuestionRecord:
    """What a model is asked in a scene under an embodiment, for the report: without secrets, which it was shown."""
    from rai_missions.answerers.model.prompt import messages_of

    question = shown_question(asked.question, body, "written")
    messages = messages_of(question, body.identity, mode="json_schema", images=body.pictures)
    options = [each.name for each in question.options]
    permitted = [name for name in options if _judged(asked, CellReply({"option": name})).accepted]
    return QuestionRecord(
        asked.scene.scene,
        embodiment,
        redacted("\n\n".join(each.text for each in messages)),
        json.dumps(Redaction().json(asked.facts)),
        json.dumps(options),
        json.dumps(permitted),
    )


class CellAsker(NamedTuple):
    """Asks the cells of a worker."""

    file: CampaignFile
    models: CampaignModels
    paces: Mapping[str, CallPace]
    """Provider → how fast this worker may ask it."""
    bodies: Mapping[str, RobotView]
    """Embodiment → what it shows."""
    is_over: threading.Event
    """Set when no further call may be begun."""
    recorded: Callable[[Cell], CellRecord | None] | None = None
    """Instead of asking: a cell that was answered in an earlier campaign, or None where it was not."""

    def ask(self, key: str, cell: Cell, asked: AskedScene, labels: Mapping[str, str]) -> CellRecord | None:
        """The record of one cell; None where no call may be begun any more.

        Args:
            key: Its name in the store.
            cell: Which.
            asked: Its scene.
            labels: Option → verdict of physics in the scene.
        """
        if self.recorded is not None:
            return None if self.is_over.is_set() else self._judged_again(key, self.recorded(cell), cell, asked, labels)
        question = shown_question(asked.question, self.bodies[cell.embodiment], cell.option_order)
        if self.file.answer_s is not None:
            question = question._replace(until=question.at + self.file.answer_s)
        used, latency_s, pause_s = Usage(), 0.0, 0.0
        reply: CellReply | None = None
        for attempt in range(1 + (self.file.retries if is_chat(cell.model, self.file) else 0)):
            if self._waits(cell.model, pause_s):
                break
            self.models.open(cell.model, question, (cell.embodiment, self.bodies[cell.embodiment]))
            began = time.perf_counter()
            came = self._reply(cell, question, asked, labels)
            latency_s, one, reply = time.perf_counter() - began, Usage.of(came), kept(came)
            self._note(cell.model, one)
            used = Usage(*map(sum, zip(used, one, strict=True)))
            pause_s = max(2.0**attempt, reply.after_s)
            if not reply.raised or reply.raised == GONE or pause_s > LONGEST_PAUSE_S:
                break
        if reply is None:
            return None
        return self._graded(_record(key, cell, reply, asked), reply, used, latency_s, labels)

    def _judged_again(
        self, key: str, earlier: CellRecord | None, cell: Cell, asked: AskedScene, labels: Mapping[str, str]
    ) -> CellRecord:
        """A recorded answer, judged by the mission as it is now, with what it took when it was asked for."""
        if earlier is None:
            return _record(key, cell, CellReply({"absent": "no answer is recorded"}), asked)
        reply = CellReply(**json.loads(earlier.raw))
        used = Usage(earlier.calls, earlier.prompt_tokens, earlier.completion_tokens)
        return self._graded(_record(key, cell, reply, asked), reply, used, earlier.latency_s, labels)

    def _graded(
        self, record: CellRecord, reply: CellReply, used: Usage, latency_s: float, labels: Mapping[str, str]
    ) -> CellRecord:
        price = self.file.prices.get(record.model, FREE)
        cost = (used.tokens_in * price.prompt + used.tokens_out * price.completion) / MILLION
        return graded(
            record._replace(
                prompt_tokens=used.tokens_in,
                completion_tokens=used.tokens_out,
                calls=used.calls,
                latency_s=round(latency_s, 6),
                cost=cost,
            ),
            labels if self._is_tried(reply) else {},
        )

    def _is_tried(self, reply: CellReply) -> bool:
        tried = self.file.rollouts.parameters
        return is_tried(str(reply.answer.get("option")), reply.answer.get("parameters"), tried)

    def _reply(self, cell: Cell, question: Question, asked: AskedScene, labels: Mapping[str, str]) -> CellReply:
        return self.models.ask(
            cell.model,
            question,
            asked,
            labels=labels,
            embodiment=(cell.embodiment, self.bodies[cell.embodiment]),
        )

    def _waits(self, model: str, at_least_s: float) -> bool:
        """Wait as long as the rate of a provider demands; whether the campaign is over by then."""
        pace = self.paces.get(provider_of(model))
        delay_s = max(at_least_s, pace.delay_s(time.monotonic()) if pace is not None else 0.0)
        return self.is_over.wait(delay_s) if delay_s > 0 else self.is_over.is_set()

    def _note(self, model: str, used: Usage) -> None:
        if (pace := self.paces.get(provider_of(model))) is not None:
            pace.spend(time.monotonic(), max(1, used.calls), used.tokens_in + used.tokens_out)


class Usage(NamedTuple):
    """What was used for an answer."""

    calls: int = 0
    tokens_in: int = 0
    tokens_out: int = 0

    @classmethod
    def of(cls, reply: CellReply) -> Usage:
        """As the answer has it."""
        usage = reply.answer.get("usage")
        found = usage if isinstance(usage, Mapping) else {}
        return cls(*(each if isinstance(each := found.get(name), int) else 0 for name in cls._fields))


def _record(key: str, cell: Cell, reply: CellReply, asked: AskedScene) -> CellRecord:
    """The answer, judged by the mission."""
    answer = reply.answer
    record = CellRecord(key, *cell, status="failed", raw=raw_text(reply))
    option = answer.get("option")
    if isinstance(option, str):
        verdict = _judged(asked, reply)
        why = answer.get("why", "")
        return record._replace(
            status="answered",
            option=cut(option, 100),
            permitted=int(verdict.accepted),
            reason=cut(why, LONGEST) if isinstance(why, str) else "",
            error="" if verdict.accepted else cut(verdict.why, LONGEST),
        )
    error = str(answer.get("absent", answer.get("failed", "no answer")))
    failed = bool(reply.raised) or "absent" in answer
    return record._replace(status="failed" if failed else "no_answer", error=cut(error, LONGEST))


def kept(reply: CellReply) -> CellReply:
    """What is kept of an answer, and judged: without secrets, and of its words the beginning where they are long."""
    given = Redaction().json(json.loads(json.dumps(reply._asdict(), default=str)))
    found, longest = CellReply(**given), LONGEST
    while len(raw_text(found)) > LONGEST and longest:
        longest //= 2
        found = CellReply(**{name: _shortened(value, longest) for name, value in given.items()})
    return found if len(raw_text(found)) <= LONGEST else CellReply({"failed": "the answer is too long"})


def raw_text(reply: CellReply) -> str:
    """An answer that is kept, as JSON that is read again."""
    return json.dumps(reply._asdict())


def _shortened(value: Any, longest: int) -> Any:
    """Plain data whose texts have so many characters at the most, but for what an answer is judged by."""
    if isinstance(value, str):
        return cut(value, longest)
    if isinstance(value, dict):
        return {name: item if name in JUDGED else _shortened(item, longest) for name, item in value.items()}
    return [_shortened(item, longest) for item in value] if isinstance(value, list) else value


def _judged(asked: AskedScene, reply: CellReply) -> Verdict:
    """What the mission makes of an answer at the instant at which it asked."""
    chart, question = asked.chart.branch(), asked.question
    step = chart.send(Event(question.asked, chart.at, dict(reply.answer), "proposal", question.number))
    assert step.verdict is not None
    return step.verdict
