# SPDX-License-Identifier: Apache-2.0
"""A run of the tractor's design on a page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.visualize.live.stage import Run
from tests.visualize.runs import tractor


class OrderBox:
    """Keeps the orders, and gives each the reply that was set."""

    def __init__(self) -> None:
        self.orders: list[str] = []
        self.reply: tuple[bool, str] | None = (True, "")

    def submit(self, text: str, reported: Any) -> None:
        self.orders.append(text)
        if self.reply is not None:
            reported(*self.reply)


@pytest.fixture
def run() -> Iterator[Run]:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    with Run(tractor(), OrderBox()) as made:
        made.write("battery", 0.8)
        made.start()
        yield made
