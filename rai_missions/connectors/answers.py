# SPDX-License-Identifier: Apache-2.0
"""What a service answers, now or later, as one kind of value."""

from __future__ import annotations

from concurrent.futures import Future

from rai_missions.connectors.connector import Answer, Data
from rai_missions.redaction import logger

__all__ = ("ask", "failure")

log = logger(__name__)


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


def failure(answered: Future[Data]) -> str:
    """Why a service that is done failed; empty where it did not."""
    if answered.cancelled():
        return "it gave the request up"
    fault = answered.exception()
    return f"{type(fault).__name__}: {fault}" if fault is not None else ""
