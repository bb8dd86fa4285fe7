# SPDX-License-Identifier: Apache-2.0
"""A model's key, planted wherever a model or its provider may state it, is in nothing that a run leaves behind."""

from __future__ import annotations

import io
import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pydantic import SecretStr

from rai_missions.agents import run
from rai_missions.answerers.test_models import DoubleModel
from rai_missions.cli.progress import Lines
from rai_missions.mission.mission import Mission
from tests.recording.kept import kept
from tests.rigs.journals import steps_of
from visualize import draw, draw_review

BY_TYPE = "canary-held-by-the-model-73d1"
"""Looks like no key: it is known by its type, `SecretStr`, alone."""
BY_NAME = "canary-in-a-variable-91ac"
"""Looks like no key: it is known by the name of its variable alone."""
BY_SHAPE = "sk-proj-Qk3mQ9vT7wXyB2nC5dF8hJ1lP4rS6uA0"
CANARIES = (BY_TYPE, BY_NAME, BY_SHAPE)
LEAK = " ".join(CANARIES)


class Holding(DoubleModel):
    """A chat model with a key of its own."""

    key: SecretStr = SecretStr(BY_TYPE)
    script: list[Any]

    def reply_to(self, messages: list[Any]) -> Any:
        reported = self.script.pop(0) if self.script else "no more"
        if isinstance(reported, Exception):
            raise reported
        return reported


ASKING = Mission.model_validate(
    {
        "name": "asking",
        "initial": "ask",
        "states": {
            "ask": {
                "decision": {
                    "question": "What now?", "options": {"stay": {}, "leave": {}}, "ask": ["agent"], "attempts": 6,
                    "deadline_s": 30, "fallback": "leave",
                },
                "transitions": [{"on": "stay", "to": "left"}, {"on": "leave", "to": "left"}],
            },
            "left": {"final": "aborted"},
        },
    }
)  # fmt: skip
REPLIES: dict[str, list[Any]] = {
    "a refusal of its provider": [RuntimeError(f"401: invalid api key {LEAK}")],
    "an answer that is none": [f"my key is {LEAK}"],
    "an option by that name": [f'{{"option": "{LEAK}"}}'],
    "a reason": [f'{{"option": "stay", "why": "{LEAK}"}}', f'{{"option": "stay", "reason": "{LEAK}"}}'],
    "parameters": [f'{{"option": "stay", "parameters": {{"{BY_SHAPE}": "{LEAK}"}}}}'],
}


def texts(path: Path) -> Iterator[bytes]:
    """What a file holds, unpacked where it is packed."""
    yield path.read_bytes()
    if path.suffix == ".mcap":
        found = kept(path)
        yield repr((found.messages, found.metadata, found.schemas)).encode()
        yield from found.attachments.values()


@pytest.mark.parametrize("reported", REPLIES.values(), ids=REPLIES)
def test_no_key_is_in_anything_that_a_run_leaves_behind(
    reported: list[Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("STRANGERS_API_KEY", BY_NAME)
    caplog.set_level(logging.DEBUG)
    shown = io.StringIO()
    lines = Lines(ASKING, shown, verbose=True)
    journal, recording = tmp_path / "run.journal", tmp_path / "run.mcap"
    model = Holding(script=reported * 6)
    result = run(ASKING, model=model, journal=journal, record=recording, on_step=lines.step, on_status=lines.status)
    lines.close()
    steps = steps_of(journal)
    assert len(model.script) < len(reported * 6), "the model was asked"
    draw_review(ASKING, tmp_path / "page.html", [journal])
    for form in ("dot", "mmd", "md"):
        draw(ASKING, tmp_path / f"picture.{form}", steps=steps)
    left = {path.name: b"".join(texts(path)) for path in tmp_path.iterdir() if path.is_file()}
    left |= {"log": caplog.text.encode(), "terminal": shown.getvalue().encode(), "result": repr(result).encode()}
    left |= {"steps": repr(steps).encode()}
    assert {"run.journal", "run.mcap", "page.html"} <= left.keys()
    leaks = [(name, canary) for name, data in left.items() for canary in CANARIES if canary.encode() in data]
    assert leaks == []
