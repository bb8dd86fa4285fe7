# SPDX-License-Identifier: Apache-2.0
"""An error reads the same wherever it arrives: copied, or out of a process of a pool."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions import Chart, dump
from rai_missions.agents import run
from rai_missions.check import check
from rai_missions.errors import ConnectorError, DefinitionError, Fault, MissionError, UsageError, nearest
from rai_missions.profile import Robot, missing
from rai_missions.prove import prove
from visualize import difference, draw, show

ERRORS = st.one_of(
    st.builds(DefinitionError, st.lists(st.builds(Fault, st.text(), st.text()), min_size=1), st.text()),
    *(st.builds(each, st.text()) for each in (MissionError, UsageError, ConnectorError)),
)


def pickled(error: MissionError) -> Any:
    return pickle.loads(pickle.dumps(error))


@pytest.mark.parametrize("arrive", [copy.copy, copy.deepcopy, pickled], ids=["copied", "deeply", "pickled"])
@given(error=ERRORS)
def test_an_error_reads_the_same_everywhere(arrive: Callable[[MissionError], Any], error: MissionError) -> None:
    same = arrive(error)
    assert type(same) is type(error) and str(same) == str(error) and vars(same) == vars(error)


@pytest.mark.parametrize(
    ("word", "meant"),
    [("seq", "sequence"), ("sel", "selector"), ("suceeded", "succeeded"), ("re", ""), ("retr", "retry"), ("xyz", "")],
)
def test_the_beginning_of_a_name_means_it_before_a_similar_one(word: str, meant: str) -> None:
    assert nearest(word, ["set", "sequence", "selector", "succeeded", "retry", "repeat"]) == meant


TAKERS: dict[str, Callable[[Any], object]] = {
    "Chart": Chart,
    "check": check,
    "difference": lambda given: difference(given, given),
    "dump": dump,
    "draw": lambda given: draw(given, "out.svg"),
    "missing": lambda given: missing(given, Robot("bench")),
    "prove": prove,
    "run": lambda given: run(given),
    "show": show,
}


@pytest.mark.parametrize("taker", TAKERS)
@pytest.mark.parametrize("given", [{}, {"name": "m"}, 3, b"m"], ids=repr)
def test_what_is_no_mission_is_refused_by_whatever_takes_one(taker: str, given: Any) -> None:
    with pytest.raises(UsageError, match=r" takes a Mission, not .*; load\(FILE\) makes one of a file"):
        TAKERS[taker](given)
