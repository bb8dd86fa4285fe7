# SPDX-License-Identifier: Apache-2.0
"""A run as a person reads it, line by line."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from typing import Any, get_args

import pytest
from rich.console import Console

from rai_missions.cli.live_terminal import MOST_HELD, Screen
from rai_missions.cli.progress import Lines
from rai_missions.engine import Chart
from rai_missions.engine.decision import Question
from rai_missions.engine.modes import Mode
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.result import Result
from tests.rigs.runs import by_hand

MISSION = Mission.model_validate(
    {
        "name": "m",
        "blackboard": {
            name: {"type": "number", "source": "robot", "max_age_s": 5} for name in ("battery", "camera", "heading")
        },
        "events": {"stop_now": {}},
        "initial": "a",
        "states": {"a": {"transitions": [{"on": "stop_now", "to": "z"}]}, "z": {"final": "aborted"}},
    }
)


def lines_before_the_start(kind: type[Lines], *, verbose: bool = False) -> list[str]:
    out, chart = io.StringIO(), Chart(MISSION)
    lines = kind(MISSION, out, verbose=verbose)
    lines.watch(by_hand(chart).view)
    lines.step(chart.write("heading", 1.0, 0.0))
    for number in range(10):
        lines.step(chart.send(Event("stop_now", 0.5 + number / 10)))
    lines.step(chart.write("battery", 0.5, 2.0))
    lines.step(chart.write("camera", 1.0, 2.0))
    lines.step(chart.send(Event("stop_now", 2.1)))
    lines.step(chart.start(2.2))
    lines.step(chart.send(Event("stop_now", 3.0)))
    lines.close()
    return [line for line in out.getvalue().splitlines() if "stop_now" in line or "robot" in line or "not been" in line]


@pytest.mark.parametrize("kind", [Lines, Screen])
def test_what_happens_before_the_start_is_one_line_that_states_what_is_waited_for(kind: type[Lines]) -> None:
    waiting, moved = lines_before_the_start(kind)
    assert "0.50 s  waiting for the robot: battery, camera" in waiting
    assert "stop_now" in moved and "a → z" in moved


def test_who_wants_every_step_sees_every_step() -> None:
    ignored = [line for line in lines_before_the_start(Lines, verbose=True) if "has not been started" in line]
    assert len(ignored) == 11


@pytest.mark.parametrize("message", ["[/red]", "[link=file:///etc/passwd]here[/link]", "[bold", "\x1b[2J"])
def test_what_a_robot_reports_is_shown_as_it_was_reported_and_never_as_markup(message: str) -> None:
    mission = Mission.model_validate(
        {
            "name": "m", "blackboard": {"spoken": {"type": "string", "source": "robot"}}, "initial": "a",
            "states": {"a": {"final": "aborted"}},
        }
    )  # fmt: skip
    out, chart = io.StringIO(), Chart(mission)
    screen = Screen(mission, out)
    screen.watch(by_hand(chart).view)
    chart.write("spoken", message, 0.0)
    foot = Console(file=out, width=200)
    foot.print(screen._foot(0.0))
    assert message.replace("\x1b", " ").strip() in out.getvalue()


ASKED = Mission.model_validate(
    {
        "name": "m", "initial": "asking",
        "states": {
            "asking": {
                "decision": {"question": "Which?", "options": {"left": {}, "right": {}}, "fallback": "right",
                             "ask": ["agent", "operator", "rules"], "deadline_s": 5},
                "transitions": [{"on": "left", "to": "over"}, {"on": "right", "to": "asking"}],
            },
            "over": {"final": "aborted"},
        },
    }
)  # fmt: skip


def test_what_the_answer_to_a_tree_starts_is_shown_as_what_any_other_event_starts() -> None:
    call = {"call": "horn", "timeout_s": 2}
    tree = {"decision": {"question": "Now?", "options": {"yes": {}, "no": {}}, "fallback": "no", "deadline_s": 5,
                         "ask": ["rules", "agent"]}, "then": {"yes": call, "no": {"wait_s": 1}}}  # fmt: skip
    ends = {"transitions": [{"on": ["succeeded", "failed"], "to": "over"}]}
    mission = Mission.model_validate(
        {"name": "m", "initial": "a", "states": {"a": {"tree": tree, **ends}, "over": {"final": "aborted"}}}
    )
    out, chart = io.StringIO(), Chart(mission, CompiledTrees())
    lines = Lines(mission, out)
    chart.start(0.0)
    for answer, by in (("perhaps", "rules"), ("yes", "agent")):
        (question,) = chart.questions
        lines.step(chart.propose(question.number, answer, by=by, at=1.0))
    rows = [line for line in out.getvalue().splitlines() if " s  " in line]
    assert [row.split("  ")[-1].strip() for row in rows if "answered" in row] == ["call horn (number 3)"]


@pytest.mark.parametrize("kind", [Lines, Screen])
def test_answerers_that_are_absent_are_one_line_of_the_run_and_none_of_a_question(kind: type[Lines]) -> None:
    out, chart = io.StringIO(), Chart(ASKED)
    lines = kind(ASKED, out)
    lines.begin("", ["rules"], "", model=None)
    steps = [chart.start(0.0)]
    for answer in ("absent", "absent", "right", "absent", "absent", "left"):
        (question,) = chart.questions
        data = {"absent": f"there is no answerer '{question.asked}'"} if answer == "absent" else {"option": answer}
        steps.append(chart.send(Event(question.asked, 0.0, data, "proposal", question.number)))
    for step in steps:
        lines.step(step)
    printed = out.getvalue()
    head, _, body = printed.partition("\n\n")
    skipped = "the model (no model configured; use --model), the operator (--no-operator,"
    assert f"answered by: the fixed rules; skipped: {skipped}" in head.replace("\n", " ")
    assert "agent" not in body and "operator" not in body and "absent" not in body
    assert body.count(" to the fixed rules") == 2 and body.count("accepted") == 2
    assert sum(step.questions for step in steps) == 2


BLINKING = Mission.model_validate(
    {
        "name": "m", "initial": "both",
        "states": {
            "both": {
                "parallel": {
                    "question": {"initial": "asking", "states": {**ASKED.written()["states"], "asking": {
                        **ASKED.written()["states"]["asking"],
                        "decision": {**ASKED.written()["states"]["asking"]["decision"], "ask": ["operator"]},
                    }}},
                    "lamp": {"initial": "lit", "states": {
                        "lit": {"transitions": [{"after_s": 1, "to": "dark"}]},
                        "dark": {"transitions": [{"after_s": 1, "to": "lit"}]},
                    }},
                },
            },
        },
    }
)  # fmt: skip


class SilentPerson:
    """Someone at the terminal who thinks."""

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None: ...
    def withdraw(self, number: int) -> None: ...
    def stop(self) -> None: ...


@pytest.mark.parametrize("is_there", [True, False])
def test_while_a_person_is_asked_lines_of_steps_wait_for_the_answer(is_there: bool) -> None:
    out, chart = io.StringIO(), Chart(BLINKING)
    screen = Screen(BLINKING, out)
    if is_there:
        screen.lend(SilentPerson())
    screen.watch(by_hand(chart).view)
    screen.step(chart.start(0.0))
    assert "→ both" in out.getvalue(), "the step that asks is printed above the question"
    assert ("question: Which?" in out.getvalue()) is not is_there, "the prompt of the person has it"
    for second in range(1, 4):
        screen.step(chart.send(Tick(float(second))))
    assert ("lit → dark" in out.getvalue()) is not is_there
    (question,) = chart.questions
    screen.step(chart.send(Event("operator", 3.5, {"option": "left"}, "proposal", question.number)))
    printed = out.getvalue()
    assert printed.index("lit → dark") < printed.index("dark → lit") < printed.index("asking → over")
    screen.close()


@pytest.mark.parametrize("mode", get_args(Mode))
def test_the_mode_in_the_foot_has_the_colour_of_its_line(mode: Mode, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")
    out, chart = io.StringIO(), Chart(MISSION)
    screen = Screen(MISSION, out)
    screen.watch(by_hand(chart).view)
    screen.status(Status(1, mode, "autonomy", ()))
    screen.step(chart.start(0.0))
    screen.close()
    good, bad, other = "1;32", "1;31", "1;33"
    colour = {"ready": good, "running": good, "succeeded": good, "failed": bad, "aborted": bad}.get(mode, other)
    assert f"\x1b[{colour}m{mode}  " in out.getvalue()


def test_of_many_lines_that_waited_for_a_person_the_last_are_printed_and_the_others_counted() -> None:
    out, chart = io.StringIO(), Chart(BLINKING)
    screen = Screen(BLINKING, out, verbose=True)
    screen.lend(SilentPerson())
    screen.watch(by_hand(chart).view)
    screen.step(chart.start(0.0))
    for number in range(MOST_HELD + 7):
        screen.step(chart.send(Event("unknown", number / 1000)))
    screen.close()
    assert "meanwhile, 7 more lines; the journal has all steps" in out.getvalue()


def test_the_last_line_has_the_time_of_the_lines_above() -> None:
    out, chart = io.StringIO(), Chart(MISSION)
    lines = Lines(MISSION, out)
    lines.watch(by_hand(chart).view)
    for name in ("battery", "camera", "heading"):
        chart.write(name, 1.0, 4.5)
    for step in (chart.start(4.5), chart.send(Event("stop_now", 18.14))):
        lines.step(step)
    lines.end(Result("aborted", "'z' was reached", 2, duration_s=16.6))
    assert "   18.14 s  stop_now" in out.getvalue() and " · 18.1 s\n" in out.getvalue()


@pytest.mark.parametrize("resumption", ["", "the run continues at 1.00 s in: a"])
def test_the_last_line_counts_the_questions_of_the_whole_run(resumption: str) -> None:
    out = io.StringIO()
    lines = Lines(MISSION, out)
    lines.begin("", (), "", model=None, resumption=resumption)
    lines.end(Result("aborted", "'z' was reached", 2, decisions=3))
    since = " since it was resumed" if resumption else ""
    assert f"questions 3 (answers that counted{since}: none)" in out.getvalue()


def test_a_fallback_is_counted_apart_from_the_answers() -> None:
    """It is taken where no answer counts, so it is none of them."""
    asked = {"question": "?", "options": {"again": {}, "stop": {}}, "ask": ["agent"], "deadline_s": 5}
    states = {
        "asking": {
            "decision": {**asked, "fallback": "stop"},
            "transitions": [{"on": "again", "to": "asking"}, {"on": "stop", "to": "z"}],
        },
        "z": {"final": "aborted"},
    }
    out, chart = io.StringIO(), Chart(Mission.model_validate({"name": "m", "initial": "asking", "states": states}))
    lines = Lines(chart.mission, out)
    lines.watch(by_hand(chart).view)
    for step in (chart.start(), chart.propose(1, "again", at=1.0), chart.send(Tick(9.0))):
        lines.step(step)
    lines.end(Result("aborted", "'z' was reached", 3, decisions=2))
    assert "steps 3 · questions 2 (answers that counted: the model 1) · fallbacks 1 · " in out.getvalue()


@pytest.mark.parametrize(
    ("final", "outcome", "is_there"),
    [("failed", "failed", True), ("succeeded", "succeeded", False), ("succeeded", "failed", False),
     ("failed", "canceled", False)],
)  # fmt: skip
def test_what_its_author_states_about_an_end_is_under_the_end_that_was_reached(
    final: str, outcome: Any, is_there: bool
) -> None:
    states = {"a": {"transitions": [{"after_s": 1, "to": "z"}]}, "z": {"final": final, "about": "no such place"}}
    out = io.StringIO()
    lines = Lines(Mission.model_validate({"name": "m", "initial": "a", "states": states}), out)
    lines.end(Result(outcome, "'z' was reached", 2, state=("z",)))
    assert ("\n    no such place\n" in out.getvalue()) is is_there
