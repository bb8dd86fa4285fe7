# SPDX-License-Identifier: Apache-2.0
"""Providers that limit their rate, and models that open late: neither is taken for an answer of the model."""

from __future__ import annotations

import threading
from datetime import UTC, datetime, timedelta
from email.utils import format_datetime
from types import SimpleNamespace
from typing import Any

import pytest

from rai_missions.answerers.model.chat import Abilities, Absent, Chat, Conversation, ModelFault, ThreadChat
from rai_missions.answerers.model.pending import PendingQuestion
from rai_missions.answerers.model.providers import open_model
from rai_missions.answerers.test_models import ScriptedModel
from rai_missions.campaign.asking import LONGEST_PAUSE_S, CellAsker
from rai_missions.campaign.embodiments import RobotView
from rai_missions.campaign.load import LoadedCampaign
from rai_missions.campaign.models import CampaignModels
from rai_missions.campaign.questions import AskedScene
from rai_missions.campaign.records import CellRecord
from rai_missions.campaign.watched_chat import WatchedChat
from rai_missions.testing import QUESTION
from tests.campaign.test_models import CELL, LABELS, asked, loaded, reply
from tests.rigs.chat_server import Server, completion, refused, server

__all__ = ("asked", "loaded", "server")
pytestmark = pytest.mark.sim


NO_DATES = (
    "Mon, 1 Jan 2024 00:00:00 +99999999999999999999", "Mon, 1 Jan 99999999999999999999 00:00:00 GMT",
    "Mon, 1 Jan 2024 00:00:00 +9999", "9" * 5000,
)  # fmt: skip


class PatientEvent(threading.Event):
    """An event that never comes, and for which no one really waits: it notes how long it was to be."""

    def __init__(self) -> None:
        super().__init__()
        self.waits: list[float | None] = []

    def wait(self, timeout: float | None = None) -> bool:
        self.waits.append(timeout)
        return False


def answered(loaded: LoadedCampaign, asked: AskedScene, chat: Chat) -> tuple[CellRecord, list[float | None]]:
    """The record of a cell, asked three times at the most, and the pauses before it was asked again."""
    file, never = loaded.file.model_copy(update={"retries": 2}), PatientEvent()
    with CampaignModels(file, loaded.subject.robot, {}, open_chat=lambda name: chat) as models:
        record = CellAsker(file, models, {}, {"none": RobotView()}, never).ask("key", CELL, asked, LABELS)
    assert record is not None
    return record, never.waits


def test_a_provider_that_limits_its_rate_is_asked_again_when_it_wants_to_be(
    loaded: LoadedCampaign, asked: AskedScene, server: Server
) -> None:
    server.replies = [
        refused(429, "slow down", retry_after="17"),
        refused(429, "slow down"),
        completion('{"option": "left", "why": "it is free"}'),
    ]
    record, waits = answered(loaded, asked, ThreadChat(server.model()))
    assert (record.status, record.option, record.calls) == ("answered", "left", 3)
    assert waits == [17.0, 2.0]


def test_a_provider_that_limits_its_rate_for_good_has_failed(
    loaded: LoadedCampaign, asked: AskedScene, server: Server
) -> None:
    server.replies = [refused(429, "no more", retry_after="3")] * 3
    record, waits = answered(loaded, asked, ThreadChat(server.model()))
    assert (record.status, record.calls, waits) == ("failed", 3, [3.0, 3.0]) and "429" in record.error
    server.replies = [refused(429, "come tomorrow", retry_after=str(LONGEST_PAUSE_S + 1))]
    record, waits = answered(loaded, asked, ThreadChat(server.model()))
    assert (record.status, record.calls, waits) == ("failed", 1, [])


class SpentEvent(PatientEvent):
    """An event that comes while it is waited for: the budget is spent during a pause."""

    def wait(self, timeout: float | None = None) -> bool:
        super().wait(timeout)
        return True


