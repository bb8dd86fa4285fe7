# SPDX-License-Identifier: Apache-2.0
"""Taking what has arrived: one message, response or request at a time, and its callback.

Each returns whether there was one, and raises `InvalidHandle` for an entity that was destroyed.
"""

from __future__ import annotations

from concurrent.futures import Future
from contextlib import suppress
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy.subscription import Subscription

__all__ = ("answer_request", "take_message", "take_response")


def take_message(subscription: Any) -> bool:
    """Take the oldest message of a subscription."""
    with subscription.handle:
        taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
    if taken is None:
        return False
    with_info = subscription._callback_type is Subscription.CallbackType.WithMessageInfo  # noqa: SLF001
    subscription.callback(*(taken if with_info else taken[:1]))
    return True


def take_response(client: Any) -> bool:
    """Take a response of a client's server, and end the call that waits for it."""
    with client.handle:
        header, response = client.handle.take_response(client.srv_type.Response)
    if header is None:
        return False
    with suppress(KeyError):  # no one waits for it any more
        client.get_pending_request(header.request_id.sequence_number).set_result(response)
    return True


def answer_request(service: Any) -> bool:
    """Take a request of a service, and answer it; later, where its callback returns a future."""
    with service.handle:
        request, header = service.handle.service_take_request(service.srv_type.Request)
    if header is None:
        return False
    response = service.callback(request, service.srv_type.Response())
    if isinstance(response, Future):  # it is set on this thread
        response.add_done_callback(lambda later: _send_later(service, later, header))
    else:
        service.send_response(response, header)
    return True


def _send_later(service: Any, response: Future[Any], header: Any) -> None:
    with suppress(InvalidHandle):
        if response.exception() is None:
            service.send_response(response.result(), header)
