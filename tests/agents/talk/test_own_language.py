# SPDX-License-Identifier: Apache-2.0
"""A conversation in German has no sentence of the engine, which is English: only names, and what authors wrote."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator, Mapping
from typing import Any

import pytest

from rai_missions.conversation import Dialogue, MissionView, OrderEnd, Settings, Speech, StatusView, Utterance
from rai_missions.conversation.inputs import OrderResult
from rai_missions.conversation.language.language import language
from rai_missions.mission.start_fault import StartFault
from rai_missions.runtime.clock import WallClock
from tests.agents.talk.scenes import Talk
from tests.agents.talk.test_conversation import MOVING
from tests.agents.talk.test_laws import ERRAND, KEYS, errand
from tests.rigs.runs import asking, mission

GERMAN = Settings(language="de")
SENTENCES = (
    "was machst du?", "wie weit bist du?", "warum hast du angehalten?", "was ist passiert?", "wer hat das entschieden?",
    "worauf wartest du?", "pause", "weiter", "abbrechen", "ja", "ja", "starte", "starte mit tempo 3", "home", "again",
    "left", "die zweite", "stopp", "was hast du gefragt?", "wer hat die kontrolle?", "nochmal", "wer bist du?",
)  # fmt: skip
ENGLISH = frozenset(
    {"the", "is", "were", "by", "not", "has", "and", "of", "which", "reached", "canceled", "failed", "given", "with"}
)
"""Words of which an English sentence has one, and no German sentence of these conversations."""
WORD = re.compile(r"[^\W\d_]+")


def words(text: str) -> Iterator[str]:
    return (word.lower() for word in WORD.findall(text))


def texts(value: Any) -> Iterator[str]:
    """All texts in a value."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for name, each in value.items():
            yield name
            yield from texts(each)
    elif isinstance(value, list | tuple):
        for each in value:
            yield from texts(each)


def allowed() -> frozenset[str]:
    """The words of the language, of the mission and of those who take part."""
    own = (*texts(language("de").data["texts"]), *texts({**language("de").data, "texts": ""}), *texts(ERRAND))
    return frozenset(words(" ".join((*own, *texts(KEYS), "tried operator person viewer Anna terminal test command"))))


ALLOWED = allowed() - ENGLISH
NAMES = frozenset(
    words("over home again left moving asking turning deciding returning operator Anna terminal test tried")
)


def english_in(talk: Talk, own: frozenset[str] = frozenset()) -> set[str]:
    """The words of the engine that were spoken, and those that are English in any case."""
    engine = " ".join([*(step.why for step in talk.steps), *(note for step in talk.steps for note in step.notes)])
    refused = " ".join(str(row.get("refused", "")) for row in talk.talk() if row["kind"] == "performed")
    foreign = (frozenset(words(f"{engine} {refused}")) | ENGLISH) - ALLOWED - NAMES - own
    return {word for text in talk.screen.texts() for word in words(text)} & foreign


@pytest.mark.parametrize("seed", range(8))
def test_no_sentence_of_the_engine_is_spoken_in_german(seed: int) -> None:
    draw = random.Random(seed)
    talk = errand(seed, settings=GERMAN)
    with talk:
        for text in draw.choices(SENTENCES, k=12):
            talk.agent.wait_answered(1.0)
            talk.agent.receive(text, role="operator", channel="terminal", author="Anna")
        talk.agent.wait_answered(1.0)
        draw.choice((talk.rig.runner.kill, talk.rig.runner.cancel))("test")
        talk.end()
        talk.agent.conclude(2.0)
        for text in ("warum hast du angehalten?", "was ist passiert?", "was machst du?"):
            talk.order(text)
        talk.agent.wait_answered(5.0)
    assert english_in(talk) == set(), talk.screen.texts()


def end_of(states: Any, **given: Any) -> str:
    """What is spoken in German of the end of a run, and that no word of it is English."""
    talk = Talk(mission(states, blackboard=KEYS, **given), settings=GERMAN, arguments={"speed": 1.0})
    with talk:
        talk.end()
        talk.agent.conclude(5.0)
    assert english_in(talk, frozenset(words("calm rushing"))) == set(), talk.screen.texts()
    return next(line.text for line in talk.screen.of_robot() if line.report.endswith(":end"))


