# SPDX-License-Identifier: Apache-2.0
"""A dialogue's limits: what a profile may grant, what outlives a process, and how much is kept."""

from __future__ import annotations

import json
from itertools import chain
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.conversation import (
    AskModel,
    Dialogue,
    MissionView,
    ModelText,
    Order,
    OrderEnd,
    Settings,
    Speech,
    SpeechEnd,
    StatusView,
    TalkNote,
    Utterance,
)
from rai_missions.conversation.inputs import OrderResult, SpeechResult
from rai_missions.conversation.sentences import SentenceStream, sentences
from rai_missions.engine.decision import Offer, Question

RUNNING = StatusView(run="r", mode="running", mission="patrol")


def test_a_start_that_is_ordered_instead_of_a_request_is_waited_for_too() -> None:
    running = RUNNING._replace(missions=(MissionView("patrol"), MissionView("orchard")))
    failed = running._replace(mode="failed", outcome="failed")
    dialogue = Dialogue(view=running)

    def say(text: str, at: float, view: StatusView) -> bool:
        dialogue.on_utterance(Utterance(text, "operator", "terminal", at=at), view)
        return dialogue.asks_to_begin

    dialogue.on_status(running, 0.0)
    assert [say("start the patrol", 1.0, running), say("yes", 2.0, running)] == [False, False]
    dialogue.on_status(failed, 3.0)
    assert dialogue.asks_to_begin
    assert say("start the orchard", 4.0, failed), "it is read back in place of the request"
    assert not say("no", 5.0, failed)


TEXTS = ("stop", "who are you?", "pause")
messages = st.tuples(st.sampled_from(("Anna", "Bob", "")), st.sampled_from(("1", "2")), st.sampled_from(TEXTS))


@given(st.lists(messages, max_size=12))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_a_message_counts_whichever_other_has_its_id_and_a_stop_however_often_it_comes(sent: list[Any]) -> None:
    dialogue, received = Dialogue(view=RUNNING), set[Any]()
    for at, (author, number, text) in enumerate(sent):
        outputs = dialogue.on_utterance(Utterance(text, "person", "topic", author, at, (), number), RUNNING)
        is_stopped = any(isinstance(each, Order) and each.name == "stop" for each in outputs)
        is_answered = any(isinstance(each, Speech) and not each.report for each in outputs)
        assert is_stopped == (text == "stop")
        assert is_answered == (text == "stop" or (author, number, text) not in received)
        received.add((author, number, text))


@pytest.mark.parametrize("order", ["stop", "pause"])
def test_why_it_stopped_is_known_before_the_run_has_taken_the_order(order: str) -> None:
    dialogue = Dialogue(view=RUNNING)

    def why(at: float) -> str:
        outputs = dialogue.on_utterance(Utterance("why did you stop?", "viewer", "page", "Eve", at), RUNNING)
        return next(each.text for each in outputs if isinstance(each, Speech) and not each.report)

    assert "Anna" not in why(0.0)
    outputs = dialogue.on_utterance(Utterance(order, "operator", "terminal", "Anna", 1.0), RUNNING)
    number = next(each.number for each in outputs if isinstance(each, Order))
    assert "operator Anna (terminal)" in why(1.0)
    dialogue.on_order_end(OrderEnd(number, OrderResult("the mission has ended"), 2.0))
    assert "Anna" not in why(2.0)


def test_of_many_speakers_those_are_remembered_who_ordered_last() -> None:
    dialogue = Dialogue(view=RUNNING)

    def say(text: str, author: str, at: float) -> str:
        outputs = dialogue.on_utterance(Utterance(text, "operator", "page", author, at), RUNNING)
        return " ".join(each.text for each in outputs if isinstance(each, Speech) and not each.report)

    for at, author in enumerate(["Anna", *map(str, range(99)), "Anna", "Bob"]):
        say("stop", author, float(at))
    assert say("what did I order?", "Anna", 200.0).startswith("You ordered: ")
    assert say("what did I order?", "Bob", 201.0).startswith("You ordered: ")
    assert say("what did I order?", "0", 202.0) == "You have ordered nothing in this conversation."


