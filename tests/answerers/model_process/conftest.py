# SPDX-License-Identifier: Apache-2.0
"""A provider whose models are hostile, found as any other provider is: by the name of its package."""

from __future__ import annotations

import uuid
from collections.abc import Iterator

import pytest

from tests.answerers.model_process.processes import EXIT_S, MARK, PROVIDERS, patient


@pytest.fixture
def mark(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """By which the processes of a test are known; after it none is left."""
    mark = uuid.uuid4().hex
    monkeypatch.setenv(MARK, mark)
    monkeypatch.setenv("HOSTILE_API_KEY", "the-key-of-the-hostile-provider-4711")
    monkeypatch.syspath_prepend(str(PROVIDERS))
    yield mark
    assert patient(mark, EXIT_S) == []
