# SPDX-License-Identifier: Apache-2.0
"""Looks up in a robot's documents what a person asks, on a thread of its own.

Rule: nothing waits for it, and what goes wrong with a document costs one answer.
"""

from __future__ import annotations

from collections.abc import Callable

from rai_missions.connectors.worker import Worker
from rai_missions.conversation import DocumentQuote, FoundQuotes, LookUp
from rai_missions.embodiment.excerpt import excerpt
from rai_missions.embodiment.library import Library
from rai_missions.errors import raised_text
from rai_missions.redaction import first_line, logger

__all__ = ("DocumentSearch", "OnFound")

log = logger(__name__)
OnFound = Callable[[FoundQuotes], None]
"""Receives once, from any thread, what was found."""


class DocumentSearch:
    """Answers the looks of a dialogue. Its library opens with the first of them, and is indexed then if need be.

    Args:
        library: The documents of the robot's identity.
    """

    def __init__(self, library: Library) -> None:
        self._library = library
        self._worker = Worker("documents")

    def ask(self, request: LookUp, on_found: OnFound) -> None:
        """Have a question looked up; never waits."""
        if not self._worker.post(lambda: on_found(self._found(request))):
            on_found(FoundQuotes(request.number, failed="the conversation has ended"))

    def stop(self, within_s: float = 1.0) -> None:
        """Look up nothing more; a look that hangs keeps its thread."""
        self._worker.close(within_s)

    def _found(self, request: LookUp) -> FoundQuotes:
        try:
            found = self._library.recall(request.text)
        except Exception as error:  # noqa: BLE001 - whatever a document, an index or a package for vectors does
            why = first_line(raised_text(error))
            log.warning("the robot's documents cannot be looked up: %s", why)
            return FoundQuotes(request.number, failed=why)
        parts = [(each.source, *excerpt(each.text, request.text)) for each in found.passages]
        most = max((score for _, _, score in parts), default=0)
        best = [part for part in parts if part[2] == most] if most else parts[:1]
        return FoundQuotes(request.number, tuple(DocumentQuote(source, text) for source, text, _ in best))
