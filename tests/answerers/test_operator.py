# SPDX-License-Identifier: Apache-2.0
"""A person at a terminal answers the question on the screen, and no other; what they type next is theirs."""

from __future__ import annotations

import io
import math
import os
import select
import threading
import time
import tty
from collections.abc import Iterator
from typing import IO, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.answerers.model import pending
from rai_missions.answerers.question_text import Blank, blanks, chosen, question_lines
from rai_missions.answerers.terminal_input import LineReader
from rai_missions.answerers.terminal_operator import OperatorAgent
from rai_missions.engine.decision import Evidence, Limits, Offer, Question
from rai_missions.plain_data import printable
from rai_missions.testing import QUESTION, ReplyCollector, answer_fault, check_agent, check_answerer
from tests.rigs.files import many_files

__all__ = ("many_files",)

DEPTH = {
    "type": "object",
    "properties": {
        "speed": {"type": "number", "description": "m/s", "default": 1.5},
        "times": {"type": "integer"},
        "loud": {"type": "boolean"},
        "colour": {"enum": ["red", "green"]},
        "note": {"type": "string"},
    },
    "required": ["times", "loud"],
}


class Screen(io.StringIO):
    """Collects what is written, and lets a test wait for it."""

    def __init__(self) -> None:
        super().__init__()
        self._written = threading.Condition()

    def write(self, text: str) -> int:
        with self._written:
            count = super().write(text)
            self._written.notify_all()
        return count

    def wait(self, text: str, times: int = 1) -> None:
        with self._written:
            seen = self._written.wait_for(lambda: self.getvalue().count(text) >= times, 10)
            assert seen, f"{text!r} was not written {times} times: {self.getvalue()}"


class Desk:
    """A terminal with an operator's agent behind it, and a person in front."""

    def __init__(self) -> None:
        self.person, self.terminal = os.openpty()
        self.source: IO[Any] = os.fdopen(self.terminal, "rb", buffering=0)
        self.screen = Screen()
        self.agent = OperatorAgent(self.source, self.screen)

    def ask(self, question: Question = QUESTION) -> ReplyCollector:
        reported = ReplyCollector()
        self.agent.ask(question, reported)
        return reported

    def types(self, text: str) -> None:
        os.write(self.person, text.encode())

    def left_over(self) -> bytes:
        """What the terminal still holds for anyone who reads next."""
        ready, _, _ = select.select([self.terminal], [], [], 1.0)
        return os.read(self.terminal, 100) if ready else b""


@pytest.fixture
def desk() -> Iterator[Desk]:
    found = Desk()
    yield found
    found.agent.stop()
    found.source.close()
    os.close(found.person)


PROMPT = "Number or name"


# ── Laws ────────────────────────────────────────────────────────────────────────────────────────────────────────


@given(st.text())
def test_nothing_that_is_shown_moves_the_cursor(text: str) -> None:
    question = QUESTION._replace(evidence=(Evidence("obstacle", text, 0.1, fresh=True),), refused=(text,))
    assert all(line.isprintable() for line in question_lines(question, 3.0))


@given(st.text(), st.sampled_from(["string", "number", "integer", "boolean", "array", "object", ""]), st.booleans())
def test_what_is_typed_is_of_the_kind_asked_for_or_refused(typed: str, kind: str, required: bool) -> None:
    blank = Blank("x", {"type": kind}, required)
    kinds = {
        "string": str,
        "number": int | float,
        "integer": int,
        "boolean": bool,
        "array": list,
        "object": dict,
        "": object,
    }
    try:
        value = blank.value(typed)
    except ValueError:
        return
    except KeyError:
        assert not required
    else:
        assert isinstance(value, kinds[kind])


def test_the_operator_keeps_the_contract() -> None:
    check_agent(lambda: OperatorAgent(io.StringIO()))
    check_answerer(lambda: OperatorAgent(io.StringIO()))


# ── At a terminal ───────────────────────────────────────────────────────────────────────────────────────────────


def test_a_number_or_a_name_is_an_answer(desk: Desk) -> None:
    for number, typed, option in ((1, "2\n", "signal"), (2, " abort \n", "abort")):
        reported = desk.ask(QUESTION._replace(number=number))
        desk.screen.wait(PROMPT, number)
        desk.types(typed)
        reply = reported.wait()
        assert not answer_fault(reply)
        assert reply == {"option": option, "parameters": {}, "why": "the operator chose it"}


def test_the_question_shows_what_is_known_and_what_may_be_chosen(desk: Desk) -> None:
    desk.ask(QUESTION._replace(refused=("'fly' was not offered",)))
    desk.screen.wait(PROMPT)
    assert desk.screen.getvalue().splitlines()[1:] == [
        "Question 1 of 'assessing', 20 s left: Something blocks the alley. What should the tractor do?",
        '  obstacle: {"kind": "branch", "height_m": 0.1}, 0.2 s old',
        "  battery: unknown, 3.2 s old",
        "  refused before: 'fly' was not offered",
        "  1  replan  take the next alley",
        "  2  signal  sound the horn",
        "  3  abort   stop here",
        "Number or name (Ctrl-D to pass): ",
    ]


