# SPDX-License-Identifier: Apache-2.0
"""Secrets in a conversation: a person utters them, a model repeats them, and no door, journal or history has them."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.conversation import Dialogue, Settings, Speech, StatusView, Utterance
from rai_missions.runtime.clock import WallClock
from tests.agents.talk.scenes import RepliesModel, Talk
from tests.rigs.runs import mission

KNOWN, SHAPED = "canary-key-4b1d", "sk-proj-Qk3mQ9vT7wXyB2nC5dF8hJ"
MOVING: dict[str, Any] = {
    "moving": {"action": "move", "timeout_s": 600, "transitions": [{"on": "succeeded", "to": "over"}]},
    "over": {"final": "aborted"},
}  # fmt: skip


def test_nothing_of_a_conversation_holds_a_secret_that_a_person_or_a_model_utters(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("STRANGERS_API_KEY", KNOWN)
    model, author = RepliesModel(reply=f"You could try {KNOWN} or {SHAPED}."), f"Anna {KNOWN}"
    with Talk(mission(MOVING), clock=WallClock(), model=model) as talk:
        talk.screen.until(lambda line: "started" in line.text)
        for count, text in enumerate((f"what of {KNOWN} {SHAPED}", f"start the {KNOWN}"), start=1):
            talk.order(text, author=author)
            talk.until(lambda count=count: [line.way for line in talk.screen.of_robot()].count("model") == count)
        talk.order_to_confirm("cancel the mission", author=author)
        talk.order("yes", author=author)
        talk.end()
        talk.agent.conclude(5.0)
    assert "You could try [hidden] or [hidden]." in talk.screen.texts()
    left = repr((talk.screen.lines, talk.book.data, talk.book.steps, talk.agent._dialogue.history))
    assert "[hidden]" in left and KNOWN not in left and SHAPED not in left


def test_what_others_wrote_for_the_robot_is_spoken_without_secrets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STRANGERS_API_KEY", KNOWN)
    view = StatusView(run="r1", mode="running", mission="tour", identity=f"I am {KNOWN}.", about=f"carry {KNOWN}")
    dialogue = Dialogue(Settings(), view)
    for text in ("who are you?", "what is your mission?"):
        outputs = dialogue.on_utterance(Utterance(text, "operator", "terminal", "Anna", 1.0), view)
        assert any("[hidden]" in each.text for each in outputs if isinstance(each, Speech)), outputs
        assert KNOWN not in repr((outputs, dialogue.history))
