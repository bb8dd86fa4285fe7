# SPDX-License-Identifier: Apache-2.0
"""Several orders in one sentence are confirmed whole or not at all, and do what they do when given one by one.

The oracle is the same dialogue, to which each order is given in a sentence of its own once its turn has come.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from typing import NamedTuple

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.conversation import (
    Dialogue,
    KeyView,
    MissionView,
    Order,
    OrderEnd,
    Output,
    Speech,
    StatusView,
    TalkNote,
    Utterance,
)
from rai_missions.conversation.language.language import language, languages
from rai_missions.engine.modes import next_mode
from rai_missions.planning.text.normalise import each_way
from tests.conversation.stored import settings_in
from tests.conversation.test_forms_of_orders import PHRASES, PLACES
from tests.rigs.laws import drill

ORDERS = {
    "en": {
        "stop": "stop the robot", "pause": "take a break", "resume": "carry on", "cancel": "cancel the mission",
        "kitchen": "go to the kitchen", "study": "go to the study", "cup": "find the cup",
        "home": "go back to your dock",
    },
    "de": {
        "stop": "halt an", "pause": "mach eine Pause", "resume": "mach weiter", "cancel": "brich die Mission ab",
        "kitchen": "fahr in die Küche", "study": "in die Diele fahren", "cup": "such die Tasse",
        "home": "fahr nach Hause",
    },
}  # fmt: skip
STARTS = ("kitchen", "study", "cup", "home")
YES, NO = {"en": "yes", "de": "ja"}, {"en": "no", "de": "nein"}
MOST_ORDERS = 3
"""As many starts may wait."""
KEYS = tuple(KeyView(name, "string", "argument") for name in ("task", "object", "place"))
IDLE = StatusView(missions=(MissionView("assist", "", KEYS),))
RUNNING = IDLE._replace(run="r0", mode="running", mission="assist")
AFTER = {
    "": ("start",), "running": ("stop", "pause", "cancel", "start"), "paused": ("resume", "cancel", "start"),
    "stopped": ("cancel", "start"), "canceled": ("start",), "waiting": ("start",),
}  # fmt: skip
"""What may be ordered next, by what has been: `waiting` is a start that waits for the end of the mission."""


class Drawn(NamedTuple):
    """A list of orders, and how it is written."""

    begins: StatusView
    names: tuple[str, ...]
    joints: tuple[str, ...]


def joints(code: str) -> list[str]:
    """What may be between two orders, as a person types it."""
    words = [" ".join(way) for joint in language(code).data["order_joints"] for way in each_way(joint)]
    return [" ", ", ", ". ", "! ", *(f" {each} " for each in words), *(f", {each} " for each in words)]


def after(state: str, name: str) -> str:
    """What has been ordered once this is."""
    if name in STARTS:
        return "running" if state in ("", "canceled") else "waiting"
    return {"stop": "stopped", "pause": "paused", "resume": "running", "cancel": "canceled"}[name]


@st.composite
def lists(draw: st.DrawFn, code: str) -> Drawn:
    begins = draw(st.sampled_from((IDLE, RUNNING)))
    state, names = begins.mode, list[str]()
    for _ in range(draw(st.integers(2, MOST_ORDERS))):
        kind = draw(st.sampled_from([kind for kind in AFTER[state] if kind != "stop" or not names]))
        name = draw(st.sampled_from([each for each in STARTS if [each] != names[-1:]])) if kind == "start" else kind
        names.append(name)
        state = after(state, name)
    between = draw(st.lists(st.sampled_from(joints(code)), min_size=len(names) - 1, max_size=len(names) - 1))
    return Drawn(begins, tuple(names), tuple(between))


def sentence(code: str, drawn: Drawn) -> str:
    first, *others = (ORDERS[code][name] for name in drawn.names)
    return first + "".join(f"{joint}{each}" for joint, each in zip(drawn.joints, others, strict=True))


class Robot:
    """A run that does what it is ordered, and the dialogue about it.

    Args:
        code: Of the language.
        view: How it begins.
    """

    def __init__(self, code: str, view: StatusView) -> None:
        self.code, self.view, self.at, self.runs = code, view, 0.0, 0
        self.steps: list[tuple[object, ...]] = []
        """Each order that the run took: the run, the order and its arguments."""
        self.dialogue = Dialogue(settings_in(code, PHRASES[code], PLACES[code]["place"]), view)

    def types(self, text: str, role: str = "operator") -> list[TalkNote]:
        """A person's sentence; the notes of what was read back, here and at what follows from it."""
        self.at += 2.0
        return list(
            self._performed(self.dialogue.on_utterance(Utterance(text, role, "terminal", at=self.at), self.view))
        )  # type: ignore[arg-type]

    def ends(self) -> list[TalkNote]:
        """The run ends with success."""
        return self._is_now(mode="succeeded", outcome="succeeded")

    def _is_now(self, **changed: object) -> list[TalkNote]:
        self.at += 2.0
        self.view = self.view._replace(at=self.at, revision=self.view.revision + 1, **changed)
        return list(self._performed(self.dialogue.on_status(self.view, self.at)))

    def _performed(self, outputs: Sequence[Output]) -> Iterator[TalkNote]:
        yield from (each for each in outputs if isinstance(each, TalkNote) and each.kind == "read_back")
        for order in (each for each in outputs if isinstance(each, Order)):
            self.steps.append((self.view.run, order.name, dict(order.arguments)))
            yield from self._performed(self.dialogue.on_order_end(OrderEnd(order.number, at=self.at)))
            if order.name == "start":
                self.runs += 1
                yield from self._is_now(run=f"r{self.runs}", mode="running", outcome=None, mission="assist")
            elif order.name == "cancel":
                yield from self._is_now(mode="canceled", outcome="canceled")
            else:
                yield from self._is_now(mode=next_mode(self.view.mode, "pause" if order.name == "stop" else order.name))


