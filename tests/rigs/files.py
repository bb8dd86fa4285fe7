# SPDX-License-Identifier: Apache-2.0
"""More open files than `select.select` takes, as a program may have that hosts a mission, and a disk that is full."""

from __future__ import annotations

import contextlib
import os
import resource
from collections.abc import Iterator

import pytest

__all__ = ("largest_file", "many_files")

SELECTABLE = 1024


@contextlib.contextmanager
def largest_file(size: int) -> Iterator[None]:
    """No file of this process grows beyond so many bytes, as on a disk that is full."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.fixture
def many_files() -> Iterator[None]:
    """Each file that is opened has a number that `select.select` refuses."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    with contextlib.ExitStack() as opened:
        opened.callback(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, 2 * SELECTABLE), hard))
        file = 0
        while file < SELECTABLE:
            file = os.dup(0)
            opened.callback(os.close, file)
        yield
