# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C, SIGTERM and SIGHUP in a program that runs a mission: the run ends in order, its journal has how, and then
the program ends.
"""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.cli.main import main
from rai_missions.engine.step import CancelGoal, StartGoal
from rai_missions.runtime.interrupts import DEFAULTS, end_signals, interruptible
from tests.rigs.runs import Rig, mission
from tests.rigs.signals import in_terminal

OUTCOMES = ["succeeded", "failed", "canceled", "rejected", "timed_out"]


def interrupted(
    *at_s: float,
    on_cancel: tuple[str, ...] = ("canceled",),
    winds_down: bool = False,
    by: signal.Signals = signal.SIGINT,
) -> Rig:
    """A run whose goals have no end of their own, with a signal at each of these instants."""
    moving = {"timeout_s": 3, "cancel_s": 1, "transitions": [{"on": OUTCOMES, "to": "turning"}]}
    states = {
        "moving": {"action": "move", **moving},
        "turning": {"action": "turn", **moving, "transitions": [{"on": OUTCOMES, "to": "moving"}]},
        "winding": {"transitions": [{"after_s": 5, "to": "over"}]},
        "over": {"final": "canceled"},
    }
    rig = Rig(mission(states, **({"on_cancel": "winding"} if winds_down else {})))
    rig.move.on_cancel = rig.turn.on_cancel = on_cancel
    for instant in at_s:
        rig.stage.play({instant: lambda: signal.raise_signal(by)})
    with pytest.raises(KeyboardInterrupt if by is signal.SIGINT else SystemExit) as raised:
        rig.run()
    assert by is signal.SIGINT or raised.value.args == (128 + by,)
    return rig


@given(
    st.lists(st.integers(1, 25), min_size=1, max_size=2),
    st.sampled_from([("canceled",), (), ("cancel_rejected",)]), st.booleans(), st.sampled_from(list(DEFAULTS)),
)  # fmt: skip
def test_the_journal_of_an_interrupted_run_has_the_end_or_the_cancel_of_every_goal(
    tenths: list[int], on_cancel: tuple[str, ...], winds_down: bool, by: signal.Signals
) -> None:
    with in_terminal():
        rig = interrupted(*(tenth / 10 for tenth in tenths), on_cancel=on_cancel, winds_down=winds_down, by=by)
        assert [signal.getsignal(each) for each in DEFAULTS] == list(DEFAULTS.values())
    effects = [effect for step in rig.book.steps for effect in step.effects]
    started = {effect.number for effect in effects if isinstance(effect, StartGoal)}
    ended = {step.event.number for step in rig.book.steps if step.event.kind == "result"}
    canceled = {effect.number for effect in effects if isinstance(effect, CancelGoal)}
    assert started <= ended | canceled
    assert rig.runner.view.outcome in ("canceled", "aborted")
    assert {goal.number for goal in rig.runner.view.loose_goals} == started - ended


RAISED = "try:\n    signal.raise_signal(signal.SIGTERM)\nexcept BaseException:\n"
SWALLOWS = (
    "class Swallows:\n    def __del__(self):\n        signal.raise_signal(signal.SIGTERM)\nSwallows()",
    f"{RAISED}    pass",
    f"{RAISED}    raise ValueError('no name')",
)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("code", SWALLOWS)
@pytest.mark.parametrize("words", ["check {file}", "run {file} --journal a.journal"])
def test_a_command_that_is_asked_to_end_does_whatever_becomes_of_what_the_signal_raises(
    code: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    states = {"on": "State(transitions=[After(60, to='off')])", "off": "Final('aborted')"}
    text = ", ".join(f"'{name}': {state}" for name, state in states.items())
    Path("m.py").write_text(
        "import signal\nfrom rai_missions import After, Mission\nfrom rai_missions.states import Final, State\n"
        f"mission = Mission('m', initial='on', states={{{text}}})\n{code}\n"
    )
    begins = words.startswith("run") and "ValueError" not in code
    with in_terminal():
        assert main(words.format(file="m.py").split()) == (1 if begins else 128 + signal.SIGTERM)
        assert [signal.getsignal(each) for each in DEFAULTS] == list(DEFAULTS.values())
    printed = capsys.readouterr()
    assert "no name" not in printed.err or words.startswith("check"), "check prints what it found"
    assert begins == ("canceled by SIGTERM" in printed.out)


def test_an_interrupted_run_cancels_its_goal_and_its_journal_has_the_end_of_it() -> None:
    rig = interrupted(1.0)
    assert len(rig.move.canceled) == 1
    assert [step.event.name for step in rig.book.steps if step.event.kind == "result"] == ["canceled"]


def test_a_second_interrupt_is_an_e_stop() -> None:
    rig = interrupted(1.0, 2.0, winds_down=True)
    assert (rig.runner.view.outcome, rig.runner.view.why) == ("aborted", "e-stop by operator (interrupt)")


def test_a_run_that_is_asked_to_end_names_the_signal() -> None:
    rig = interrupted(1.0, 2.0, winds_down=True, by=signal.SIGTERM)
    assert (rig.runner.view.outcome, rig.runner.view.why) == ("aborted", "e-stop by SIGTERM")


def test_a_terminal_that_is_gone_cancels_a_run_however_often_it_reports_so() -> None:
    with in_terminal():
        rig = interrupted(1.0, 2.0, 3.0, 4.0, winds_down=True, by=signal.SIGHUP)
    assert (rig.runner.view.outcome, rig.runner.view.why) == ("canceled", "canceled by SIGHUP")


def test_a_terminal_that_is_gone_is_of_no_concern_under_nohup() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        assert signal.SIGHUP not in end_signals()
        interrupted(1.0)
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_third_interrupt_raises_where_it_is() -> None:
    received: list[str] = []

    class Run:
        def cancel(self, by: str = "") -> None:
            received.append("cancel")

        def kill(self, by: str = "") -> None:
            received.append("kill")

    def press(times: int) -> None:
        with interruptible(Run()):
            for _ in range(times):
                signal.raise_signal(signal.SIGINT)
            received.append("over")

    with pytest.raises(KeyboardInterrupt):
        press(2)
    with pytest.raises(KeyboardInterrupt):
        press(3)
    assert received == ["cancel", "kill", "over", "cancel", "kill"]
