# SPDX-License-Identifier: Apache-2.0
"""What every answerer must do, as functions that their tests call."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.engine.decision import Answerer, Evidence, Limits, Offer, Question
from rai_missions.given import check_function, check_given
from rai_missions.redaction import cut_repr

__all__ = ("QUESTION", "ReplyCollector", "answer_fault", "at_once", "check_answerer")

AT_ONCE_S = 1.0
"""Longer is waiting, even on a busy machine."""
USAGE = {"calls": int, "tokens_in": int, "tokens_out": int, "seconds": int | float, "model": str}

QUESTION = Question(
    number=1,
    owner="assessing",
    asked="agent",
    text="Something blocks the alley. What should the tractor do?",
    options=(Offer("replan", "take the next alley"), Offer("signal", "sound the horn"), Offer("abort", "stop here")),
    evidence=(
        Evidence("obstacle", {"kind": "branch", "height_m": 0.1}, 0.2, fresh=True),
        Evidence("battery", None, 3.2, fresh=False),
    ),
    until=30.0,
    budget=Limits(calls=4, tokens=20_000, seconds=20.0),
)
"""A question like any other, for tests."""


class ReplyCollector:
    """Collects what an answerer answers, from any thread."""

    def __init__(self) -> None:
        self.all: list[Mapping[str, Any]] = []
        self._changed = threading.Condition()

    def __call__(self, answer: Mapping[str, Any]) -> None:
        with self._changed:
            self.all.append(answer)
            self._changed.notify_all()

    def wait(self, within_s: float = 10.0) -> Mapping[str, Any]:
        """The first answer; an `AssertionError` if none comes in time."""
        with self._changed:
            assert self._changed.wait_for(lambda: bool(self.all), within_s), f"no answer within {within_s:g} s"
            return self.all[0]


def answer_fault(answer: Any) -> str:
    """Why something is no answer as `Answerer` has it; empty if it is one."""
    if not isinstance(answer, Mapping):
        return f"an answer is a mapping, not {cut_repr(answer, 80)}"
    kinds = [kind for kind in ("option", "absent", "failed") if kind in answer]
    if len(kinds) != 1:
        return f"an answer has one of option, absent, failed; this has {', '.join(kinds) or 'none'}"
    if not isinstance(answer[kinds[0]], str):
        return f"'{kinds[0]}' is text, not {cut_repr(answer[kinds[0]], 80)}"
    known = {"option": {"option", "parameters", "why", "usage", "looked"}}.get(kinds[0], {kinds[0], "usage", "looked"})
    if unknown := sorted(map(str, set(answer) - known)):
        return f"an answer with '{kinds[0]}' has no '{unknown[0]}'"
    if not isinstance(answer.get("parameters", {}), Mapping) or not isinstance(answer.get("why", ""), str):
        return "'parameters' is a mapping and 'why' is text"
    try:
        json.dumps(answer, allow_nan=False, ensure_ascii=False).encode()
    except (TypeError, ValueError, RecursionError) as error:
        return f"an answer can be written as JSON in UTF-8: {error}"
    return _looked_fault(answer.get("looked", [])) or _usage_fault(answer.get("usage"))


def _looked_fault(looked: Any) -> str:
    notes = looked if isinstance(looked, list) else [looked]
    wrong = [note for note in notes if not isinstance(note, Mapping) or set(note) != {"tool", "arguments", "said"}]
    return f"each of 'looked' has `tool`, `arguments` and `said`, not {cut_repr(wrong[0], 60)}" if wrong else ""


def _usage_fault(usage: Any) -> str:
    if usage is None:
        return ""
    if not isinstance(usage, Mapping) or set(usage) != set(USAGE):
        return f"'usage' has {', '.join(USAGE)}, not {cut_repr(usage, 120)}"
    wrong = [name for name, kind in USAGE.items() if not isinstance(usage[name], kind)]
    return f"usage of {wrong[0]} is not {cut_repr(usage[wrong[0]], 60)}" if wrong else ""


def check_answerer(make: Callable[[], Answerer], question: Question = QUESTION, *, within_s: float = 10.0) -> None:
    """Hold an answerer to the contract of `Answerer`.

    Args:
        make: Gives a fresh answerer, one that does answer the question, be it by the reason of its absence.
        question: What it is asked; must be one that it knows.
        within_s: How long an answer may take.

    Raises:
        AssertionError: A promise is broken; the text names it.
    """
    check_function(make, "check_answerer", "what makes an answerer", "give its class, or a function")
    answerer = make()
    check_given(answerer, Answerer, "check_answerer", "what makes an answerer")
    first, second = ReplyCollector(), ReplyCollector()
    at_once("withdraw", lambda: answerer.withdraw(question.number))
    at_once("ask", lambda: answerer.ask(question, first))
    at_once("ask", lambda: answerer.ask(question._replace(number=question.number + 1), second))
    for reply in (first, second):
        fault = answer_fault(reply.wait(within_s))
        assert not fault, fault
    at_once("withdraw", lambda: answerer.withdraw(question.number))
    at_once("withdraw", lambda: answerer.withdraw(question.number))
    third = ReplyCollector()
    at_once("ask", lambda: answerer.ask(question._replace(number=question.number + 2), third))
    at_once("withdraw", lambda: answerer.withdraw(question.number + 2))
    answerer.ask(question._replace(number=question.number + 3), last := ReplyCollector())
    last.wait(within_s)
    for reply in (first, second, third, last):
        assert len(reply.all) <= 1, f"a question is answered once, not {len(reply.all)} times: {reply.all}"
    stop = getattr(answerer, "stop", None)
    if stop is not None:
        stop()


def at_once(what: str, act: Callable[[], object], within_s: float = AT_ONCE_S) -> None:
    """Do it on a thread of its own, so that what waits for ever fails the check instead of hanging it."""
    raised: list[BaseException] = []

    def attempt() -> None:
        try:
            act()
        except BaseException as error:  # noqa: BLE001 - reported below, where it can be seen
            raised.append(error)

    thread = threading.Thread(target=attempt, daemon=True)
    began = time.monotonic()
    thread.start()
    thread.join(within_s)
    assert not thread.is_alive(), f"{what} returns at once; it still waits after {time.monotonic() - began:.1f} s"
    assert not raised, f"{what} raises {raised[0]!r}"
