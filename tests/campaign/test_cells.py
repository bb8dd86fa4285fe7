# SPDX-License-Identifier: Apache-2.0
"""The names of cells: each input counts, nothing else does."""

from __future__ import annotations

import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.campaign.cells import ORDERS, Cell, cells_of, code_digest, digest, ordered
from rai_missions.errors import UsageError

CELL = Cell("tractor", "branch_7", 7, "rules", "none", "written")
DIGESTS = {"mission": "a", "scene": "b", "model": "c", "embodiment": "d", "code": "e"}
names = st.text("abc_", min_size=1, max_size=4)


@given(st.builds(Cell, names, names, st.integers(0, 3), names, names, st.sampled_from(ORDERS)),
       st.builds(Cell, names, names, st.integers(0, 3), names, names, st.sampled_from(ORDERS)))  # fmt: skip
def test_two_cells_have_one_key_only_if_they_are_one(one: Cell, other: Cell) -> None:
    assert (one.key(DIGESTS) == other.key(DIGESTS)) == (one == other)


@pytest.mark.parametrize("name", DIGESTS)
def test_each_input_changes_the_key(name: str) -> None:
    assert CELL.key(DIGESTS) != CELL.key({**DIGESTS, name: "other"})


def test_another_process_gives_the_same_key() -> None:
    code = (
        "from rai_missions.campaign.cells import Cell, code_digest; "
        f"print(Cell(*{tuple(CELL)!r}).key({dict(reversed(DIGESTS.items()))!r}), code_digest())"
    )
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert printed == [CELL.key(DIGESTS), code_digest()]


@given(st.dictionaries(names, st.integers()))
def test_a_digest_is_of_the_content_whatever_the_order_of_its_keys(value: dict[str, int]) -> None:
    assert digest(value) == digest(dict(reversed(value.items())))
    assert digest(value) != digest({**value, "more": 1})


@given(st.lists(names, unique=True, max_size=5), st.sampled_from(ORDERS))
def test_an_order_shows_each_option_once(options: list[str], order: str) -> None:
    assert sorted(ordered(options, order)) == sorted(options)
    assert ordered(options, "written") == tuple(options)


def test_orders_are_what_their_names_promise() -> None:
    assert [ordered("abc", order) for order in ORDERS] == [tuple(each) for each in ("abc", "cba", "bca", "cab", "abc")]


@pytest.mark.parametrize("order", ["backwards", "rotated_", "rotated_x", "reversed_1"])
def test_an_order_that_there_is_not_is_refused(order: str) -> None:
    with pytest.raises(UsageError, match=f"no order of options '{order}'; there is: written, reversed"):
        ordered("abc", order)


def test_a_campaign_asks_every_model_in_a_scene_before_the_next_scene() -> None:
    cells = list(cells_of("m", [("one", 1), ("two", 2)], ["x", "y"], ["none", "description"], ["written"]))
    assert [cell.scene for cell in cells] == ["one"] * 4 + ["two"] * 4
    assert len(set(cells)) == 8 and {cell.seed for cell in cells if cell.scene == "two"} == {2}