PATROL = RUNNING._replace(missions=(MissionView("patrol"), MissionView("tour")))
HAPPENS = tuple(
    each.split(", ")
    for each in (
        "start the patrol, yes",
        "start the tour, yes",
        "start the tour",
        "yes",
        "no",
        "stop",
        "what is that?",
        "failed",
        "succeeded",
        "begins",
        "refused",
        "waits",
    )
)


@given(st.lists(st.sampled_from(HAPPENS), max_size=12).map(lambda each: [*chain(*each)]))
@settings(max_examples=100, deadline=None, derandomize=True)
def test_a_request_waits_for_something_and_none_begins_after_a_stop(happens: list[str]) -> None:
    view, at, may_begin = PATROL, 0.0, False
    dialogue, orders = Dialogue(Settings(requests="queue"), view), list[int]()
    for happening in (*happens, "failed", "what is that?", *["waits"] * 5):
        at += 25.0 if happening == "waits" else 0.5
        if happening in ("failed", "succeeded"):
            view = view._replace(mode=happening, outcome=happening)
        elif happening == "begins":
            view = view._replace(run=f"r{at}", mode="running", outcome=None)
        outputs = dialogue.on_time(at)
        if happening in ("refused", "waits"):
            outputs += tuple(
                each for number in orders for each in dialogue.on_order_end(OrderEnd(number, OrderResult("no"), at))
            )
            orders.clear()
        elif happening in ("failed", "succeeded") and at % 2:
            outputs += dialogue.on_status(view, at)  # else the next sentence comes before it is seen
        elif happening not in ("failed", "succeeded", "begins"):
            outputs += dialogue.on_utterance(Utterance(happening, "operator", "terminal", at=at), view)
        may_begin = (may_begin or happening == "yes") and happening != "stop"
        starts = [each.number for each in outputs if isinstance(each, Order) and each.name == "start"]
        assert may_begin or not starts, "it began after a stop"
        orders += starts
    outputs = dialogue.on_utterance(Utterance("what did I order?", "operator", "terminal", at=at), view)
    texts = [each.text for each in outputs if isinstance(each, Speech) and not each.report]
    assert not any("wait" in text for text in texts), texts


@given(st.lists(st.sampled_from(HAPPENS), max_size=12).map(lambda each: [*chain(*each)]))
@settings(max_examples=100, deadline=None, derandomize=True)
def test_the_last_note_of_what_waits_is_what_waits(happens: list[str]) -> None:
    view, noted, at = PATROL, dict[str, list[str]](), 0.0
    dialogue = Dialogue(Settings(requests="queue"), view)
    for at, happening in enumerate(happens):
        outputs: tuple[Any, ...] = ()
        if happening in ("failed", "succeeded"):
            view = view._replace(mode=happening, outcome=happening)
        elif happening == "begins":
            view = view._replace(run=f"r{at}", mode="running", outcome=None)
        elif happening not in ("refused", "waits"):
            outputs = dialogue.on_utterance(Utterance(happening, "operator", "terminal", at=at), view)
        outputs += dialogue.on_status(view, at)
        for each in outputs:
            if isinstance(each, TalkNote) and each.kind == "waiting":
                noted[view.run] = list(each.data["requests"])
    answer = dialogue.on_utterance(Utterance("which requests wait?", "operator", "terminal", at=at), view)
    text = next(each.text for each in answer if isinstance(each, Speech) and not each.report)
    waiting = noted.get(view.run, [])
    assert text.count("start the mission '") == text.partition("These")[0].count("start the mission '") + len(waiting)
    assert all(each in text.partition("These")[2] for each in waiting)


def test_what_was_lost_with_a_program_is_reported_once() -> None:
    resumed, lost = RUNNING._replace(is_resumed=True), ("start the mission 'patrol'", "start the mission 'tour'")
    dialogue = Dialogue()
    outputs = (*dialogue.on_lost_requests(lost, resumed, 0.0), *dialogue.on_lost_requests(lost, resumed, 1.0))
    texts = [each.text for each in outputs if isinstance(each, Speech) and each.report == "r:lost"]
    assert len(texts) == 1 and all(each in texts[0] for each in lost)


ENDS = st.lists(st.sampled_from(["whole", "cut", "failed", "request"]), max_size=6)


