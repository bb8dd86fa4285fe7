# SPDX-License-Identifier: Apache-2.0
"""The collector is as it was after a function that does without it, whatever the function did."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import pytest

from rai_missions.collector import uncollected


@pytest.fixture(autouse=True)
def _as_before() -> Iterator[None]:
    yield
    gc.enable()


@uncollected
def is_collected() -> bool:
    return gc.isenabled()


@uncollected
def fails() -> None:
    raise InterruptedError


def test_the_collector_does_not_run_within_and_runs_again_afterwards() -> None:
    assert (is_collected(), gc.isenabled()) == (False, True)


def test_it_runs_again_after_an_error() -> None:
    with pytest.raises(InterruptedError):
        fails()
    assert gc.isenabled()


def test_one_that_was_off_stays_off() -> None:
    gc.disable()
    assert (is_collected(), gc.isenabled()) == (False, False)


def test_one_within_another_leaves_it_off() -> None:
    assert uncollected(lambda: (is_collected(), gc.isenabled()))() == (False, False)
