# SPDX-License-Identifier: Apache-2.0
"""No piece of a secret is left where a text is cut, whatever its length, its lines and the place where it enters.

Rule: a piece is what could be used to guess on: eight characters of the secret in a row.
"""

from __future__ import annotations

import io
import json
import logging
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from langchain_core.messages import AIMessage
from pydantic import PrivateAttr, SecretStr

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.answerers.test_models import DoubleModel, call
from rai_missions.cli.progress import Lines
from rai_missions.connectors.connector import Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import ConnectorError
from rai_missions.journal import read
from rai_missions.mission.mission import Mission
from rai_missions.node.order import read_order
from rai_missions.profile import Robot
from rai_missions.redaction import clipped, cut, cut_repr, first_line, redacted, shown
from tests.security.test_leaks import STRING, TRIGGER, files, log_of

PIECE = 8
LETTERS = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
ODD = "\n\n\n \"'\\/+=<&é"


def secret_of(seed: int, length: int, odd: float) -> str:
    """A secret of no known shape.

    Args:
        seed: It follows from it.
        length: Characters.
        odd: How often, 0 to 1, a character is one that is written otherwise in JSON, Python or an address.
    """
    random = Random(seed)
    middle = (random.choice(ODD if random.random() < odd else LETTERS) for _ in range(length - 2))
    return f"{random.choice(LETTERS)}{''.join(middle)}{random.choice(LETTERS)}"


SECRETS = st.builds(
    secret_of,
    st.integers(0, 2**32),
    st.one_of(st.integers(8, 200), st.sampled_from([119, 299, 301, 999, 2_001, 4_001, 5_000])),
    st.sampled_from([0.0, 0.0, 0.02, 0.1]),
)


