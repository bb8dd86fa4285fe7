# SPDX-License-Identifier: Apache-2.0
"""Following a run step by step leads to the same view, however it is followed."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine.step import Move, Step
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.mission.mission import Mission
from tests.node.scenes import mission as errand
from tests.visualize.live.stage import Run
from tests.visualize.page.reading import HOSTILE
from tests.visualize.runs import tractor
from visualize.live import RunScene
from visualize.live.as_json import LONGEST, bounded, line

SEEN = {"kind": "log", "distance_m": 4.0, "height_m": 0.1, "living": False}
HAPPENINGS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "anomaly": ("anomaly", "event", {}), "go": ("go", "event", {}), "ask": ("ask", "event", {}),
    "unknown": ("nonsense", "event", {}),
    "obstacle": ("obstacle", "write", {"value": SEEN}), "battery": ("battery", "write", {"value": 0.7}),
    "empty": ("battery", "write", {"value": 0.1}), "old": ("battery", "write", {"value": 0.9, "stamp": 0.5}),
    "agent": ("agent", "control", {"by": "mission"}),
    "operator": ("operator", "control", {"by": "operator", "role": "operator"}),
    "autonomy": ("autonomy", "control", {"by": "operator", "role": "operator"}), "king": ("king", "control", {}),
    "pause": ("pause", "command", {"by": "x"}), "resume": ("resume", "command", {"by": "x"}),
    "cancel": ("cancel", "command", {"by": "x"}), "kill": ("kill", "command", {"by": "x"}),
    "time": ("tick", "tick", {}),
}  # fmt: skip
ANSWERS = ("replan", "abort", "left", "right", "no_option")
ACTS = st.one_of(st.sampled_from(sorted(HAPPENINGS)), st.sampled_from(ANSWERS))


def play(run: Run, act: str) -> None:
    if act in HAPPENINGS:
        name, kind, data = HAPPENINGS[act]
        run.send(name, kind, **data)
    else:
        number = max((step.question.number for step in run.steps if step.question), default=1)
        run.send("operator", "proposal", number, option=act, parameters={})


def shown(scene: RunScene) -> dict[str, Any]:
    reported = scene.whole()
    return {name: reported[name] for name in ("mode", "control", "active", "board")}


@given(st.sampled_from([tractor(), errand()]), st.lists(ACTS, max_size=25))
def test_what_is_followed_is_where_the_run_is(mission: Mission, acts: list[str]) -> None:
    run = Run(mission)
    followed = run.look()
    run.start()
    for act in acts:
        play(run, act)
    for step in run.steps:
        followed.take(step)
    assert shown(followed) == run.whole
    assert followed.outcome == (run.chart.outcome or "")
    asked = set(followed.questions)
    assert asked == {n for n in run.chart.awaited if any(s.question and s.question.number == n for s in run.steps)}


@given(st.lists(ACTS, max_size=20), st.integers(0, 20), st.integers(0, 20), st.integers(0, 5))
def test_a_look_in_the_middle_and_the_steps_around_it_lead_to_the_same(
    acts: list[str], at: int, back: int, older: int
) -> None:
    run = Run(tractor())
    run.start()
    for act in acts[:at]:
        play(run, act)
    followed = run.look()
    followed.seq = max(0, followed.seq - older)  # the engine continued while it was looked at
    for act in acts[at:]:
        play(run, act)
    for step in run.steps[max(0, at - back - older) :]:
        followed.take(step)
    assert shown(followed) == run.whole


@given(st.lists(ACTS, max_size=20), st.data())
def test_changes_reported_at_any_moments_add_up_to_the_whole(acts: list[str], data: st.DataObject) -> None:
    run = Run(tractor())
    followed = run.look()
    seen = followed.whole()
    run.start()
    for act in acts:
        play(run, act)
    for step in run.steps:
        followed.take(step)
        if data.draw(st.booleans()):
            change = followed.change(board=data.draw(st.booleans()))
            seen["board"] |= change.pop("board", {})
            seen["steps"] += change.pop("steps", [])
            seen |= change
    change = followed.change()
    seen["board"] |= change.pop("board", {})
    seen["steps"] += change.pop("steps", [])
    assert seen | change == followed.whole()
    assert followed.change() == {}


def test_a_paused_question_has_the_time_left_that_it_had() -> None:
    run = Run(errand())
    followed = run.look()
    run.start()
    play(run, "ask")
    play(run, "pause")
    run.send("tick", "tick", after_s=50.0)
    play(run, "resume")
    for step in run.steps:
        followed.take(step)
    [question] = followed.questions.values()
    assert question.until == question.at + 600 + 51


def test_who_paused_before_the_process_is_kept_where_a_run_is_resumed() -> None:
    run = Run(errand())
    run.start()
    play(run, "pause")
    followed = run.look()
    followed.paused_by = "operator Anna (page)"
    followed.recall_order(run.steps[-1]._replace(event=Event("take_up", 1.0, {}, "command")))
    assert (followed.mode, followed.paused_by) == ("paused", "operator Anna (page)")


JSON = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(), st.sampled_from(HOSTILE)),
    lambda inner: st.one_of(st.lists(inner, max_size=60), st.dictionaries(st.text(), inner, max_size=60)),
)


@given(JSON)
def test_no_value_makes_a_message_long_or_no_json(value: Any) -> None:
    reported = json.dumps(bounded(value), allow_nan=False)
    assert json.loads(reported) == bounded(value)
    assert len(json.dumps(bounded(["x" * 10**6] * 1000))) < 50 * 6 * LONGEST


def test_a_picture_is_reported_by_its_name_alone() -> None:
    image = Image("camera@1", 4, 3, "rgb8", lambda: (_ for _ in ()).throw(AssertionError("it was looked at")))
    assert bounded({"seen": image}) == {"seen": {"picture": "camera@1", "width": 4, "height": 3, "encoding": "rgb8"}}


@pytest.mark.parametrize(
    ("wake_at", "then"), [(1.0, "continues at once"), (None, "waits for the next event that concerns it")]
)
def test_a_line_names_the_tree_that_rests_at_its_limit(wake_at: float | None, then: str) -> None:
    found = line(
        Step(3, 1.0, Event("go", 1.0), (Move(("/transitions/0",), (), ()),), wake_at=wake_at, resting=("work",))
    )
    assert found is not None
    assert found["notes"] == [f"the tree of 'work' has gone round as far as a step allows; it {then}"]