def test_another_word_is_refused_and_asked_again(desk: Desk) -> None:
    reported = desk.ask()
    desk.screen.wait(PROMPT)
    desk.types("4\n")
    desk.screen.wait("That is none of them; type a number from 1 to 3, or a name.")
    desk.types("3\n")
    assert reported.wait()["option"] == "abort"


def test_parameters_are_asked_for_one_by_one(desk: Desk) -> None:
    reported = desk.ask(QUESTION._replace(options=(Offer("report", parameters=DEPTH),)))
    for prompt, typed in (
        (PROMPT, "1\n"),
        ("speed (number, m/s; empty for 1.5): ", "\n"),
        ("times (integer): ", "two\n"),
        ("'two' is no whole number.", f"{10**400}\n"),
        ("0' is no whole number.", "2\n"),
        ("loud (boolean): ", "yes\n"),
        ("colour (red or green; empty to leave it out): ", "green\n"),
        ("note (string; empty to leave it out): ", "\n"),
    ):
        desk.screen.wait(prompt)
        desk.types(typed)
    assert reported.wait()["parameters"] == {"speed": 1.5, "times": 2, "loud": True, "colour": "green"}


def test_a_parameter_that_its_schema_refuses_is_asked_for_again_and_costs_no_attempt(desk: Desk) -> None:
    count = {"type": "integer", "minimum": 1, "maximum": 9, "description": "pallets"}
    parameters = {
        "type": "object", "required": ["count", "place"],
        "properties": {"count": count, "again": {"$ref": "#/properties/count"}, "place": {"$ref": "#/$defs/place"}},
        "$defs": {"place": {"type": "string", "pattern": "^[A-F][0-9]$"}},
    }  # fmt: skip
    reported = desk.ask(QUESTION._replace(options=(Offer("report", parameters=parameters),)))
    for prompt, typed in (
        (PROMPT, "1\n"),
        ("count (integer, 1 to 9, pallets): ", "12\n"),
        ("count: 12 is greater than the maximum of 9.", "3\n"),
        ("again (empty to leave it out): ", "0\n"),
        ("again: 0 is less than the minimum of 1.", "4\n"),
        ("place: ", "G7\n"),
        ("place: 'G7' does not match '^[A-F][0-9]$'.", "F7\n"),
    ):
        desk.screen.wait(prompt)
        desk.types(typed)
    assert reported.wait()["parameters"] == {"count": 3, "again": 4, "place": "F7"}


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        ({"minimum": 1}, ", 1 or more"),
        ({"maximum": 2.5}, ", at the most 2.5"),
        ({"minimum": 0, "maximum": 9}, ", 0 to 9"),
    ],
)
def test_the_bounds_of_a_number_are_shown(bounds: dict[str, float], words: str) -> None:
    assert Blank("x", {"type": "number"} | bounds, required=True).prompt() == f"x (number{words}): "


def test_what_was_typed_before_the_question_is_no_answer_to_it(desk: Desk) -> None:
    desk.types("3\n")
    reported = desk.ask()
    desk.screen.wait(PROMPT)
    desk.types("1\n")
    assert reported.wait()["option"] == "replan"


def test_a_question_withdrawn_frees_the_terminal_and_what_is_typed_then_is_left_there(desk: Desk) -> None:
    reported = desk.ask()
    desk.screen.wait(PROMPT)
    desk.agent.withdraw(QUESTION.number)
    desk.screen.wait("(no longer asked)")
    desk.types("ls\n")
    assert desk.left_over() == b"ls\n"
    assert reported.all == []


def test_the_next_question_waits_for_its_turn(desk: Desk) -> None:
    first, second = desk.ask(), desk.ask(QUESTION._replace(number=2))
    desk.screen.wait("Question 1")
    desk.screen.wait(PROMPT)
    assert "Question 2" not in desk.screen.getvalue()
    desk.agent.withdraw(1)
    desk.screen.wait(PROMPT, 2)
    desk.types("abort\n")
    assert second.wait()["option"] == "abort"
    assert first.all == []


def test_withdrawing_another_question_leaves_the_one_on_the_screen(desk: Desk) -> None:
    reported, other = desk.ask(), desk.ask(QUESTION._replace(number=2))
    desk.screen.wait(PROMPT)
    desk.agent.withdraw(2)
    desk.types("abort\n")
    assert reported.wait()["option"] == "abort"
    desk.agent.stop()
    assert other.all == []


