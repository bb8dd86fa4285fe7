# SPDX-License-Identifier: Apache-2.0
"""A robot that talks while it works: sentences come in by doors, a dialogue answers, and orders that it judged go out.

Rule: one thread has the dialogue, and nothing on it waits: a model thinks elsewhere, a door speaks elsewhere, and the
run takes an order in its own turn.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, Literal, get_args

from rai_missions.agents.agent import AgentHealth
from rai_missions.agents.talk.attached_run import AttachedRun
from rai_missions.agents.talk.document_search import DocumentSearch
from rai_missions.agents.talk.doors import TalkDoor, TalkDoors, TalkLine
from rai_missions.agents.talk.journal import NoteSink
from rai_missions.agents.talk.model import TalkModel
from rai_missions.agents.talk.orders import OnOrderEnd
from rai_missions.agents.talk.reception import Reception
from rai_missions.agents.talk.run_status import RobotWords
from rai_missions.connectors.worker import Worker
from rai_missions.conversation import (
    AskModel,
    Dialogue,
    LookUp,
    ModelText,
    Order,
    OrderEnd,
    Output,
    Settings,
    Silence,
    Speech,
    SpeechEnd,
    StatusView,
    TalkNote,
    Utterance,
)
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.likeness import Likeness, WordLikeness
from rai_missions.conversation.inputs import OrderResult, SpeechResult
from rai_missions.conversation.language.language import language
from rai_missions.embodiment.library import Library
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError, raised_text, suggestion
from rai_missions.event import Role
from rai_missions.redaction import cut, logger, redacted, shown
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.runner import Runner

__all__ = ("ConversationalAgent", "StartRun")

log = logger(__name__)
LONGEST_NAME = 200
"""Characters of an author's name that are kept."""
SETTINGS, NO_ROBOT, WORDS = Settings(), RobotWords(), WordLikeness()
ROLES = get_args(Role)
StartRun = Callable[[Order, OnOrderEnd], None]
"""Begins another run, once one is over."""


