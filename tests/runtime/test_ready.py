# SPDX-License-Identifier: Apache-2.0
"""A run that waits, ready, for the command to start: nothing moves, and the arguments come with the command."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.errors import DefinitionError
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.replay.replay import replay
from tests.rigs.runs import Rig, mission

COUNTED: dict[str, Any] = {
    "counting": {"transitions": [{"when": {"key": "n", "==": 3}, "to": "three"}, {"after_s": 5, "to": "other"}]},
    "three": {"final": "aborted"},
    "other": {"final": "failed"},
}
KEYS: dict[str, Any] = {"n": {"type": "integer", "source": "argument"}}


def test_it_begins_with_the_command_and_with_its_arguments() -> None:
    rig = Rig(mission(COUNTED, blackboard=KEYS), waits=True)
    seen = list[Any]()
    rig.stage.play(
        {0.2: lambda: seen.append(rig.runner.view.mode), 0.3: lambda: seen.append(rig.runner.start({"n": 3}))}
    )
    assert rig.run().outcome == "aborted"
    assert seen == ["ready", []]
    assert [each.kind for each in rig.runner.start({"n": 3})] == ["started"]


def test_of_two_orders_to_start_before_the_run_takes_one_the_first_counts() -> None:
    rig = Rig(mission(COUNTED, blackboard=KEYS), waits=True)
    answers = list[list[str]]()

    def start(n: Any) -> None:
        answers.append([each.kind for each in rig.runner.start({"n": n})])

    rig.stage.play({0.2: lambda: [start(n) for n in ("x", 3, 7)]})
    rig.run()
    assert answers == [["unfit"], [], ["started"]]
    assert rig.runner.view.board["n"].value == 3


@given(
    st.sampled_from([None, 0.1, 0.3, 0.5]),
    st.lists(st.tuples(st.integers(1, 7), st.integers(1, 9) | st.none()), min_size=1, max_size=4),
)
def test_it_has_the_arguments_of_the_last_order_whenever_the_robot_reports_its_facts(
    fact_at: float | None, orders: list[tuple[int, int | None]]
) -> None:
    facts: dict[str, Any] = {"there": {"type": "boolean", "source": "robot"}} if fact_at else {}
    rig, given_n = Rig(mission(COUNTED, blackboard={**KEYS, **facts}), waits=True), list[int]()

    def order(n: int | None) -> None:
        if n is None:
            rig.runner.stop()
        elif not rig.runner.start({"n": n}):
            given_n.append(n)

    if fact_at:
        rig.stage.play({fact_at: lambda: rig.publish("/there", data=False)})
    for at in sorted({tenth / 10 + 0.02 for tenth, _ in orders}):
        rig.stage.play({at: lambda at=at: [order(n) for tenth, n in orders if tenth / 10 + 0.02 == at]})
    rig.stage.play({0.9: rig.runner.cancel})
    rig.run()
    if given_n:
        assert rig.runner.view.board["n"].value == given_n[-1]


def test_its_journal_replays(tmp_path: Path) -> None:
    asked = mission(COUNTED, blackboard=KEYS)
    journal = Journal.create(tmp_path / "run.journal", Header(dump(asked)))
    rig = Rig(asked, waits=True, journal=journal)
    rig.stage.play({0.2: lambda: rig.runner.start({"n": 3})})
    rig.run()
    journal.close()
    again = replay(journal.path)
    assert again.holds and again.outcome == "aborted", again.difference


def test_what_does_not_fit_is_refused_and_it_still_waits() -> None:
    rig = Rig(mission(COUNTED, blackboard=KEYS), waits=True)
    why = list[Any]()
    given: tuple[dict[str, Any], ...] = ({}, {"n": "three"}, {"m": 1, "n": 3})
    rig.stage.play(
        {
            **{at / 10: lambda each=each: why.append(rig.runner.start(each)) for at, each in enumerate(given, start=1)},
            0.5: lambda: why.append(rig.runner.view.mode),
            0.6: lambda: why.append(rig.runner.start({"n": 4})),
        }
    )
    assert rig.run().outcome == "failed"
    assert [[(each.kind, each.argument) for each in faults] for faults in why[:3]] == [
        [("missing", "n")],
        [("unfit", "n")],
        [("foreign", "m")],
    ]
    assert "needs the argument 'n'; on a command line, give --set n=…" in why[0][0].sentence
    assert why[3:] == ["ready", []]


def test_a_cancel_ends_it_before_it_has_begun() -> None:
    rig = Rig(mission(COUNTED, blackboard=KEYS), waits=True)
    rig.stage.play({0.2: rig.runner.cancel})
    assert rig.run().outcome == "canceled"


def test_without_waiting_a_missing_argument_is_refused_when_the_run_is_made() -> None:
    with pytest.raises(DefinitionError, match="needs the argument 'n'"):
        Rig(mission(COUNTED, blackboard=KEYS))