@given(ENDS)
@settings(max_examples=40, deadline=None, derandomize=True)
def test_what_was_lost_is_noted_with_what_waits_until_it_was_spoken_whole(happens: list[str]) -> None:
    view, at, own, owed, noted = PATROL._replace(is_resumed=True), 0.0, list[str](), ["start the mission 'tour'"], None
    dialogue = Dialogue(Settings(requests="queue"), view)
    outputs = dialogue.on_lost_requests(owed, view, at)
    for happening in (*happens, "whole"):
        keys = [each.key for each in outputs if isinstance(each, Speech) and each.report == "r:lost"]
        at += 6.0
        if happening == "request":
            for text in ("start the patrol", "yes"):
                outputs += dialogue.on_utterance(Utterance(text, "operator", "terminal", at=at), view)
            own = [*own, "start the mission 'patrol'"][:3]
        elif keys:
            outputs = (*dialogue.on_speech_end(SpeechEnd(keys[-1], happening, at)), *dialogue.on_time(at + 6.0))
            owed = [] if happening == "whole" else owed
        notes = [each for each in outputs if isinstance(each, TalkNote) and each.kind == "waiting"]
        noted = list(notes[-1].data["requests"]) if notes else noted
        assert noted == (None if noted is None else [*owed, *own])
    assert noted is not None or owed


def test_what_was_lost_and_is_not_spoken_is_noted_in_the_journal_of_the_next_run_too() -> None:
    resumed, lost = PATROL._replace(is_resumed=True), ["start the mission 'tour'"]
    dialogue = Dialogue(view=resumed)
    dialogue.on_lost_requests(lost, resumed, 0.0)
    dialogue.on_status(resumed._replace(mode="succeeded", outcome="succeeded"), 1.0)
    outputs = dialogue.on_status(resumed._replace(run="r-2", mode="running", outcome=None), 2.0)
    notes = [each.data["requests"] for each in outputs if isinstance(each, TalkNote) and each.kind == "waiting"]
    assert notes == [lost]


@pytest.mark.parametrize("failing_s", [0.0, 20.0, 60.0, 3600.0])
def test_an_end_is_reported_once_the_speaker_works_again_however_long_it_failed(failing_s: float) -> None:
    dialogue, at, tries = Dialogue(view=RUNNING), 0.0, 0
    outputs = dialogue.on_status(RUNNING._replace(mode="succeeded", outcome="succeeded"), at)
    while at <= failing_s + 90.0:
        spoken = [each for each in outputs if isinstance(each, Speech) and each.report == "r:end"]
        tries += len(spoken)
        if spoken and at >= failing_s:
            assert spoken[-1].repeated == (tries > 1) and tries <= 5 + failing_s / 60
            outputs = dialogue.on_speech_end(SpeechEnd(spoken[-1].key, "whole", at))
            return
        ends = (
            dialogue.on_speech_end(SpeechEnd(each.key, "failed", at)) for each in outputs if isinstance(each, Speech)
        )
        outputs = tuple(chain(*ends)) or dialogue.on_time(at := at + 1.0)
    raise AssertionError("the end was not reported")


STOPS = {"interrupt": "because the program ends", "e-stop": "because of the stop", "loose": "may still move"}


@pytest.mark.parametrize("how", STOPS)
@pytest.mark.parametrize("waits", [0, 2])
def test_where_no_run_can_follow_no_start_is_asked_for(how: str, waits: int) -> None:
    ends = {"e-stop": {"control": "nobody"}, "loose": {"open_goals": ("move",)}}
    over = PATROL._replace(mode="canceled", outcome="canceled", **ends.get(how, {}))
    dialogue = Dialogue(Settings(requests="queue"), PATROL)

    def say(text: str, at: float, view: StatusView) -> list[str]:
        outputs = dialogue.on_utterance(Utterance(text, "operator", "terminal", at=at), view)
        return [each.text for each in outputs if isinstance(each, Speech)]

    for text in ["start the tour", "yes"] * waits or ["start the patrol"]:
        say(text, 1.0, PATROL)
    outputs = dialogue.on_last_run(2.0) if how == "interrupt" else ()
    outputs += dialogue.on_status(over, 3.0)
    texts = [each.text for each in outputs if isinstance(each, Speech) and not each.report]
    assert not dialogue.asks_to_begin and not any("yes or no" in text for text in texts)
    reason, named = (STOPS[how], "'tour'") if waits else ("nothing is ordered", "'patrol'")
    assert [text.count(named) for text in texts if reason in text] == [waits or 1]
    if how == "interrupt":
        assert "Not accepted" in say("start the patrol", 4.0, over)[0]


