# SPDX-License-Identifier: Apache-2.0
"""What is shown as closed is what the rules would refuse, and nothing is asked of a program's own predicates."""

from __future__ import annotations

from typing import Any

from hypothesis import given, settings
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
    "soon": {"not": {"elapsed_s": 4}},
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


IN_STATE = asking({"control": "autonomy", "decision": ASKED, "transitions": ROWS})
IN_TREE = asking({"control": "autonomy", "timeout_s": 900,
                  "tree": {"sequence": [{"decision": ASKED, "then": {"free": {"wait_s": 1}}}]},
                  "transitions": [{"on": ["succeeded", "failed"], "to": "over"}]})  # fmt: skip
HAPPENS = st.lists(st.tuples(st.floats(0.0, 3.0), st.none() | st.integers(0, 9)), max_size=5)
OPERATOR = {"by": "operator", "role": "operator"}
STOPS = (
    Event("pause", 0.0, OPERATOR, "command"), Event("resume", 0.0, OPERATOR, "command"),
    Event("operator", 0.0, OPERATOR, "control"), Event("autonomy", 0.0, OPERATOR, "control"),
)  # fmt: skip
STOPPED = st.lists(
    st.tuples(st.sampled_from((0.0, 0.5, 3.0, 5.0)), st.sampled_from((None, 1, 7, *STOPS))), min_size=2, max_size=5
)


@settings(max_examples=8 * settings.default.max_examples)
@given(st.sampled_from((IN_STATE, IN_TREE)), HAPPENS, STOPPED)
def test_an_option_is_closed_exactly_where_its_answer_would_be_refused(
    mission: Mission, before: list[tuple[float, int | None]], after: list[tuple[float, Any]]
) -> None:
    """In a pause or while the operator has control: refused once the run continues, which it does at once."""
    chart, at = Chart(mission, ticker=CompiledTrees()), 0.0
    for wait_s, value in before:
        at += wait_s
        if value is not None:
            chart.write("n", value, at)
    chart.start(at)
    for wait_s, value in after:
        at += wait_s
        if isinstance(value, Event):
            chart.send(value._replace(at=at))
        elif value is not None:
            chart.write("n", value, at)
    for asked in chart.questions:  # a pause withdraws that of a tree
        closed = ClosedOptions(mission).now([asked], chart.view, at, chart.still_since).get(asked.number, {})
        for offer in asked.options:
            tried = Chart.restore(mission, chart.snapshot(), ticker=CompiledTrees())
            steps = [tried.send(Event("operator", at, {"option": offer.name}, "proposal", asked.number))]
            steps += [tried.send(STOPS[1]._replace(at=at))] if tried.mode == "paused" else []
            steps += [tried.send(STOPS[3]._replace(at=at))] if tried.held_by else []
            verdict = next(verdict for step in steps for verdict in step.verdicts if verdict.option == offer.name)
            assert verdict.accepted != (offer.name in closed), (offer.name, closed, verdict)
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
    assert ClosedOptions(mission).now([question], chart.view, 100.0, chart.still_since) == {}
    assert len(asked_of) == before
