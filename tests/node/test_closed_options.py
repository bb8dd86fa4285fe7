# SPDX-License-Identifier: Apache-2.0
"""What is shown as closed is what the rules would refuse, and nothing is asked of a program's own predicates."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.node.closed_options import ClosedOptions

GUARDS: dict[str, Any] = {
    "low": {"key": "n", "<": 3},
    "fresh": {"fresh": "n"},
    "late": {"elapsed_s": 4},
    "either": {"any": [{"key": "n", ">": 5}, {"not": {"fresh": "n"}}]},
}
ASKED = {
    "question": "Which?",
    "ask": ["operator"],
    "deadline_s": 600,
    "fallback": "out",
    "options": {**{name: {"when": guard} for name, guard in GUARDS.items()}, "free": {}, "out": {}},
}
ROWS = [{"on": name, "to": "over"} for name in (*GUARDS, "free", "out")]


def asking(state: dict[str, Any], **words: Any) -> Mission:
    return Mission.model_validate(
        {
            "name": "m", "initial": "asking", "states": {"asking": state, "over": {"final": "aborted"}},
            "blackboard": {"n": {"type": "number", "source": "robot", "max_age_s": 2, "optional": True}}, **words,
        }
    )  # fmt: skip


IN_STATE = asking({"decision": ASKED, "transitions": ROWS})
IN_TREE = asking({"tree": {"sequence": [{"decision": ASKED, "then": {"free": {"wait_s": 1}}}]}, "timeout_s": 900,
                  "transitions": [{"on": ["succeeded", "failed"], "to": "over"}]})  # fmt: skip
HAPPENS = st.lists(st.tuples(st.floats(0.0, 3.0), st.none() | st.integers(0, 9)), max_size=5)


@given(st.sampled_from((IN_STATE, IN_TREE)), HAPPENS, HAPPENS)
def test_an_option_is_closed_exactly_where_its_answer_would_be_refused(
    mission: Mission, before: list[tuple[float, int | None]], after: list[tuple[float, int | None]]
) -> None:
    chart, at = Chart(mission, ticker=CompiledTrees()), 0.0
    for wait_s, value in before:
        at += wait_s
        if value is not None:
            chart.write("n", value, at)
    asked = chart.start(at).question
    assert asked is not None
    for wait_s, value in after:
        at += wait_s
        if value is not None:
            chart.write("n", value, at)
    closed = ClosedOptions(mission).now([asked], chart.view, at).get(asked.number, {})
    for offer in asked.options:
        tried = Chart.restore(mission, chart.snapshot(), ticker=CompiledTrees())
        step = tried.send(Event("operator", at, {"option": offer.name}, "proposal", asked.number))
        is_refused = any(": refused, " in note for note in step.notes)
        assert is_refused == (offer.name in closed), (offer.name, closed, step.notes)
    assert all(why.startswith(("this does not hold: ", "this is unknown: ")) for why in closed.values())


def test_a_predicate_of_a_program_is_the_engine_s_alone_to_ask() -> None:
    options = {"named": {"when": {"all": [{"named": "is_fine"}, {"key": "n", "<": 3}]}}, "out": {}}
    mission = asking({"decision": ASKED | {"options": options},
                      "transitions": [{"on": "named", "to": "over"}, {"on": "out", "to": "over"}]})  # fmt: skip
    asked_of: list[object] = []

    def is_fine(board: object) -> bool:
        asked_of.append(board)
        return True

    chart = Chart(mission, named={"is_fine": is_fine})
    chart.write("n", 1, 0.0)
    question = chart.start(0.0).question
    assert question is not None and [offer.name for offer in question.options] == ["named", "out"]
    before = len(asked_of)
    assert ClosedOptions(mission).now([question], chart.view, 100.0) == {}
    assert len(asked_of) == before
