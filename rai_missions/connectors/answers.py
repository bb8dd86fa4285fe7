# SPDX-License-Identifier: Apache-2.0
"""What serves a service or an action, and what a service answers, now or later, as one kind of value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any

from rai_missions.connectors.connector import ActionServer, Answer, Data
from rai_missions.errors import raised_text
from rai_missions.given import check_function, check_given
from rai_missions.redaction import logger

__all__ = ("ask", "ask_for", "check_action_server", "check_answer")

log = logger(__name__)


def check_answer(answer: object, service: str) -> None:
    """Raise a `UsageError` for what cannot answer a request."""
    check_function(answer, f"the service {service}", "a function of a request")


def check_action_server(server: object, action: str) -> None:
    """Raise a `UsageError` for what is no `ActionServer`."""
    wanted = "an object with accept(goal_id, goal, report) and cancel(goal_id)"
    check_given(server, ActionServer, f"the action {action}", wanted)


def ask_for(answer: Answer, request: Data, service: str, on_end: Callable[[Data, str], object]) -> None:
    """Have a request answered, now or later.

    Args:
        on_end: Called with the answer, and with why there is none; one of the two is empty.
    """
    try:
        data: Any = answer(request)
    except (Exception, SystemExit) as fault:
        log.exception("%s failed", service)
        on_end({}, raised_text(fault))
        return
    if isinstance(data, Future):
        data.add_done_callback(partial(_end, service=service, on_end=on_end))
    else:
        _pass_on(data, service, on_end)


def ask(answer: Answer, request: Data, service: str) -> Future[Data]:
    """Have a request answered: a future that is done, unless the answer is to come later.

    What the service raises is logged, and is the future's exception.
    """
    done: Future[Data] = Future()
    try:
        data = answer(request)
    except (Exception, SystemExit) as fault:
        log.exception("%s failed", service)
        done.set_exception(fault)
        return done
    if isinstance(data, Future):
        return data
    done.set_result(data)
    return done


def _end(answered: Future[Any], service: str, on_end: Callable[[Data, str], object]) -> None:
    if answered.cancelled():
        on_end({}, "it gave the request up")
    elif (fault := answered.exception()) is not None:
        on_end({}, raised_text(fault))
    else:
        _pass_on(answered.result(), service, on_end)


def _pass_on(data: Any, service: str, on_end: Callable[[Data, str], object]) -> None:
    if isinstance(data, Mapping):
        on_end(data, "")
    else:  # what a function without `return` gives
        on_end({}, f"{service} has answered with {type(data).__name__}; return a dict of its fields, or {{}}")
