# SPDX-License-Identifier: Apache-2.0
"""What a program gives a conversation wrong is refused at once, with what is right."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.talk.doors import TextDoor
from rai_missions.errors import UsageError
from tests.agents.talk.scenes import RepliesModel

DOOR = "a door has channel, is_aloud, is_open, show, silence, speak"
SCREEN = TextDoor("terminal", lambda line: None)


def agent(**given: Any) -> ConversationalAgent:
    return ConversationalAgent(**given)


def received(**given: Any) -> str:
    return agent().receive(given.pop("text", "pause"), **{"role": "operator", "channel": "terminal", **given})


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "settings": (
        lambda: agent(settings={"language": "en"}),
        'settings are Settings(…) or settings_of(profile.conversation), not {"language": "en"}',
    ),
    "a name as a model": (lambda: agent(model="openai:gpt-4o"), "a model is TalkModel(model), not 'openai:gpt-4o'"),
    "a bare model": (lambda: agent(model=RepliesModel()), "a model is TalkModel(model), not RepliesModel"),
    "a folder as a library": (
        lambda: agent(library="identity"),
        "a library is that of an identity, Identity.read(FOLDER).library, not 'identity'",
    ),
    "a name as a door": (lambda: agent(doors=["terminal"]), f"'terminal' is no door: it lacks 'channel'; {DOOR}"),
    "a door without its list": (lambda: agent(doors=SCREEN), "doors are a list, [door], not <rai_missions"),
    "a later door": (lambda: agent().add_door(7), f"7 is no door: it lacks 'channel'; {DOOR}"),  # type: ignore[arg-type]
    "a second door of a channel": (
        lambda: agent(doors=[SCREEN, TextDoor("terminal", lambda line: None)]),
        "the channel 'terminal' has an open door; give this one a channel of its own",
    ),
    "a role": (lambda: received(role="operatr"), "no role 'operatr'; did you mean 'operator'?"),
    "no text": (lambda: received(text=b"pause"), "a sentence is a text, not b'pause'"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_of_another_sort_is_refused_with_what_is_right(name: str) -> None:
    do, sentence = WRONG[name]
    with pytest.raises(UsageError) as refused:
        do()
    assert str(refused.value).startswith(sentence)
