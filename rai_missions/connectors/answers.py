# SPDX-License-Identifier: Apache-2.0
"""What a service answers, now or later, as one kind of value."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from functools import partial

from rai_missions.connectors.connector import Answer, Data
from rai_missions.redaction import logger

__all__ = ("ask", "ask_for")

log = logger(__name__)


def ask_for(answer: Answer, request: Data, service: str, on_end: Callable[[Data, str], object]) -> None:
    """Have a request answered, now or later.

    Args:
        on_end: Called with the answer, and with why there is none; one of the two is empty.
    """
    try:
        data = answer(request)
    except Exception as fault:
        log.exception("%s failed", service)
        on_end({}, _words(fault))
        return
    if isinstance(data, Future):
        data.add_done_callback(partial(_end, on_end=on_end))
    else:
        on_end(data, "")


def ask(answer: Answer, request: Data, service: str) -> Future[Data]:
    """Have a request answered: a future that is done, unless the answer is to come later.

    What the service raises is logged, and is the future's exception.
    """
    done: Future[Data] = Future()
    try:
        data = answer(request)
    except Exception as fault:
        log.exception("%s failed", service)
        done.set_exception(fault)
        return done
    if isinstance(data, Future):
        return data
    done.set_result(data)
    return done


def _end(answered: Future[Data], on_end: Callable[[Data, str], object]) -> None:
    if answered.cancelled():
        on_end({}, "it gave the request up")
    elif (fault := answered.exception()) is not None:
        on_end({}, _words(fault))
    else:
        on_end(answered.result(), "")


def _words(fault: BaseException) -> str:
    return f"{type(fault).__name__}: {fault}"
