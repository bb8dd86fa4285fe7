# SPDX-License-Identifier: Apache-2.0
"""What a program gives to a public function is of the type that it takes, or refused in a sentence that names it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rai_missions import Chart, Mission, UsageError, load
from rai_missions.agents import run
from rai_missions.agents.run_config import MAPPINGS
from rai_missions.check import check
from rai_missions.journal import Header, Journal, read, verify
from rai_missions.prove import prove
from rai_missions.replay.open_run import open_run

MISSION = Mission.model_validate(
    {"format": 1, "name": "a", "version": "1", "initial": "x", "states": {"x": {"final": "aborted"}}}
)
NO_PATHS: tuple[Any, ...] = (5, 0.5, True, b"x", [1], {"a": 1}, object(), print, Exception)
NO_NAMES: tuple[Any, ...] = (5, 0.5, True, "x", b"x", [1], {1: 2}, object(), print, Exception)

Door = Callable[[Any], object]


def option(word: str) -> tuple[str, Door]:
    return word, lambda given: run(MISSION, **{word: given})


PATHS: list[tuple[str, Door]] = [
    *map(option, ("journal", "record", "resume")),
    ("load", load),
    *(("a journal", door) for door in (read, verify, Journal.open, open_run)),
    ("a journal", lambda given: Journal.create(given, Header("{}"))),
]
NAMES: list[tuple[str, Door]] = [
    *map(option, MAPPINGS),
    ("named", lambda given: Chart(MISSION, named=given)),
    ("restore", lambda given: Chart.restore(MISSION, given)),
]
OTHERS: list[tuple[str, Door]] = [
    *map(option, ("waits", "seed", "on_step", "on_status", "connector", "opened")),
    ("named", lambda given: check(MISSION, named=given)),
    ("start", lambda given: Chart(MISSION).start(given)),
    ("write", lambda given: Chart(MISSION).write(given, 1)),
    ("terms", lambda given: prove(MISSION, terms=given)),
]


@pytest.mark.parametrize(
    ("word", "door", "given"),
    [
        (word, door, given)
        for doors, values in ((PATHS, NO_PATHS), (NAMES, NO_NAMES), (OTHERS, (object(),)))
        for word, door in doors
        for given in values
    ],
)
def test_what_a_function_does_not_take_is_refused_by_its_word(word: str, door: Door, given: Any) -> None:
    with pytest.raises(UsageError, match=rf"^(a key of )?{word} takes "):
        door(given)
