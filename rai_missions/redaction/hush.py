# SPDX-License-Identifier: Apache-2.0
"""Keeps secrets out of this project's part of the log, its tracebacks included."""

from __future__ import annotations

import logging
import traceback
from collections.abc import Callable, Iterable
from typing import Any

from rai_missions.redaction.redact import Redaction, keep_secret, redacted

__all__ = ("hush",)

PACKAGES = ("rai_missions", "visualize")
"""Whose loggers are hushed, those too that are made later."""


class _Hush:
    """Makes records of what is logged, this project's without secrets, tracebacks included.

    Args:
        before: What made them until now.
    """

    def __init__(self, before: Callable[..., logging.LogRecord]) -> None:
        self._before = before

    def __call__(self, *given: Any, **words: Any) -> logging.LogRecord:
        record = self._before(*given, **words)
        if record.name.split(".")[0] in PACKAGES:
            _clean(record)
        return record


def _clean(record: logging.LogRecord) -> None:
    """Take the secrets out of a record; one that holds none is left as it is."""
    try:
        said = record.getMessage()
    except Exception:  # noqa: BLE001 - what is logged may be anybody's, and raise anything
        record.msg, record.args = f"{record.msg} (what stands here cannot be told in words)", None
        said = record.getMessage()
    if (clean := redacted(said)) != said:
        record.msg, record.args = clean, None
    if record.exc_info and record.exc_info[0] is not None:
        trace = "".join(traceback.format_exception(*record.exc_info)).rstrip()
        if (clean := redacted(trace)) != trace:
            record.exc_info, record.exc_text = None, clean


def hush(secrets: Iterable[str] = ()) -> Redaction:
    """Keep secrets out of this project's part of the log, from now on; may be called again.

    Args:
        secrets: Further values never to be shown.

    Returns:
        What hides elsewhere whatever was ever told here.
    """
    keep_secret(secrets)
    if not isinstance(before := logging.getLogRecordFactory(), _Hush):
        logging.setLogRecordFactory(_Hush(before))
    return Redaction()
