# SPDX-License-Identifier: Apache-2.0
"""While much is built, or a mission runs, garbage is searched for in less; whatever is nested, then as before."""

from __future__ import annotations

import gc
import threading
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.mission.garbage import FEW, MUCH, few_collections, set_apart

USUAL = (700, 10, 10)


@pytest.fixture(autouse=True)
def as_before() -> Iterator[None]:
    before, was_on = gc.get_threshold(), gc.isenabled()
    gc.set_threshold(*USUAL)
    yield
    gc.set_threshold(*before)
    (gc.enable if was_on else gc.disable)()


@given(st.lists(st.booleans(), max_size=12))
def test_only_the_last_that_is_building_brings_the_thresholds_back(begins: list[bool]) -> None:
    building: list[ExitStack] = []
    for begin in begins:
        if begin:
            building.append(ExitStack())
            building[-1].enter_context(few_collections())
        elif building:
            building.pop(0).close()  # in the order of threads, not of nesting
        assert gc.get_threshold() == (FEW if building else USUAL)
    for each in building:
        each.close()
    assert gc.get_threshold() == USUAL


def test_threads_that_build_at_once_leave_the_thresholds_as_they_were() -> None:
    gate = threading.Barrier(4)

    def build() -> None:
        gate.wait()
        for _ in range(200):
            with few_collections():
                assert gc.get_threshold() == FEW

    threads = [threading.Thread(target=build) for _ in range(4)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert gc.get_threshold() == USUAL


@pytest.mark.parametrize("thresholds", [(0, 10, 10), (2 * FEW[0], 5, 5)])
def test_what_searches_more_rarely_already_is_left_alone(thresholds: tuple[int, int, int]) -> None:
    gc.set_threshold(*thresholds)
    with few_collections():
        assert gc.get_threshold() == thresholds
    assert gc.get_threshold() == thresholds


def test_collection_that_is_switched_off_stays_so() -> None:
    gc.disable()
    with few_collections():
        assert not gc.isenabled() and gc.get_threshold() == USUAL
    assert not gc.isenabled()


def test_what_was_frozen_stays_frozen() -> None:
    gc.freeze()
    try:
        frozen = gc.get_freeze_count()
        with few_collections():
            built = [[number] for number in range(2 * MUCH)]
        assert gc.get_freeze_count() > frozen - 1000 and frozen and built  # a thread may drop some meanwhile
    finally:
        gc.unfreeze()


def test_where_little_was_built_the_frozen_are_not_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    gc.collect()
    monkeypatch.delattr(gc, "get_freeze_count")  # it looks at each of them
    with few_collections():
        built = [[number] for number in range(10)]
    assert built


def test_an_error_brings_the_thresholds_back() -> None:
    with pytest.raises(KeyError), few_collections():
        raise KeyError
    assert gc.get_threshold() == USUAL


def test_what_a_mission_of_thousands_of_states_is_made_of_is_not_searched() -> None:
    with few_collections():
        before = [each["collections"] for each in gc.get_stats()]
        built = [[number] for number in range(400_000)]
        assert [each["collections"] for each in gc.get_stats()] == before
    assert len(built) == 400_000


def test_garbage_of_the_meantime_is_found_later() -> None:
    class Circle:
        """Refers to itself."""

        def __init__(self) -> None:
            self.me = self

    with few_collections():
        for _ in range(1_000):
            Circle()
    gc.collect()
    assert not any(isinstance(each, Circle) for each in gc.get_objects())


def is_searched(given: object) -> bool:
    return any(each is given for each in gc.get_objects())


@pytest.fixture
def thawed() -> Iterator[None]:
    """As in a process of its own: the tests' own has frozen what it has loaded."""
    was_frozen = gc.get_freeze_count()
    gc.unfreeze()
    yield
    if was_frozen:
        gc.freeze()


@pytest.mark.usefixtures("thawed")
def test_no_search_visits_what_lives_already_until_it_is_over() -> None:
    before = [object()]
    with set_apart():
        later = [object()]
        assert not is_searched(before) and is_searched(later)
    assert is_searched(before) and is_searched(later)
    with pytest.raises(KeyError), set_apart():
        raise KeyError
    assert not gc.get_freeze_count()


@pytest.mark.usefixtures("thawed")
def test_what_an_application_has_frozen_is_left_to_it() -> None:
    gc.freeze()
    later = [object()]
    with set_apart():
        assert is_searched(later)
    assert gc.get_freeze_count()
    gc.unfreeze()