def confirmed(robot: Robot, asked: Sequence[TalkNote]) -> int:
    """A yes to all that is read back, and an end of all that runs; how often a yes was needed."""
    count = 0
    while asked or robot.view.is_alive:
        count += bool(asked)
        asked = robot.types(YES[robot.code]) if asked else robot.ends()
    return count


def holds(code: str, drawn: Drawn) -> None:
    text, whole, single = sentence(code, drawn), Robot(code, drawn.begins), Robot(code, drawn.begins)
    asked = whole.types(text)
    at_once = [step[1] for step in whole.steps]
    names = list(drawn.names[1:] if drawn.names[0] == "stop" else drawn.names)
    must = [name for name in names if name not in ("pause", "resume")]
    assert at_once == (["stop"] if drawn.names[0] == "stop" else [] if must else names[:1]), (text, at_once)
    if must:
        (read,) = asked
        assert len(read.data["order"].get("then", ())) == len(names) - 1, (text, read)
    dropped = Robot(code, drawn.begins)
    dropped.types(text)
    dropped.types(NO[code])
    assert [step[1] for step in dropped.steps] == at_once, text
    resumed = sum(pair in (("pause", "resume"), ("stop", "resume")) for pair in pairwise(drawn.names))
    assert confirmed(whole, asked) == bool(must) + resumed, text
    for name in drawn.names:
        asked = single.types(ORDERS[code][name])
        while asked:
            asked = single.types(YES[code])
    confirmed(single, [])
    assert whole.steps == single.steps, (text, whole.steps, single.steps)


TRIED = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
OFTEN = settings(TRIED, max_examples=2_000)
each_language = st.sampled_from(languages()).flatmap(lambda code: st.tuples(st.just(code), lists(code)))


def play(case: tuple[str, Drawn]) -> None:
    holds(*case)


test_a_list_is_confirmed_whole_or_not_and_does_what_its_orders_do = TRIED(given(each_language)(play))
test_a_list_is_confirmed_whole_or_not_and_does_what_its_orders_do_often = drill(play, each_language, tried=OFTEN)


@st.composite
def stops(draw: st.DrawFn, code: str) -> Drawn:
    """Orders with a stop anywhere among them."""
    drawn = draw(lists(code))
    names = [name for name in drawn.names if name != "stop"]
    names.insert(draw(st.integers(0, len(names))), "stop")
    joints_of = draw(st.lists(st.sampled_from(joints(code)), min_size=len(names) - 1, max_size=len(names) - 1))
    return Drawn(RUNNING, tuple(names), tuple(joints_of))


