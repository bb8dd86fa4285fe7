# SPDX-License-Identifier: Apache-2.0
"""Two robots receive what is written on one topic: an order with the name of one is given by no word to the other.

Only to halt is for all: who calls out may not know which robot it is.
"""

from __future__ import annotations

from itertools import permutations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.conversation import Dialogue, Order, Output, Settings, StatusView, Utterance
from rai_missions.engine.decision import Offer, Question
from tests.rigs.laws import drill

NAMES = ("alpha", "beta", "tractor1", "tractor2", "ROSbot XL", "otto")
FORMS = {
    "en": (
        "{name}, {text}", "hey {name}, {text}", "hello {name}. {text}", "hi {name}! {text}", "{text}, {name}",
        "good morning {name}, {text}", "thanks {name}, {text}", "{text}, thanks {name}", "{name} {text}",
        "sorry {name}, {text}", "{text}. thanks {name}",
    ),
    "de": ("{name}, {text}", "hallo {name}, {text}", "hi {name}! {text}", "danke {name}, {text}", "{text}, {name}"),
}  # fmt: skip
ORDERS = {
    "en": ("resume", "carry on", "cancel the mission", "yes", "option 1", "replan", "take the next alley"),
    "de": ("mach weiter", "brich die Mission ab", "ja", "die erste"),
}
HALTS = ("stop", "pause")
"""What counts for all: a person who calls out may not know which robot it is."""
OFFERS = (Offer("replan", "take the next alley"), Offer("wait_here", "wait here"))
QUESTION = Question(number=1, owner="asking", asked="operator", text="What now?", options=OFFERS)
RUNNING = StatusView(mode="running", mission="work", run="r0", questions=(QUESTION,))
PAUSED = RUNNING._replace(mode="paused")

sentences = st.sampled_from(sorted(FORMS)).flatmap(
    lambda code: st.tuples(
        st.just(code),
        st.sampled_from(list(permutations(NAMES, 2))),
        st.lists(
            st.tuples(st.booleans(), st.sampled_from(FORMS[code]), st.sampled_from(ORDERS[code])),
            min_size=1,
            max_size=6,
        ),
        st.sampled_from((RUNNING, PAUSED)),
    )
)
"""A language, two robots, what is ordered of the one or the other, and how it is written."""


def ordered(outputs: tuple[Output, ...]) -> list[str]:
    return [each.name for each in outputs if isinstance(each, Order) and each.name not in HALTS]


def address(script: tuple[str, tuple[str, str], list[tuple[bool, str, str]], StatusView]) -> None:
    code, names, written, view = script
    robots = {name: Dialogue(Settings(language=code), view._replace(robot=name)) for name in names}
    for at, (is_first, form, text) in enumerate(written):
        name, other = names if is_first else names[::-1]
        for each in names:
            received = Utterance(form.format(name=name, text=text), "operator", "topic", "Anna", 3.0 * at + 1.0)
            outputs = robots[each].on_utterance(received, view._replace(robot=each, at=received.at))
            assert each == name or not ordered(outputs), (other, received.text)


test_no_order_with_the_name_of_one_robot_is_given_to_the_other = settings(max_examples=60, deadline=None)(
    given(sentences)(address)
)
test_no_order_with_the_name_of_one_robot_is_given_to_the_other_often = drill(
    address, sentences, tried=settings(max_examples=5_000, deadline=None)
)


@pytest.mark.parametrize("name", [*NAMES, "tractor1, simulated", "rob 2"])
def test_a_robot_does_what_is_ordered_with_its_own_name(name: str) -> None:
    view, name = PAUSED._replace(robot=name), name.partition(",")[0]
    for form in FORMS["en"]:
        dialogue = Dialogue(Settings(), view)
        outputs = dialogue.on_utterance(Utterance(form.format(name=name, text="resume"), "operator", "topic"), view)
        assert ordered(outputs) == ["resume"], form


@pytest.mark.parametrize("text", ["{name}", "hey {name}!", "{name}?", "{name}, hello"])
@pytest.mark.parametrize("robot", ["tractor1", "tractor1, simulated", "tractor2", "rob 2"])
def test_a_name_with_a_number_answers_no_question(robot: str, text: str) -> None:
    view = RUNNING._replace(robot=robot)
    for name in (robot.partition(",")[0], "tractor1", "rob 2"):
        received = Utterance(text.format(name=name), "operator", "topic")
        assert not ordered(Dialogue(Settings(), view).on_utterance(received, view)), received