def test_what_was_used_before_a_pause_counts_where_the_budget_is_spent_in_it(
    loaded: LoadedCampaign, asked: AskedScene, server: Server
) -> None:
    server.replies = [refused(429, "slow down", retry_after="17")]
    file, over = loaded.file.model_copy(update={"retries": 2}), SpentEvent()
    with CampaignModels(file, loaded.subject.robot, {}, open_chat=lambda name: ThreadChat(server.model())) as models:
        record = CellAsker(file, models, {}, {"none": RobotView()}, over).ask("key", CELL, asked, LABELS)
    assert record is not None and over.waits == [17.0]
    assert (record.status, record.calls) == ("failed", 1) and "429" in record.error


@pytest.mark.parametrize(
    ("header", "seconds"),
    [
        ("7", 7.0),
        ("0.5", 0.5),
        ("0", 0.0),
        ("-3", 0.0),
        ("nan", 0.0),
        ("inf", 0.0),
        ("soon", 0.0),
        *((each, 0.0) for each in NO_DATES),
    ],
)
def test_a_retry_after_is_read_in_seconds(header: str, seconds: float) -> None:
    assert ModelFault.by(limited(header)).after_s == seconds


def test_a_retry_after_is_read_as_a_date() -> None:
    coming, past = (format_datetime(datetime.now(UTC) + timedelta(hours=each), usegmt=True) for each in (1, -1))
    assert 3500 < ModelFault.by(limited(coming)).after_s <= 3600
    assert ModelFault.by(limited(past)).after_s == 0.0
    assert ModelFault.by(ConnectionError("no response at all")).after_s == 0.0


def limited(header: str) -> Exception:
    error: Any = RuntimeError("429")
    error.response = SimpleNamespace(headers={"retry-after": header})
    return error


def test_a_campaign_counts_the_calls_that_a_provider_s_package_would_repeat(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("langchain_openai", reason="the extra `openai`")
    monkeypatch.setenv("OPENAI_API_KEY", "sk-loopback-0123456789")
    models: list[Any] = [open_model("openai:gpt-4o", isolated=isolated) for isolated in (False, True)]
    assert [model.max_retries for model in models] == [None, 0]


# -- models that open late, or never ---------------------------------------------------------------------------------


class LateChat(ThreadChat):
    """Notes how much time there is for its opening, then for its answer."""

    def __init__(self, model: ScriptedModel) -> None:
        super().__init__(model)
        self.left_s: list[float] = []

    def abilities(self, pending: PendingQuestion) -> Abilities:
        self.left_s.append(pending.left_s)
        return super().abilities(pending)


def test_the_time_in_which_a_model_opens_is_no_part_of_its_answer_s(loaded: LoadedCampaign, asked: AskedScene) -> None:
    chat = LateChat(ScriptedModel([reply("left")]))
    record, _ = answered(loaded, asked, chat)
    *opening, thinking = chat.left_s
    assert record.status == "answered" and opening
    assert all(each == float("inf") for each in opening) and thinking <= asked.question.until - asked.question.at + 1


class ClosedChat:
    """A model that cannot be asked: its process opens for ever, or it is absent."""

    name = "closed"

    def __init__(self, absent: str = "") -> None:
        self._absent, self.openings = absent, 0

    def open(self) -> None: ...

    def close(self) -> None: ...

    def abilities(self, pending: PendingQuestion) -> Abilities:
        self.openings += 1
        if self._absent:
            raise Absent(self._absent)
        from rai_missions.answerers.model.chat import BudgetExceeded

        closed = threading.Event()
        pending.when_closed(closed.set)
        closed.wait()
        raise BudgetExceeded("closed")

    def converse(self, mode: Any, form: Any, pending: PendingQuestion) -> Conversation:
        raise AssertionError("it is never open")


def test_a_model_that_is_never_opened_is_waited_for_once() -> None:
    chat = ClosedChat()
    watched = WatchedChat(chat, opens_s=0.01)
    assert [watched.wait_until_open(QUESTION) for _ in range(3)] == ["the model was not opened within 0.01 s"] * 3
    assert (watched.raised, chat.openings) == ("Absent", 1)


def test_a_model_that_is_absent_has_failed_and_is_not_asked_again(loaded: LoadedCampaign, asked: AskedScene) -> None:
    record, waits = answered(loaded, asked, ClosedChat("no such package"))
    assert (record.status, record.error, waits) == ("failed", "no such package", [])