@TRIED
@given(st.sampled_from(languages()).flatmap(lambda code: st.tuples(st.just(code), stops(code))))
def test_a_stop_anywhere_in_a_list_counts_at_once_and_first(case: tuple[str, Drawn]) -> None:
    code, drawn = case
    robot = Robot(code, drawn.begins)
    asked = robot.types(sentence(code, drawn))
    assert [step[1] for step in robot.steps][:1] == ["stop"], sentence(code, drawn)
    behind = len(drawn.names) - drawn.names.index("stop") - 1
    for read in asked:
        assert len(read.data["order"].get("then", ())) < behind, "what is ahead of a stop is dropped"


OTHERWISE = {
    "en": {
        "before you go to the kitchen find the cup": ("cup", "kitchen"),
        "go back to your dock, but first go to the study": ("study", "home"),
        "go to the kitchen n then the study": ("kitchen", "study"),
        "go back to your dock and go to the study on your way": ("study", "home"),
        "go to the kitchen go find the cup": ("kitchen", "cup"),
        "first the kitchen, then find the cup": ("kitchen", "cup"),
        "go to the kitchen, find the cup afterwards": ("kitchen", "cup"),
        "could you go to the kitchen and find the cup?": ("kitchen", "cup"),
        "would you mind going to the kitchen and finding the cup": ("kitchen", "cup"),
        "it is late, go to the kitchen. We all wait. Find the cup": ("kitchen", "cup"),
        "go to the kitchen and once you're there find the cup": ("kitchen", "cup"),
        "find the cup, and when you have found it go back to your dock": ("cup", "home"),
        "go to the kitchen, then": ("kitchen",), "go to the kitchen, no, the study": ("study",),
    },
    "de": {
        "bevor du in die Küche fährst such die Tasse": ("cup", "kitchen"),
        "fahr nach Hause, aber vorher in die Diele": ("study", "home"),
        "fahr in die Küche u dann in die Diele": ("kitchen", "study"),
        "fahr nach Hause und such die Tasse auf dem Weg": ("cup", "home"),
        "erst die Küche, dann such die Tasse": ("kitchen", "cup"),
        "fahr in die Küche und such die Tasse hinterher": ("kitchen", "cup"),
        "kannst du in die Küche fahren und die Tasse suchen?": ("kitchen", "cup"),
        "in die Küche fahrn und die Tasse suchn": ("kitchen", "cup"),
        "es ist spät, fahr in die Küche. Wir warten alle. Such die Tasse": ("kitchen", "cup"),
        "fahr in die Küche und wenn du dort bist such die Tasse": ("kitchen", "cup"),
        "fahr in die Küche, dann": ("kitchen",),
    },
}  # fmt: skip


@pytest.mark.parametrize(
    ("code", "text", "names"), [(code, *each) for code in OTHERWISE for each in OTHERWISE[code].items()]
)
def test_a_list_in_other_words_is_the_list_of_its_orders(code: str, text: str, names: tuple[str, ...]) -> None:
    robot = Robot(code, IDLE)
    (read,) = robot.types(text)
    orders = [Robot(code, IDLE).types(ORDERS[code][name])[0].data["order"] for name in names]
    first = read.data["order"]
    assert [{name: value for name, value in first.items() if name != "then"}, *first.get("then", ())] == orders


@pytest.mark.parametrize(
    ("code", "text", "names"),
    [
        ("en", "find the bus stop", ("find the bus stop",)), ("en", "before you stop find the cup", ()),
        ("en", "go to the kitchen or find the cup", ()), ("en", "if it rains go to the kitchen and find the cup", ()),
        ("en", "he wrote: go to the kitchen and find the cup", ()), ("de", "bevor du anhältst such die Tasse", ()),
        ("de", "fahr in die Küche oder such die Tasse", ()), ("de", "wenn es regnet fahr heim und such die Tasse", ()),
    ],
)  # fmt: skip
def test_a_choice_a_condition_and_the_words_of_others_are_no_list(code: str, text: str, names: tuple[str, ...]) -> None:
    robot = Robot(code, RUNNING)
    assert [each.data["order"] for each in robot.types(text)] == [
        each.data["order"] for name in names for each in Robot(code, RUNNING).types(name)
    ]
    assert robot.steps == []