def test_a_question_is_open_until_the_run_withdraws_it(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pause, or an operator who takes control, stops the question's time, of which no clock of the terminal knows."""
    monkeypatch.setattr(pending, "GRACE_S", 0.0)
    reported = desk.ask(QUESTION._replace(until=QUESTION.at + 1e-6))
    desk.screen.wait(PROMPT)
    desk.types("abort\n")
    assert reported.wait()["option"] == "abort"
    withdrawn = desk.ask(QUESTION._replace(number=2, until=QUESTION.at + 1e-6))
    desk.screen.wait(PROMPT, 2)
    desk.agent.withdraw(2)
    desk.screen.wait("(time is over)")
    assert withdrawn.all == []


def test_time_that_is_over_is_reported(desk: Desk) -> None:
    reported = desk.ask(QUESTION._replace(budget=Limits(seconds=0.05)))
    assert reported.wait()["failed"].startswith("no answer within 0.")
    desk.screen.wait("(time is over)")


def test_the_end_of_input_passes(desk: Desk) -> None:
    reported = desk.ask()
    desk.screen.wait(PROMPT)
    desk.types("\x04")
    assert reported.wait() == {"absent": "the operator passed"}


def test_a_terminal_that_goes_away_is_absent(desk: Desk) -> None:
    reported = desk.ask()
    desk.screen.wait(PROMPT)
    os.close(desk.person)
    desk.person = os.open(os.devnull, os.O_RDONLY)
    assert "absent" in reported.wait()


def test_a_screen_that_cannot_be_written_is_absent(desk: Desk) -> None:
    desk.agent = OperatorAgent(desk.source, io.TextIOWrapper(io.BufferedReader(io.BytesIO())))
    assert desk.ask().wait()["absent"].startswith("the question could not be shown: ")


def test_stopping_frees_the_terminal(desk: Desk) -> None:
    reported = desk.ask()
    desk.screen.wait(PROMPT)
    desk.agent.stop()
    assert [thread.name for thread in threading.enumerate() if thread.name == "operator"] == []
    assert reported.all == []


@pytest.mark.parametrize("source", [io.StringIO("1\n"), io.BytesIO(b"1\n")])
def test_what_is_no_terminal_is_absent(source: IO[Any]) -> None:
    screen, reported = Screen(), ReplyCollector()
    OperatorAgent(source, screen).ask(QUESTION, reported)
    assert reported.all == [{"absent": "no terminal"}]
    assert screen.getvalue() == ""


def test_a_pipe_is_no_terminal() -> None:
    reading, writing = os.pipe()
    reported = ReplyCollector()
    with os.fdopen(reading, "rb") as source, os.fdopen(writing, "wb"):
        OperatorAgent(source, Screen()).ask(QUESTION, reported)
    assert reported.all == [{"absent": "no terminal"}]


# ── Lines and words ─────────────────────────────────────────────────────────────────────────────────────────────


def test_a_line_is_read_to_its_end_and_not_beyond() -> None:
    reading, writing = os.pipe()
    os.write(writing, b"first\r\nsecond\n")
    reader = LineReader(reading)
    assert reader.line(float("inf")) == "first"
    assert os.read(reading, 100) == b"second\n"
    reader.wake()
    assert reader.line(float("inf")) is None
    os.close(writing)
    with pytest.raises(EOFError, match="the operator passed"):
        reader.line(float("inf"))
    reader.close()
    os.close(reading)


def test_the_last_line_needs_no_end() -> None:
    reading, writing = os.pipe()
    os.write(writing, b"go home\nstop")
    os.close(writing)
    reader = LineReader(reading)
    assert [reader.line(math.inf), reader.line(math.inf)] == ["go home", "stop"]
    with pytest.raises(EOFError, match="the operator passed"):
        reader.line(math.inf)
    reader.close()
    os.close(reading)


def test_a_line_that_was_there_unasked_came_before_the_last_wait_ended() -> None:
    reading, writing = os.pipe()
    os.write(writing, b"ahead\nalso ahead\n")
    reader = LineReader(reading)
    for _ in range(2):
        reader.line(math.inf)
        assert reader.came_at == -math.inf, "it may have come at any time"
    asked_at = time.monotonic()
    assert reader.line(asked_at + 0.01) is None
    ended_at = time.monotonic()
    os.write(writing, b"later\nwith it\n")
    for _ in range(2):
        reader.line(math.inf)
        assert asked_at <= reader.came_at <= ended_at
    reader.close()
    os.close(writing)
    os.close(reading)


def test_a_program_with_many_files_reads_a_terminal(many_files: None) -> None:
    person, terminal = os.openpty()
    reader = LineReader(terminal)
    os.write(person, b"first\n")
    assert reader.line(time.monotonic() + 10) == "first"
    assert reader.line(time.monotonic() + 0.01) is None
    os.close(person)
    with pytest.raises(EOFError, match="the operator passed"):
        reader.line(float("inf"))
    reader.close()
    os.close(terminal)


def test_bytes_that_are_no_text_are_read_as_such() -> None:
    person, terminal = os.openpty()
    tty.setraw(terminal)
    reader = LineReader(terminal)
    os.write(person, b"\xff\n")
    assert reader.line(float("inf")) == "�"
    reader.close()
    os.close(person)
    os.close(terminal)


def test_an_option_is_chosen_by_its_name_before_its_number() -> None:
    offers = (Offer("a"), Offer("b"))
    assert [chosen(typed, offers) for typed in ("a", " 2 ", "0", "3", "", "A")] == [*offers, None, None, None, None]
    assert printable("a\x1b[2Jb\u202e") == "a�[2Jb�"
    assert blanks(Offer("a")) == ()
