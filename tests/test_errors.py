# SPDX-License-Identifier: Apache-2.0
"""An error reads the same wherever it arrives: copied, or out of a process of a pool."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions import Chart, dump
from rai_missions.agents import run
from rai_missions.check import check
from rai_missions.errors import (
    ConnectorError,
    DefinitionError,
    Fault,
    MissionError,
    UsageError,
    meant_file,
    nearest,
    raised_text,
    without_marks,
)
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


@pytest.mark.parametrize(("name", "endings", "meant"), [
    ("misson.json", (".json",), "; did you mean '{}/mission.json'?"),
    ("Mission.json", (".json",), "; did you mean '{}/mission.json'?"),
    ("mission", (".json", ".py"), "; did you mean '{}/mission.json'?"),
    ("robto.py", (".py",), "; did you mean '{}/robot.py'?"),
    ("quite_other.json", (".json",), ""),
    ("run.jornal", (".journal",), "; did you mean '{}/run.journal'?"),
    ("no_folder/mission.json", (".json",), ""),
    ("x" * 5000, (".json",), ""),
    ("nul\0.json", (".json",), ""),
])  # fmt: skip
def test_a_file_that_is_not_there_is_answered_with_the_one_that_was_meant(
    tmp_path: Path, name: str, endings: tuple[str, ...], meant: str
) -> None:
    for each in ("mission.json", "robot.py", "run.journal"):
        (tmp_path / each).touch()
    assert meant_file(tmp_path / name, *endings) == meant.format(tmp_path)


def test_a_folder_is_answered_with_the_files_in_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for each in ("a.json", "b.py", "notes.txt"):
        (tmp_path / each).touch()
    assert meant_file(tmp_path, ".json", ".py") == "; there is: a.json, b.py"
    monkeypatch.chdir(tmp_path)
    assert meant_file("a.jsn", ".json") == "; did you mean 'a.json'?"


def test_a_file_whose_name_cannot_be_shown_is_not_meant(tmp_path: Path) -> None:
    (tmp_path / "a\x1b[2Jb.json").touch()
    (tmp_path / "a b.json").touch()
    assert meant_file(tmp_path, ".json") == "; there is: a b.json"
    assert meant_file(tmp_path / "a\x1b[2Jb.jso", ".json") == f"; did you mean '{tmp_path}/a b.json'?"
    folder = tmp_path / "c\n"
    folder.mkdir()
    (folder / "d.json").touch()
    assert "\n" not in meant_file(folder / "d.jso", ".json")


def test_letters_with_marks_are_plain_ones() -> None:
    assert without_marks("Größe ÉTÉ Łódź") == "grosse ete łodz"


class Unspeakable(Exception):
    """One that cannot state what it is."""

    def __str__(self) -> str:
        raise RuntimeError("not even that")


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (KeyError("x"), "KeyError: 'x'"),
        (TimeoutError(), "TimeoutError"),
        (Unspeakable(), "Unspeakable: a Unspeakable that cannot be put in words"),
    ],
)
def test_what_was_raised_has_its_type_and_its_text(error: Exception, text: str) -> None:
    assert raised_text(error) == text