@pytest.mark.parametrize("mode", ["succeeded", "failed"])
@pytest.mark.parametrize("waits", [0, 1])
def test_a_start_that_was_read_back_is_read_back_again_once_the_mission_is_over(mode: str, waits: int) -> None:
    over, dialogue = PATROL._replace(mode=mode, outcome=mode), Dialogue(Settings(requests="queue"), PATROL)

    def say(text: str, at: float, view: StatusView) -> tuple[Any, ...]:
        return dialogue.on_utterance(Utterance(text, "operator", "terminal", at=at), view)

    for text in ["start the tour", "yes"] * waits:
        say(text, 1.0, PATROL)
    say("start the patrol", 2.0, PATROL)
    at_end = [each for each in dialogue.on_status(over, 3.0) if isinstance(each, Speech | Order)]
    if waits:
        asked = {"succeeded": [], "failed": ["tour"]}[mode]
        assert [each.mission for each in at_end if isinstance(each, Order)] == ["tour"] * (mode == "succeeded")
    else:
        asked = ["patrol"]
        assert [each.mission for each in say("yes", 4.0, over) if isinstance(each, Order)] == ["patrol"]
    read_back = [each.text for each in at_end if isinstance(each, Speech) and "yes or no" in each.text]
    assert [name for name in asked if not any(name in text for text in read_back)] == []
    assert len(read_back) == len(asked)


def test_what_a_process_before_may_have_reported_is_marked_as_repeated_and_nothing_later() -> None:
    question = Question(1, "asking", "operator", "Which way?", (Offer("left"),))
    resumed = RUNNING._replace(is_resumed=True, questions=(question,))
    dialogue = Dialogue()
    first = dialogue.on_status(resumed, 0.0)
    later = dialogue.on_status(resumed._replace(questions=(question._replace(number=2),)), 1.0)
    reports = {each.report: each.repeated for each in (*first, *later) if isinstance(each, Speech)}
    assert reports == {"r:start": True, "r:question:1": True, "r:question:2": False}


def test_the_history_is_bounded() -> None:
    dialogue = Dialogue(Settings(history=6), RUNNING)
    for at in range(20):
        dialogue.on_utterance(Utterance("hello", "operator", "terminal", at=at), RUNNING)
    assert len(dialogue.history) == 6
    assert [each.number for each in dialogue.history] == sorted(each.number for each in dialogue.history)


def test_a_snapshot_is_json_and_keeps_what_was_spoken() -> None:
    dialogue = Dialogue(view=RUNNING)
    (start,) = (each for each in dialogue.on_status(RUNNING, 0.0) if isinstance(each, Speech))
    dialogue.on_speech_end(SpeechEnd(start.key, "whole", 1.0))
    saved = json.loads(json.dumps(dialogue.snapshot()))
    again = Dialogue.restore(saved, view=RUNNING)
    assert again.on_status(RUNNING, 2.0) == ()
    assert again.unspoken == ()


def test_time_never_goes_back() -> None:
    dialogue = Dialogue(view=RUNNING)
    dialogue.on_utterance(Utterance("cancel the mission", "operator", "terminal", at=100.0), RUNNING)
    dialogue.on_time(50.0)
    outputs = dialogue.on_utterance(Utterance("yes", "operator", "terminal", at=100.0), RUNNING)
    assert any(getattr(each, "name", "") == "cancel" for each in outputs)


def test_a_reply_without_end_is_bounded() -> None:
    dialogue = Dialogue(Settings(has_model=True), RUNNING)
    asked = dialogue.on_utterance(Utterance("a story, please", "operator", "terminal", at=1.0), RUNNING)
    (request,) = (each for each in asked if isinstance(each, AskModel))
    spoken = [
        each
        for _ in range(200)
        for each in dialogue.on_model(ModelText(request.number, "You can ask. ", at=2.0))
        if isinstance(each, Speech)
    ]
    assert len(spoken) == 12