class ConversationalAgent:
    """Talks with people about a run, from `run` to `stop`.

    Args:
        settings: What the profile sets.
        model: What is asked where the rules know no answer; None: then it does not know.
        library: The robot's documents, where a question is looked up that no rule answers; None: it is not.
        doors: Where people speak and write, and where the robot does.
        robot: Who the robot is.
        start: Begins another run where one is over and a person orders so, at once or from those that wait, and takes
            back by "stop" what it has not begun; None: then that is refused, and none waits.
        likeness: Compares what no rule reads with the phrases of orders.
        now: The dialogue's clock, in seconds; the wall's by default.

    Raises:
        UsageError: One of these is of another sort, or there is no such language.
    """

    def __init__(
        self,
        settings: Settings = SETTINGS,
        *,
        model: TalkModel | None = None,
        library: Library | None = None,
        doors: Sequence[TalkDoor] = (),
        robot: RobotWords = NO_ROBOT,
        start: StartRun | None = None,
        likeness: Likeness = WORDS,
        now: Callable[[], float] | None = None,
    ) -> None:
        _check_sorts(settings, model, library, doors)
        requests = settings.requests if start is not None else "refuse"
        self._settings = settings._replace(
            has_model=model is not None, has_documents=library is not None, requests=requests
        )
        self._documents = DocumentSearch(library) if library is not None else None
        self._model, self._doors, self._robot, self._start = model, TalkDoors(doors), robot, start
        began = time.monotonic()
        self._now = now or (lambda: time.monotonic() - began)
        self._opened_at = self._now()
        self._dialogue = Dialogue(self._settings, StatusView(), likeness)
        self._worker = Worker("conversation", on_error=self._failed)
        self.reception = Reception(self._worker, Grammar(language(settings.language)))
        """Where sentences wait for their turn."""
        self._attached: AttachedRun | None = None
        self._lines: dict[str, TalkLine] = {}
        """Speech's key → its line, until it has ended."""
        self._count = 0
        self._lock = threading.Lock()
        self._is_news = False
        self._is_open = True
        self._idle: Literal["ready", "stopped"] = "ready"
        self._cancel_timer: Callable[[], object] = lambda: None
        self._end_reported, self._is_decided, self._is_looked_up = (threading.Event() for _ in range(3))
        self._is_decided.set()
        self._is_looked_up.set()

    # -- the paper's Agent -----------------------------------------------------------------------------------

    def run(self) -> None:
        """Begin, and return; running already, nothing happens."""
        self._worker.start()
        self._idle = "stopped"
        if self._model is not None:
            self._model.run()

    def stop(self, within_s: float = 2.0) -> None:
        """End within seconds, whatever hangs; stopped already, nothing happens."""
        if self._model is not None:
            self._model.stop()
        if self._documents is not None:
            self._documents.stop(within_s)
        self._worker.close(within_s)

    @property
    def health(self) -> AgentHealth:
        """Whether it takes sentences, which doors are open, and what is wrong with one; the model fails elsewhere."""
        state: Literal["ready", "running", "stopped"] = "running" if self._worker.is_alive else self._idle
        values = {"doors open": ", ".join(self._doors.open) or "none", "sentences waiting": str(self.reception.waiting)}
        return AgentHealth(state, self._doors.fault if state == "running" else "", values)

    @property
    def is_reachable(self) -> bool:
        """Whether it runs, and a person may be reached at a door."""
        return self._worker.is_alive and self._doors.is_open

    # -- the run ---------------------------------------------------------------------------------------------

    def attach(self, runner: Runner, journal: NoteSink | None = None) -> None:
        """Talk about this run from now on; it is not begun yet."""
        self._end_reported.clear()
        self._attached = run = AttachedRun(runner, journal, self._robot, self._note_news, self._take_speech)
        if earlier := run.orders.earlier:
            view = self._view()
            self._post(lambda: self._dialogue.on_earlier_answers(earlier, view, self._now()))
            for order in earlier:
                run.orders.await_judgment(order, self._order_end(order))
        self._note_news()

    def continue_after(self, number: int) -> None:
        """Count lines from the next number on: those before are of the process that this one resumes; before `run`."""
        self._count = max(self._count, number)

    def report_lost(self, requests: Sequence[str]) -> None:
        """Have it reported that these requests are lost, which waited in a program that was killed; after `attach`."""
        if requests:
            self._post(lambda: self._dialogue.on_lost_requests(requests, self._view(), self._now()))

    def step(self, step: Step) -> None:
        """The run has made a step; on its own thread."""
        if self._attached is not None:
            self._attached.step(step)

    def changed(self, status: Status) -> None:
        """The run's status has changed; on its own thread."""
        if self._attached is not None:
            self._attached.changed(status)

    def conclude(self, within_s: float = 5.0) -> bool:
        """The run is over, and its journal still open: have its end reported; whether it was, in that time."""
        if self._attached is None:
            return True
        self._attached.close()
        self.wait_answered(1.0)
        reported = self._end_reported.wait(within_s)
        self.wait_answered(min(1.0, within_s))
        return reported

    def wait_decided(self) -> None:
        """Wait while the run is over and a start waits for a person's yes; two confirmations after the last line.

        Of several requests that wait, each is asked for in its turn.
        """
        self.wait_answered(1.0)
        lines = self._count
        while not self._is_decided.wait(2 * self._settings.confirm_s) and lines != self._count:
            lines = self._count

    def decide_nothing(self) -> None:
        """Nothing is waited for any more; from any thread."""
        self._is_decided.set()

    def end_starts(self) -> None:
        """No run follows the one that there is: starts are dropped and refused; from any thread."""
        self.decide_nothing()
        self._post(lambda: self._dialogue.on_last_run(self._now()))

    # -- people ----------------------------------------------------------------------------------------------

    def receive(
        self,
        text: str,
        *,
        role: Role,
        channel: str,
        author: str = "",
        readings: tuple[str, ...] = (),
        message_id: str = "",
        waited_s: float = 0.0,
        age_s: float = 0.0,
    ) -> str:
        """A person's sentence, from any thread; why it is not taken, or empty. A secret in it is hidden here.

        Args:
            text: The sentence.
            role: What the door grants.
            channel: The door.
            author: A free name.
            readings: Of a spoken one each recogniser's transcription.
            message_id: The message's, if it has one.
            waited_s: For how long it has waited at the door: it is no answer to what was shown meanwhile.
            age_s: How long ago it was sent, by its own stamp: as of one that waited, and an old one is no order.

        Raises:
            UsageError: There is no such role, or the sentence is no text.
        """
        if role not in ROLES:
            raise UsageError(f"no role {shown(role)}{suggestion(str(role), ROLES)}")
        if not isinstance(text, str):
            raise UsageError(f"a sentence is a text, not {shown(text)}")
        if why := self.reception.refuses(text, f"{channel} {role}"):
            return why
        words, at = tuple(map(redacted, readings)), max(self._opened_at, self._now() - max(waited_s, age_s))
        sentence = Utterance(redacted(text), role, channel, cut(author, LONGEST_NAME), at, words, message_id, age_s)
        return "" if self.reception.take(partial(self._take, sentence)) else "the conversation has ended"

    def doors_changed(self) -> None:
        """A door has opened or shut; from any thread."""
        self._worker.post(self._look_at_doors)

    def wait_answered(self, within_s: float) -> None:
        """Wait until what was received so far is answered, or given to a model; not on its own thread."""
        done, until = threading.Event(), time.monotonic() + within_s
        if self.reception.after_all(done.set) and done.wait(within_s):
            self._is_looked_up.wait(max(0.0, until - time.monotonic()))

    def add_door(self, door: TalkDoor) -> None:
        """Open another door; before `run`."""
        self._doors.add(door)

    # -- on the thread of the conversation -------------------------------------------------------------------

    def _post(self, handle: Callable[[], Iterable[Output]]) -> None:
        """Have the dialogue handle something in its turn; from any thread."""
        self._worker.post(lambda: self._perform(handle()))

    def _take(self, sentence: Utterance) -> None:
        self._show(
            TalkLine(self._next(), sentence.role, sentence.text, sentence.author, sentence.channel, at=sentence.at)
        )
        self._perform(self._dialogue.on_utterance(sentence, self._view()))

    def _note_news(self) -> None:
        """Have the dialogue look at the run again; from any thread, once however much there is."""
        with self._lock:
            was, self._is_news = self._is_news, True
        if not was:
            self._worker.post(self._look)

    def _look(self) -> None:
        with self._lock:
            self._is_news = False
        self._perform(self._dialogue.on_status(self._view(), self._now()))

    def _take_speech(self, text: str) -> None:
        self._post(lambda: self._dialogue.on_mission_speech(text, self._now()))

    def _look_at_doors(self) -> None:
        is_open = self._doors.is_open
        if is_open != self._is_open:
            self._is_open = is_open
            self._perform(self._dialogue.on_speaker(is_alive=is_open, at=self._now()))

    def _tick(self) -> None:
        self._perform(self._dialogue.on_time(self._now()))

    def _view(self) -> StatusView:
        return self._attached.status.view() if self._attached is not None else StatusView()

    def _perform(self, outputs: Iterable[Output]) -> None:
        for output in outputs:
            self._perform_one(output)
        (self._is_decided.clear if self._dialogue.asks_to_begin else self._is_decided.set)()
        (self._is_looked_up.clear if self._dialogue.looks_up else self._is_looked_up.set)()
        self._cancel_timer()
        wake_at = self._dialogue.wake_at
        if wake_at is not None:
            self._cancel_timer = self._worker.after(max(0.0, wake_at - self._now()), self._tick)

    def _perform_one(self, output: Output) -> None:
        if isinstance(output, Speech):
            self._speak(output)
        elif isinstance(output, Order):
            self._order(output)
        elif isinstance(output, Silence):
            self._doors.silence(is_total=output.is_total)
        elif isinstance(output, TalkNote):
            if self._attached is not None:
                self._attached.journal.write(output)
        elif isinstance(output, AskModel):
            self._ask(output)
        elif isinstance(output, LookUp):
            self._look_up(output)
        elif self._model is not None:
            self._model.drop(output.number)

    def _speak(self, speech: Speech) -> None:
        line = TalkLine(
            self._next(),
            "robot",
            speech.text,
            channel=speech.to,
            way=speech.way,
            priority=speech.priority,
            at=self._now(),
            repeated=speech.repeated,
            report=speech.report,
        )
        ended: list[SpeechResult] = []

        def on_end(result: SpeechResult) -> None:
            ended.append(result)
            self._worker.post(partial(self._spoken, speech, SpeechEnd(speech.key, result, self._now())))

        self._doors.speak(speech, on_end)  # first: who answers what is shown does so after its end
        self._lines[speech.key] = line = _ended(line, *ended)
        self._show(line)

    def _spoken(self, speech: Speech, end: SpeechEnd) -> None:
        line = self._lines.pop(speech.key, None)
        if line is not None and (late := _ended(line, end.result)) != line:
            self._show(late)
        self._perform(self._dialogue.on_speech_end(end))
        if self._attached is not None and speech.report == f"{self._attached.status.run}:end" and end.result == "whole":
            self._end_reported.set()
        self._worker.post(self._look_at_doors)  # behind the ends of speech that wait already: those still count

    def _order_end(self, order: Order) -> OnOrderEnd:
        def on_end(result: OrderResult) -> None:
            end = OrderEnd(order.number, result, self._now())
            self._post(lambda: self._dialogue.on_order_end(end))

        return on_end

    def _order(self, order: Order) -> None:
        run, on_end = self._attached, self._order_end(order)
        is_over = run is None or run.status.view().outcome is not None
        if order.name in ("start", "stop") and is_over and self._start is not None:
            self._start(order, on_end)
        elif order.name == "start" and is_over:
            on_end(OrderResult("no other mission can be begun here", "last"))
        elif run is None:
            on_end(OrderResult("no mission is running", "no_run"))
        else:
            run.orders.perform(order, on_end)

    def _ask(self, request: AskModel) -> None:
        def on_text(text: ModelText) -> None:
            self._post(lambda: self._dialogue.on_model(text._replace(at=self._now())))

        if self._model is None:
            on_text(ModelText(request.number, is_end=True, failed="there is no model"))
        else:
            self._model.ask(request, self._attached.status.view if self._attached is not None else StatusView, on_text)

    def _look_up(self, request: LookUp) -> None:
        if self._documents is not None:
            self._documents.ask(
                request, lambda found: self._post(lambda: self._dialogue.on_found(found._replace(at=self._now())))
            )

    def _next(self) -> int:
        self._count += 1
        return self._count

    def _show(self, line: TalkLine) -> None:
        self._doors.show(line)
        if self._attached is not None:
            self._attached.journal.line(line)

    def _failed(self, error: BaseException) -> Any:
        log.error("the conversation met an error and continues: %s", raised_text(error), exc_info=error)


def _ended(line: TalkLine, result: SpeechResult = "whole") -> TalkLine:
    """A line of the robot's whose speech has ended so."""
    return line if result == "whole" else line._replace(spoken=result)


def _check_sorts(settings: object, model: object, library: object, doors: object) -> None:
    """Hold what a program gives to its sort, of which the first sentence would learn otherwise.

    Raises:
        UsageError: One is of another.
    """
    if not isinstance(settings, Settings):
        raise UsageError(f"settings are Settings(…) or settings_of(profile.conversation), not {shown(settings)}")
    if model is not None and not isinstance(model, TalkModel):
        raise UsageError(f"a model is TalkModel(model), not {shown(model)}")
    if library is not None and not isinstance(library, Library):
        raise UsageError(f"a library is that of an identity, Identity.read(FOLDER).library, not {shown(library)}")
    if not isinstance(doors, Sequence):
        raise UsageError(f"doors are a list, [door], not {shown(doors)}")