OVER: dict[str, Any] = {"over": {"final": "aborted"}}
WAITING: dict[str, Any] = {"moving": {"transitions": [{"after_s": 1, "to": "over"}]}, **OVER}
COUNTING = {"moving": {"transitions": [{"after_s": 1, "to": "turning", "do": [{"set": "count", "add": 1}]}]}}
ALWAYS = {"key": "count", "<": 1}
CIRCLE = {"moving": {"transitions": [{"when": ALWAYS, "to": "turning"}]},
          "turning": {"transitions": [{"when": ALWAYS, "to": "moving"}]}, **OVER}  # fmt: skip
FAILING = {"moving": {"action": "move", "timeout_s": 1, "transitions": [{"on": "succeeded", "to": "over"}]}, **OVER}


@pytest.mark.parametrize(("states", "given", "why"), [
    (WAITING, {}, "der Zustand 'over' wurde erreicht"),
    (CIRCLE, {}, "ihre Regeln laufen im Kreis"),
    (FAILING, {}, "in 'moving' geschah etwas, wofür die Mission keine Regel hat"),
    ({**COUNTING, "turning": {"transitions": [{"after_s": 1, "to": "over"}]}, **OVER},
     {"invariants": {"calm": ALWAYS}}, "die Bedingung 'calm' gilt nicht mehr"),
])  # fmt: skip
def test_each_kind_of_end_is_spoken_in_german(states: Any, given: Any, why: str) -> None:
    assert why in end_of(states, **given)


@pytest.mark.parametrize(("order", "why"), [("kill", "Nothalt durch test"), ("cancel", "durch test")])
def test_who_ended_a_run_is_named_in_german(order: str, why: str) -> None:
    with Talk(mission(MOVING), settings=GERMAN, clock=WallClock()) as talk:
        talk.screen.until(lambda line: "begonnen" in line.text)
        getattr(talk.rig.runner, order)("test")
        talk.end()
        talk.agent.conclude(5.0)
        assert any(line.text.endswith(f": {why}.") for line in talk.screen.of_robot()), talk.screen.texts()
    assert english_in(talk) == set(), talk.screen.texts()


def test_an_answer_that_does_not_count_is_refused_in_german() -> None:
    options = {"left": {"when": {"key": "there", "==": True}}, "right": {}}
    waiting = {"waiting": {"transitions": [{"when": options["left"]["when"], "to": "asking"}]}}
    states = {**waiting, **asking(ask=["operator"], deadline_s=600, options=options)}
    with Talk(mission(states), settings=GERMAN, clock=WallClock()) as talk:
        talk.screen.until(lambda line: "begonnen" in line.text)
        talk.rig.publish("/there", data=True)
        talk.screen.until(lambda line: "Which?" in line.text)
        talk.rig.publish("/there", data=False)
        talk.until(lambda: talk.rig.runner.view.board["there"].value is False)
        talk.order("left")
        talk.screen.until(lambda line: "wurde nicht ausgeführt: 'left' ist jetzt nicht möglich." in line.text)


def test_a_start_that_the_mission_refuses_is_refused_in_german() -> None:
    given = StatusView(run="r1", mode="ready", awaits_start=True, mission="tried", missions=(MissionView("tried"),))
    for fault, why in (
        (StartFault("started", "it has begun"), "sie wurde schon gestartet"),
        (StartFault("missing", "it is missing", "row"), "der Mission fehlt das Argument 'row'"),
        (StartFault("foreign", "it takes none", "row"), "die Mission hat kein Argument 'row'"),
        (StartFault("unfit", "it does not fit", "row"), "der Wert von 'row' passt nicht"),
    ):
        dialogue, result = Dialogue(GERMAN, given), OrderResult.of_start([fault])
        dialogue.on_utterance(Utterance("starte", "operator", "terminal", at=1.0), given)
        dialogue.on_utterance(Utterance("ja", "operator", "terminal", at=2.0), given)
        outputs = dialogue.on_order_end(OrderEnd(1, result, 3.0))
        assert [each.text.partition(": ")[2] for each in outputs if isinstance(each, Speech)] == [f"{why}."]