@pytest.mark.parametrize(
    ("text", "whole", "rest"),
    [
        ("One. Two! Thr", ["One.", "Two!"], "Thr"),
        ("E.g. apples are red. And", ["E.g. apples are red."], "And"),
        ("It costs 2. 5 is more. ", ["It costs 2. 5 is more."], ""),
        ("line one\nline two", ["line one"], "line two"),
    ],
)
def test_a_text_is_split_into_sentences(text: str, whole: list[str], rest: str) -> None:
    assert sentences(text) == (whole, rest)


def test_a_stream_gives_each_sentence_once_whatever_the_pieces() -> None:
    text, stream, out = "First one. Second one! And the third", SentenceStream(), list[str]()
    for letter in text:
        stream, whole = stream.add(letter, is_end=False)
        out += whole
    _, whole = stream.add("", is_end=True)
    assert [*out, *whole] == ["First one.", "Second one!", "And the third"]


@given(st.floats(10.2, 16.0), st.floats(10.0, 20.0), st.sampled_from(["whole", "cut"]))
def test_a_spoken_yes_counts_if_it_began_after_the_reading_back_had_ended(
    ended: float, began: float, how: SpeechResult
) -> None:
    dialogue = Dialogue(view=RUNNING)

    def given_out(text: str, at: float) -> tuple[list[str], list[Speech]]:
        spoken = Utterance(text, "operator", "voice", at=at, readings=(text,) * 2)
        outputs = dialogue.on_utterance(spoken, RUNNING)
        orders = [each.name for each in outputs if isinstance(each, Order)]
        return orders, [each for each in outputs if isinstance(each, Speech)]

    orders, speeches = given_out("cancel the mission", 10.0)
    assert not orders
    dialogue.on_speech_end(SpeechEnd(speeches[-1].key, how, ended))
    orders, speeches = given_out("yes", began)
    assert orders == (["cancel"] if began >= ended else [])
    if not orders:
        dialogue.on_speech_end(SpeechEnd(speeches[-1].key, "whole", 25.0))
        assert given_out("yes", 25.1)[0] == ["cancel"], "it was read back again"


@pytest.mark.parametrize("asked", ["yes?", "right?", "sure ?", "ok?", "Yes please?"])
def test_a_yes_that_may_be_a_question_itself_has_the_order_read_back_again(asked: str) -> None:
    dialogue = Dialogue(view=RUNNING)
    ordered = []
    for at, text in enumerate(["cancel the mission", asked, "yes"], start=1):
        outputs = dialogue.on_utterance(Utterance(text, "operator", "terminal", at=float(at)), RUNNING)
        ordered.append([each.name for each in outputs if isinstance(each, Order)])
        assert ordered[-1] or any("Is that right?" in each.text for each in outputs if isinstance(each, Speech))
    assert ordered == [[], [], ["cancel"]]


@pytest.mark.parametrize("text", ["stop @tractor", "please stop @tractor!", "@tractor stop", "stop, @tractor"])
def test_a_stop_to_a_robot_that_is_mentioned_is_no_stop_at_a_place(text: str) -> None:
    view = RUNNING._replace(robot="tractor")
    outputs = Dialogue(view=view).on_utterance(Utterance(text, "person", "topic"), view)
    assert [each.name for each in outputs if isinstance(each, Order)] == ["stop"]


@given(
    st.sampled_from(["rover", "R2D", "Spot-", "arm_", "turtlebot", "Robo "]),
    st.integers(0, 30).map(str),
    st.sampled_from(["", "_xl", " east", ", simulated"]),
    st.sampled_from(
        ["{}, pause", "{} pause", "pause, {}", "{}, please pause", "hey {}, pause", "@{} pause", "pause @{}"]
    ),
)
@settings(max_examples=40)
def test_a_robot_is_addressed_by_its_name_whatever_digits_and_marks_are_in_it(
    name: str, number: str, end: str, form: str
) -> None:
    view = RUNNING._replace(robot=f"{name}{number}{end}")
    address = f"{name}{number}{end}".partition(",")[0]
    outputs = Dialogue(view=view).on_utterance(Utterance(form.format(address), "operator", "terminal"), view)
    assert [each.name for each in outputs if isinstance(each, Order)] == ["pause"]
