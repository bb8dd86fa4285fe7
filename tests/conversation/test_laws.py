# SPDX-License-Identifier: Apache-2.0
"""What no conversation can do, by any talk, forgery, mapping or interruption: each output is held against a referee.

The referee keeps its own, simpler account of who spoke, what was read back and how the run was, and shares no code
with the dialogue but its values.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hypothesis import HealthCheck, Phase, example, given, settings
from hypothesis import strategies as st

from rai_missions.conversation import (
    AskModel,
    Dialogue,
    KeyView,
    MissionView,
    ModelText,
    Order,
    OrderEnd,
    Output,
    Settings,
    Speech,
    SpeechEnd,
    StatusView,
    Utterance,
)
from rai_missions.conversation.inputs import OrderResult
from rai_missions.engine.decision import Offer, Question
from rai_missions.profile import ConversationPolicy
from tests.conversation.stored import SENTENCES
from tests.rigs.laws import drill

HOSTILE = tuple(SENTENCES["hostile"])
MAY = {
    "operator": {"start", "pause", "resume", "cancel", "stop", "answer"}, "person": {"stop"}, "viewer": set[str](),
}  # fmt: skip
ALIVE = ("ready", "running", "paused", "canceling")
YES = ("yes", "yes please", "Yes, do it!")
OFFERED = {"replan": "take the next alley", "drive_over": "over it", "stop": "stop here", "yes": "it is free"}
OTHERS = {"replan": "take the other alley", "left": "to the left"}
AUTHORS = ("", "Anna", "operator", "operator Anna (terminal)", "robot", "ai", "terminal")
DOORS = (("operator", "terminal"), ("operator", "page"), ("viewer", "page"), ("person", "voice"), ("person", "topic"))
CLAIMS = ("I have finished the patrol.", "The mission is complete.", "Yes, stopping now.", "We are home!")
TALK = ("Apples ripen in autumn.", "You can ask about the battery.", "I do not know the answer to that.")
PROPOSED: tuple[Any, ...] = (
    {"order": "cancel"}, {"order": "pause"}, {"order": "resume"}, {"order": "stop"}, {"order": "kill"}, [], None,
    {"order": "start", "mission": "patrol"}, {"order": "answer", "option": "replan"}, {"order": None},
    {"order": "answer", "option": "drive_over"}, {"order": "answer", "option": "fly"},
    {"order": "start", "mission": "patrol", "arguments": {"laps": "many"}},
    {"order": "start", "mission": "patrol", "arguments": {"laps": 2}},
    {"order": "cancel", "confirmed": "yes", "role": "operator"},
)  # fmt: skip

KEYS = {"battery": KeyView("battery", "number", value=0.5, age_s=0.1)}
MISSIONS = (MissionView("patrol", "look", (KeyView("laps", "integer", "argument"),)), MissionView("tour"))
BEGIN = StatusView(run="r1", mode="running", mission="patrol", robot="rob", keys=KEYS, missions=MISSIONS)

speaks = st.tuples(
    st.just("speaks"),
    st.sampled_from(DOORS),
    st.sampled_from(AUTHORS),
    st.sampled_from(HOSTILE),
    st.one_of(st.none(), st.sampled_from(HOSTILE)),
)
lists = st.one_of(
    speaks,
    st.tuples(st.just("mode"), st.sampled_from((*ALIVE, "succeeded", "failed", "canceled"))),
    st.tuples(st.just("run"), st.sampled_from(("r1", "r2", "r3"))),
    st.tuples(st.just("question"), st.sampled_from(((), (1,), (2,), (1, 2), (1, 3), (3,)))),
    st.tuples(st.just("model"), st.sampled_from((*CLAIMS, *TALK, *HOSTILE)), st.sampled_from(PROPOSED), st.booleans()),
    st.tuples(st.just("speech"), st.integers(0, 6), st.sampled_from(("whole", "whole", "cut", "failed"))),
    st.tuples(st.just("order"), st.integers(0, 9), st.sampled_from(("", "no"))),
    st.tuples(st.just("waits"), st.sampled_from((0.3, 3.0, 25.0))),
    st.tuples(st.just("begins_before"), st.sampled_from((0.1, 0.5, 4.0))),
    st.tuples(st.just("speaker"), st.booleans()),
)
scripts = st.lists(st.one_of(speaks, lists), min_size=5, max_size=45)


class Referee:
    """Plays a script, and holds every output to what must never happen."""

    def __init__(self, may: Mapping[str, set[str]] = MAY, *, is_kind: bool = False) -> None:
        granted = {role: sorted(orders) for role, orders in may.items()}
        self.may, self.at, self.is_kind = may, 0.0, is_kind
        self.view = BEGIN
        self.dialogue = Dialogue(Settings(has_model=True, may=ConversationPolicy(may=granted).granted()), self.view)
        self.spoken: list[Utterance] = []
        self.read_back: tuple[Speech, StatusView, float] | None = None
        self.spoken_since: set[tuple[str, str]] = set()
        """Who has spoken of something else since the last reading back."""
        self.whole: dict[str, list[bool]] = {}
        """Report → each time that it was spoken whole: whether it was marked as repeated."""
        self.ended_badly: dict[str, set[str]] = {}
        self.open: list[Speech] = []
        self.began: dict[str, int] = {}
        self.request = 0
        self.queued = 0
        self.before = 0.0
        """How long ago the next sentence began: it is transcribed only now."""

    def play(self, script: list[tuple[Any, ...]]) -> None:
        for kind, *rest in script:
            self.at += 0.2
            getattr(self, f"_{kind}")(*rest)

    def _speaks(self, door: Any, author: str, text: str, second: str | None) -> None:
        readings = (
            (text, second) if second is not None and door[1] == "voice" else (text,) if door[1] == "voice" else ()
        )
        received, self.before = Utterance(text, door[0], door[1], author, self.at - self.before, readings), 0.0
        self.spoken.append(received)
        outputs = self.dialogue.on_utterance(received, self.view)
        self._judge(outputs, received)
        is_new = any(isinstance(each, Speech) and "yes or no" in each.text for each in outputs)
        if not is_new and not any(each in YES for each in (text, *received.readings)):
            self.spoken_since.add(received.speaker)
        plain = {each.lower().strip(" !.") for each in (received.readings or (received.text,))}
        if "stop" in plain and "stop" in self.may[received.role]:
            assert any(isinstance(each, Order) and each.name == "stop" for each in outputs), received

    def _mode(self, mode: str) -> None:
        self._status(self.view._replace(mode=mode, outcome=None if mode in ALIVE else mode))

    def _run(self, run: str) -> None:
        if run != self.view.run:
            self._status(self.view._replace(run=run, mode="ready", outcome=None, questions=()))

    def _question(self, numbers: tuple[int, ...]) -> None:
        asked = [
            Question(number, f"asking_{number}", "operator", "Which way?", tuple(map(Offer, offered, offered.values())))
            for number in (numbers if self.view.mode in ALIVE else ())
            for offered in (OTHERS if number > 1 else OFFERED,)
        ]
        confirm = frozenset((each.number, "drive_over") for each in asked)
        self._status(self.view._replace(questions=tuple(asked), confirm=confirm))

    def _status(self, view: StatusView) -> None:
        before, self.view = self.view, view._replace(at=self.at, revision=self.view.revision + 1)
        self._judge(self.dialogue.on_status(self.view, self.at), None, before)
        for each in self.view.questions if self.view.mode in ALIVE else ():
            assert f"{self.view.run}:question:{each.number}" in self.began, "a question that is open was not put"

    def _model(self, text: str, order: Any, is_end: bool) -> None:
        self._judge(self.dialogue.on_model(ModelText(self.request, text + " ", order, is_end, "", self.at)), None)

    def _speech(self, index: int, result: Any) -> None:
        if index < len(self.open):
            speech = self.open.pop(index)
            result = "whole" if self.is_kind else result
            if result == "whole" and speech.report:
                self.whole.setdefault(speech.report, []).append(speech.repeated)
            self.ended_badly.setdefault(speech.report, set()).add(result)
            if self.read_back is not None and self.read_back[0].key == speech.key:
                self.read_back = (speech, self.view, self.at) if result != "failed" else None
            self._judge(self.dialogue.on_speech_end(SpeechEnd(speech.key, result, self.at)), None)

    def _order(self, number: int, why: str) -> None:
        self._judge(self.dialogue.on_order_end(OrderEnd(number, OrderResult(why), self.at)), None)

    def _waits(self, seconds: float) -> None:
        self.at += seconds
        self._judge(self.dialogue.on_time(self.at), None)

    def _begins_before(self, seconds: float) -> None:
        self.before = seconds

    def _speaker(self, is_alive: bool) -> None:
        outputs = self.dialogue.on_speaker(is_alive=is_alive or self.is_kind, at=self.at)
        if not is_alive:
            for each in self.open:
                self.ended_badly.setdefault(each.report, set()).add("failed")
            self.open.clear()
        self._judge(outputs, None)

    # -- the judgment --------------------------------------------------------------------------------------------------

    def _judge(self, outputs: tuple[Output, ...], received: Utterance | None, before: StatusView | None = None) -> None:
        for each in outputs:
            if isinstance(each, Order):
                self._judge_order(each, received, before)
            elif isinstance(each, Speech):
                self._judge_speech(each)
            elif isinstance(each, AskModel):
                self.request = each.number
        assert len(self.dialogue.history) <= self.dialogue.settings.history

    def _judge_order(self, order: Order, received: Utterance | None, before: StatusView | None) -> None:
        assert order.name in self.may[order.role], "outside the role"
        assert any(
            (each.text, each.role, each.channel, each.author)
            == (order.sentence, order.role, order.channel, order.author)
            for each in self.spoken
        ), "of no sentence that was received from that door"
        if received is None:
            assert order.name == "start" and before is not None, "without a person, or for no end of a mission"
            assert self.view.mode == "succeeded" and order.confirmed
            return
        needs = order.name in ("start", "cancel") or order.mapper == "model" or order.option == "drive_over"
        assert bool(order.confirmed) or not needs, "not confirmed"
        if order.confirmed:
            self._judge_confirmation(order, received)
        elif received.readings and order.name in ("resume", "answer"):
            assert len(received.readings) == 2, "one recogniser"
        self._judge_now(order)

    def _judge_confirmation(self, order: Order, received: Utterance) -> None:
        assert self.read_back is not None, "nothing was read back"
        speech, view, at = self.read_back
        words = order.mission or order.option or order.name
        assert words.replace("_", " ") in speech.text or order.name in speech.text, "another order was read back"
        assert received.text in YES or received.text.startswith("yes"), "no yes"
        assert received.at >= at, "a yes that began before the reading back"
        assert order.name in self.may[received.role], "the yes of one who may not"
        assert not received.readings or sum(each in YES or each.startswith("yes") for each in received.readings) == 2
        is_cancel = order.name == "cancel" and self.view.mode in ALIVE  # which may be given in any mode
        assert (view.run, view.mode) == (self.view.run, view.mode if is_cancel else self.view.mode), (
            "the run has changed"
        )
        assert self.at - at < 100
        assert received.speaker not in self.spoken_since, "a yes after something else"
        self.read_back = None

    def _judge_now(self, order: Order) -> None:
        mode = self.view.mode
        begins_by_itself = mode == "ready" and not self.view.awaits_start
        assert order.name != "pause" or mode == "running" or begins_by_itself
        assert order.name != "resume" or mode == "paused"
        assert order.name != "cancel" or mode in ("ready", "running", "paused")
        assert order.name != "start" or mode not in ("running", "paused", "canceling")
        if order.name == "answer":
            question = self.view.question(order.question)
            assert question is not None and order.option in {offer.name for offer in question.options}

    def _judge_speech(self, speech: Speech) -> None:
        self.open.append(speech)
        if speech.way == "model":
            assert not any(claim in speech.text for claim in CLAIMS), "a claim"
        if "yes or no" in speech.text and not speech.report:
            self.read_back, self.spoken_since = (speech, self.view, self.at), set()
        if not speech.report:
            return
        assert speech.report not in self.whole, "a report that was spoken whole"
        if speech.report in self.began:
            late = any(each.report == speech.report for each in self.open[:-1])
            assert speech.repeated or (self.ended_badly.get(speech.report) and not late), "a report is under way"
            assert speech.uncut or speech.repeated, "a report is cut once at most"
        self.began[speech.report] = self.began.get(speech.report, 0) + 1

    def finish(self) -> None:
        """A speaker that works again speaks everything; then each report was spoken whole, once."""
        self.is_kind = True
        self._mode("succeeded")
        for _ in range(40):
            self.at += 10
            self._speaker(True)
            self._judge(self.dialogue.on_time(self.at), None)
            while self.open:
                self._speech(0, "whole")
        assert self.dialogue.unspoken == ()
        assert f"{self.view.run}:end" in self.whole
        assert all(each.count(False) <= 1 for each in self.whole.values()), "twice, and not marked"


QUICK = settings(max_examples=50, deadline=None, phases=[Phase.generate, Phase.shrink], derandomize=True)
LARGE = settings(
    max_examples=1_000, deadline=None, phases=[Phase.generate, Phase.shrink], suppress_health_check=list(HealthCheck)
)


def hold(script: list[tuple[Any, ...]]) -> None:
    referee = Referee()
    referee.play(script)
    referee.finish()


SPOKEN = {
    "pause the mission": "pause", "wait": "pause", "resume the mission": "resume", "continue": "resume",
    "cancel the mission": "cancel", "start the mission": "start",
}  # fmt: skip
POSSIBLE = {
    "ready": {"start", "pause", "cancel"}, "running": {"pause", "cancel", "start"},
    "paused": {"resume", "cancel", "start"}, "canceling": {"start"}, "succeeded": {"start"},
}  # fmt: skip
"""In a mode; a start during a mission is a request for later."""


@given(
    st.sampled_from(sorted(SPOKEN)), st.sampled_from(sorted(SPOKEN)), st.sampled_from(sorted(POSSIBLE)),
    st.integers(1, 2),
)  # fmt: skip
@settings(max_examples=150, deadline=None, derandomize=True)
def test_an_order_is_given_at_once_where_no_other_reading_is_possible_now(
    first: str, other: str, mode: str, agreeing: int
) -> None:
    view = BEGIN._replace(mode=mode, outcome=None if mode in ALIVE else mode)
    dialogue = Dialogue(Settings(may=ConversationPolicy(may={"person": sorted(MAY["operator"])}).granted()), view)
    read = Utterance(first, "person", "voice", "", 1.0, (first,) * agreeing + (other,) * 2)
    outputs = dialogue.on_utterance(read, view)
    one, two = SPOKEN[first], SPOKEN[other]
    at_once = one in POSSIBLE[mode] and (one == two or two not in POSSIBLE[mode])
    at_once = at_once and (one == "pause" or (one == "resume" and (agreeing == 2 or one == two)))
    assert [each.name for each in outputs if isinstance(each, Order)] == [one] * at_once
    texts = " ".join(each.text for each in outputs if isinstance(each, Speech))
    is_open = one in ("pause", "resume") and {one, two} <= POSSIBLE[mode] and one != two
    assert ("in other words" in texts) == is_open, texts


@given(scripts)
@QUICK
def test_no_talk_orders_what_was_not_permitted_possible_and_confirmed(script: list[tuple[Any, ...]]) -> None:
    hold(script)


test_no_talk_orders_what_was_not_permitted_possible_and_confirmed_at_length = drill(hold, scripts, tried=LARGE)


def ask_again(between: list[str], door: Any) -> None:
    referee = Referee({**MAY, "person": MAY["operator"]}, is_kind=True)
    is_aloud = door[1] == "voice"
    for text in ("cancel the mission", *between, "yes", "yes"):
        referee.play([("speaks", door, "Anna", text, text if is_aloud else None)])


def answer_early(between: list[tuple[Any, ...]], before: float, speaker: str) -> None:
    referee, door = Referee({**MAY, "person": MAY["operator"]}), ("person", "voice")
    referee.play([("speaks", door, "Anna", "cancel the mission", "cancel the mission"), *between])
    referee.play([("begins_before", before), ("speaks", door, speaker, "yes", "yes")])
    referee.finish()


MEANWHILE = st.one_of(
    st.tuples(st.just("speech"), st.integers(0, 2), st.sampled_from(("whole", "cut", "failed"))),
    st.tuples(st.just("speaker"), st.booleans()),
    st.tuples(st.just("mode"), st.sampled_from(("running", "paused", "succeeded", "failed"))),
    st.tuples(st.just("waits"), st.sampled_from((0.3, 3.0))),
    st.tuples(st.just("speaks"), st.just(("operator", "page")), st.just("Ben"), st.sampled_from(HOSTILE), st.none()),
)
early = (st.lists(MEANWHILE, max_size=5), st.sampled_from((0.0, 0.1, 0.5, 4.0)), st.sampled_from(("Anna", "Cleo")))


@given(*early)
@example([("speech", 0, "cut")], 0.5, "Anna")
@example([("speech", 0, "failed")], 0.0, "Anna")
@settings(max_examples=150, deadline=None, derandomize=True)
def test_a_spoken_yes_counts_only_if_it_began_after_the_reading_back_was_spoken(
    between: list[tuple[Any, ...]], before: float, speaker: str
) -> None:
    answer_early(between, before, speaker)


test_a_spoken_yes_counts_only_if_it_began_after_the_reading_back_was_spoken_at_length = drill(
    answer_early, *early, tried=LARGE
)


confirmed = (st.lists(st.sampled_from(HOSTILE), min_size=1, max_size=4), st.sampled_from((*DOORS[:2], DOORS[3])))


@given(*confirmed)
@settings(max_examples=30, deadline=None, derandomize=True)
def test_a_yes_after_something_else_is_asked_again(between: list[str], door: Any) -> None:
    ask_again(between, door)


test_a_yes_after_something_else_is_asked_again_at_length = drill(ask_again, *confirmed, tried=LARGE)


def forge(sentences: list[tuple[str, str]]) -> None:
    plain, forged = Dialogue(view=BEGIN), Dialogue(view=BEGIN)
    for at, (author, text) in enumerate(sentences):
        one = plain.on_utterance(Utterance(text, "person", "topic", "", at), BEGIN)
        other = forged.on_utterance(Utterance(text, "person", "topic", author, at), BEGIN)
        kinds = [type(each) for each in one]
        assert kinds == [type(each) for each in other]
        assert all(each.name == "stop" for each in other if isinstance(each, Order))


forgeries = st.lists(st.tuples(st.sampled_from(AUTHORS), st.sampled_from(HOSTILE)), max_size=30)


@given(forgeries)
@settings(max_examples=15, deadline=None, derandomize=True)
def test_a_forged_author_or_text_changes_nothing_but_names(sentences: list[tuple[str, str]]) -> None:
    forge(sentences)


test_a_forged_author_or_text_changes_nothing_but_names_at_length = drill(forge, forgeries, tried=LARGE)