@pytest.mark.parametrize(
    ("code", "joint"),
    [
        ("en", "and"),
        ("en", "then"),
        ("en", "and then"),
        ("en", "next"),
        ("de", "und"),
        ("de", "dann"),
        ("de", "und dann"),
    ],
)
def test_a_joint_at_the_beginning_changes_no_order(code: str, joint: str) -> None:
    def spoken(text: str) -> list[str]:
        dialogue = Dialogue(settings_in(code, PHRASES[code], PLACES[code]["place"]), RUNNING)
        outputs = dialogue.on_utterance(Utterance(text, "operator", "terminal", at=2.0), RUNNING)
        return [each.text for each in outputs if isinstance(each, Speech) and not each.report]

    for order in (ORDERS[code]["cup"], f"{ORDERS[code]['cup']}, {ORDERS[code]['kitchen']}"):
        assert spoken(f"{joint} {order}") == spoken(order)


def test_a_part_whose_value_does_not_fit_is_refused_with_what_would() -> None:
    waits = KeyView("wait_s", "integer", "argument", minimum=1, maximum=60)
    view = IDLE._replace(missions=(MissionView("assist", "", (*KEYS, waits)),))
    phrases = {**PHRASES["en"], "wait {wait_s} seconds": {"task": "wait"}}
    dialogue = Dialogue(settings_in("en", phrases, PLACES["en"]["place"]), view)
    outputs = dialogue.on_utterance(
        Utterance(f"{ORDERS['en']['kitchen']}, then wait 99 seconds", "operator", "terminal", at=1.0), view
    )
    why, read_back = [each.text for each in outputs if isinstance(each, Speech) and not each.report]
    assert why == "'99' is no value for wait: it must be a whole number from 1 to 60 s." and "kitchen" in read_back


@pytest.mark.parametrize("code", languages())
def test_the_yes_of_who_stopped_counts_for_what_was_read_back_with_the_stop(code: str) -> None:
    robot = Robot(code, RUNNING)
    robot.types(ORDERS[code]["cup"])
    robot.types(f"{ORDERS[code]['stop']}, {ORDERS[code]['kitchen']}")
    assert robot.types(YES[code]) == []  # it is not read back again


@pytest.mark.parametrize("code", languages())
@pytest.mark.parametrize("role", ["operator", "person", "viewer"])
def test_a_role_gives_a_list_only_where_it_may_give_each_of_its_orders(code: str, role: str) -> None:
    robot = Robot(code, RUNNING)
    asked = robot.types(f"{ORDERS[code]['cup']}, {ORDERS[code]['cancel']}", role)
    assert bool(asked) == (role == "operator")
    assert robot.steps == []


THERE = {
    "en": (
        {"find {object} in {place}": {"task": "find"}, "look in {place}": {"task": "look"}},
        "find the cup in the {}",
    ),
    "de": (
        {"suche {object} in {place}": {"task": "find"}, "schau in {place}": {"task": "look"}},
        "such die Tasse in der {}",
    ),
}
LOOKS = {"en": ("look {}", "in the {}", ("there", "in there")), "de": ("schau {}", "in die {}", ("dort", "da"))}


@pytest.mark.parametrize("code", languages())
def test_there_is_the_place_that_was_named_last(code: str) -> None:
    phrases, first = THERE[code]
    look, placed, pronouns = LOOKS[code]
    dialogue_settings = settings_in(code, phrases, PLACES[code]["place"])

    def meant(text: str) -> list[object]:
        outputs = Dialogue(dialogue_settings, IDLE).on_utterance(Utterance(text, "operator", "terminal", at=2.0), IDLE)
        return [each.data["order"] for each in outputs if isinstance(each, TalkNote) and each.kind == "read_back"]

    signs = [each for each in joints(code) if each.strip()]
    for place, joint in product(PLACES[code]["place"], signs[::12]):
        ahead = first.format(place)
        whole = meant(f"{ahead}{joint}{look.format(placed.format(place))}")
        for pronoun in pronouns:
            assert meant(f"{ahead}{joint}{look.format(pronoun)}") == whole != [], (ahead, joint, pronoun)