def pieces(secret: str) -> set[str]:
    """Pieces from all over a secret; those alone that every notation writes alike."""
    starts = {*range(0, len(secret) - PIECE + 1, max(1, len(secret) // 60)), len(secret) - PIECE}
    found = {secret[start : start + PIECE] for start in starts}
    return {piece for piece in found if set(piece) <= set(LETTERS)}


def assert_whole(left: Mapping[str, bytes | str], *secrets: str) -> None:
    """No piece of any secret is in what is left."""
    wanted = {piece.encode() for secret in secrets for piece in pieces(secret)}
    found = {}
    for name, reported in left.items():
        data = reported.encode("utf-8", "replace") if isinstance(reported, str) else reported
        at = next((at for piece in wanted if (at := data.find(piece)) >= 0), -1)
        if at >= 0:
            found[name] = data[max(0, at - 80) : at + 80]
    assert found == {}


# -- a run that takes words from everywhere ----------------------------------------------------------------------------

ASKED = {
    "options": {"stay": {"parameters": {"type": "object", "properties": {"n": {"type": "integer"}}}}, "leave": {}},
    "ask": ["agent", "someone"], "attempts": 12, "deadline_s": 60, "fallback": "leave",
    "tools": ["receive_message"], "budget": {"calls": 9},
}  # fmt: skip
MISSION = Mission.model_validate(
    {
        "name": "pieces", "initial": "ask", "events": ["signal"],
        "blackboard": {
            "text": {"type": "string", "source": "robot", "optional": True},
            "number": {"type": "number", "source": "robot", "optional": True},
            "pose": {"type": "pose", "source": "robot", "optional": True},
            "data": {"type": "object", "source": "robot", "optional": True},
        },
        "states": {
            "ask": {
                "decision": {"question": "What now?", "evidence": ["text", "data"], **ASKED},
                "transitions": [{"on": ["stay", "leave"], "to": "post"}],
            },
            "post": {"call": "post", "timeout_s": 5, "transitions": [{"on": ["succeeded", "failed"], "to": "break"}]},
            "break": {"call": "break", "timeout_s": 5, "transitions": [{"on": ["succeeded", "failed"], "to": "go"}]},
            "go": {
                "action": "go", "timeout_s": 5, "entry": [{"publish": "news"}],
                "transitions": [{"on": ["succeeded", "failed"], "to": "over"}],
            },
            "over": {"final": "aborted"},
        },
    }
)  # fmt: skip
ROBOT = Robot.model_validate(
    {
        "name": "loose",
        "connector": {"kind": "local"},
        "tools": {"read": ["/*"]},
        "blackboard": {
            "text": {"topic": "/text", "type": STRING, "field": "data"},
            "number": {"topic": "/text", "type": STRING, "json": True, "field": "a"},
            "pose": {"topic": "/text", "type": STRING, "json": True},
            "data": {"topic": "/text", "type": STRING, "json": True},
        },
        "events": {"signal": {"topic": "/signal", "type": STRING}},
        "services": {name: {"service": f"/{name}", "type": TRIGGER} for name in ("post", "break")},
        "topics": {"news": {"topic": "/broken", "type": STRING}},
        "actions": {"go": {"action": "/go", "type": "nav2_msgs/action/Spin"}},
    }
)


class Loose(DoubleModel):
    """Reports its key in every way in which a model can state something, a way a time."""

    key: SecretStr
    theirs: str
    _deeds: list[Any] = PrivateAttr(default_factory=list)

    def reply_to(self, messages: list[Any]) -> Any:
        if not self._deeds:
            self._deeds.extend(deeds(f"{self.key.get_secret_value()}", self.theirs))
        reported = self._deeds.pop(0) if len(self._deeds) > 1 else self._deeds[0]
        if isinstance(reported, BaseException):
            raise reported
        return reported


def deeds(own: str, theirs: str) -> Iterator[Any]:
    for key in (own, theirs):
        yield RuntimeError(f"{key}\nis no key")
        yield RuntimeError(f"401: {key}")
        yield ValueError({"key": [key]})
        yield key
        yield f"x {{ {key}"
        yield json.dumps({"option": key, "why": key})
        yield json.dumps({"option": [key]})
        yield json.dumps({"option": "stay", "parameters": [key], "why": key})
        yield json.dumps({"option": "stay", "parameters": {key: key, "n": key}, "why": key})
        yield json.dumps({"option": "stay", key: key})
        yield AIMessage(f"{key}", tool_calls=[call(key, key, words=key)], response_metadata={"model_name": key})
        yield AIMessage("", tool_calls=[call("receive_message", topic=key, **{key: key})])
        yield AIMessage("", response_metadata={"model_name": key})
    yield '{"option": "stay", "parameters": {}}'


class Broken:
    """Someone else who is asked, and fails with words that name a key."""

    def __init__(self, secret: str) -> None:
        self.answers = iter([secret, {"failed": secret}, {"option": secret}, {secret: secret}, {"absent": secret}])

    def ask(self, question: Any, answer: Any) -> None:
        reported = next(self.answers, None)
        if reported is None:
            raise RuntimeError("nothing more")
        answer(reported)

    def withdraw(self, number: int) -> None:
        """Nothing is under way."""


class Loud(LocalConnector):
    """A robot whose servers name a key wherever they can."""

    def __init__(self, secret: str) -> None:
        super().__init__()
        self.secret = secret
        self.start()
        self.serve("/post", TRIGGER, lambda _: {"success": False, "message": secret})
        self.serve("/break", TRIGGER, self._breaks)
        self.offer("/go", "nav2_msgs/action/Spin", self)

    def _breaks(self, _: Any) -> Any:
        raise RuntimeError(f"{self.secret}\nis what it printed")

    def publish(self, topic: str, type_name: str, message: Mapping[str, Any]) -> None:
        if topic == "/broken":
            raise ConnectorError(f"no way to {self.secret}")
        super().publish(topic, type_name, message)

    def accept(self, goal_id: str, goal: Any, report: Any) -> None:
        for status in (self.secret, f'{{"a": {self.secret}', json.dumps({"a": self.secret}), json.dumps([self.secret])):
            self.publish("/text", STRING, {"data": status})
        self.publish("/signal", STRING, {"data": self.secret})
        report(Report(goal_id, "accepted", {}))
        report(Report(goal_id, "failed", {"words": [self.secret, {self.secret: 1}]}, self.secret))

    def cancel(self, goal_id: str) -> None:
        """It has ended."""


def leaves(own: str, theirs: str, folder: Path) -> dict[str, bytes | str]:
    """Everything that a run leaves behind and shows."""
    shown = io.StringIO()
    lines = Lines(MISSION, shown, verbose=True)
    setting = RunConfig(
        MISSION,
        ROBOT,
        model=Loose(key=SecretStr(own), theirs=theirs),
        connector=Loud(theirs),
        answerers={"someone": Broken(theirs)},
        journal=folder / "run.journal",
        on_step=lines.step,
        on_status=lines.status,
    )
    with prepare(setting) as prepared:
        result = prepared.runner.run()
        lines.end(result)
    assert result.outcome == "aborted"
    with read(folder / "run.journal") as record:
        steps = tuple(record.steps())
    assert sum(step.event.kind == "proposal" for step in steps) > 12
    orders = [{"command": theirs}, {"id": theirs, "command": 1}, {"by": [theirs]}, {"command": "pause", theirs: 1}]
    answers = [read_order(json.dumps(order)) for order in orders] + [read_order(theirs), read_order(f'"{theirs}"')]
    return files(folder) | {"terminal": shown.getvalue(), "result": repr(result), "orders": repr(answers)}


def check(own: str, theirs: str, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    caplog.clear()
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as folder:
        patch.setenv("STRANGERS_API_KEY", theirs)
        left = leaves(own, theirs, Path(folder))
    assert_whole(left | {"log": log_of(caplog)}, own, theirs)


LAW = settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@settings(LAW, max_examples=3)
@example(secret_of(1, 119, 0.0), secret_of(2, 119, 0.0))
@example(secret_of(3, 300, 0.1), secret_of(4, 5_000, 0.1))
@given(SECRETS, SECRETS)
def test_no_piece_of_a_secret_is_in_what_a_run_leaves(caplog: pytest.LogCaptureFixture, own: str, theirs: str) -> None:
    check(own, theirs, caplog)


@pytest.mark.drill
@pytest.mark.timeout(1800)
@settings(LAW, max_examples=150)
@given(SECRETS, SECRETS)
def test_no_piece_of_a_secret_is_in_what_many_runs_leave(
    caplog: pytest.LogCaptureFixture, own: str, theirs: str
) -> None:
    check(own, theirs, caplog)


# -- the door ------------------------------------------------------------------------------------------------------

FRAMES = st.sampled_from(["{}", "key {}.", '"{}"', "{{{}}}", "https://x/?key={}&a=1", "{}, {}", "\n{}\nmore", "'\"{}"])


@given(SECRETS, FRAMES, st.integers(0, 200), st.integers(0, 6_000), st.sampled_from([cut, cut_repr, first_line, shown]))
def test_no_piece_is_left_wherever_a_text_is_cut(
    secret: str, frame: str, before: int, length: int, by: Callable[[Any, int], str]
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STRANGERS_API_KEY", secret)
        text = "word " * before + frame.replace("{}", secret)
        reported = [by(what, max(2, length)) for what in (text, {"a": text}, [json.dumps(text)], RuntimeError(text))]
    assert_whole({str(number): each for number, each in enumerate(reported)}, secret)
    assert all(len(each) <= max(2, length) for each in reported if by in (cut, cut_repr, first_line))


@given(st.text(max_size=300), st.integers(1, 400))
def test_what_holds_no_secret_is_cut_and_nothing_else(text: str, length: int) -> None:
    text = text.encode("utf-8", "replace").decode()
    assert cut(text, length) == redacted(text)[:length]
    assert clipped(text, length) == text[:length]


def test_a_long_text_is_cut_without_being_looked_through() -> None:
    began = time.process_time()
    assert cut("word " * 10_000_000, 60) == ("word " * 12)
    assert time.process_time() - began < 0.5


def test_of_a_secret_with_several_lines_each_line_is_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(
        "ROBOT_PRIVATE_KEY", "-----BEGIN KEY-----\nMIIEvQIBADANBgkq\nhkiG9w0BAQEFAASC\n-----END KEY-----"
    )
    assert first_line(ValueError("MIIEvQIBADANBgkq\nis line 2")) == "[hidden]"
    assert cut("at hkiG9w0BAQEFAASC", 100) == "at [hidden]"
