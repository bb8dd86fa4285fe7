# SPDX-License-Identifier: Apache-2.0
"""Conversations as test data: who speaks when, in which role, over which speech; what must be spoken and ordered.

Rule: what a turn expects is all that goes out at it, in this order; what is not expected must not happen.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.conversation.conversation_file import ConversationFile
from rai_missions.conversation.dialogue.dialogue import Dialogue
from rai_missions.conversation.inputs import (
    DocumentQuote,
    FoundQuotes,
    ModelText,
    OrderEnd,
    OrderResult,
    SpeechEnd,
    Utterance,
)
from rai_missions.conversation.outputs import AskModel, DropModel, LookUp, Order, Output, Silence, Speech, TalkNote
from rai_missions.conversation.settings import Settings
from rai_missions.conversation.view import BuildView, KeyView, MissionView, ProgressView, RunEvent, StatusView
from rai_missions.engine.decision import Evidence, Offer, Question
from rai_missions.errors import UsageError, suggestion
from rai_missions.model.validation_errors import validated
from rai_missions.profile.conversation import ConversationPolicy

__all__ = ("PlayedTurn", "check_conversation", "play_conversation")

KINDS = (
    "person",
    "status",
    "model",
    "found",
    "speech_end",
    "order_end",
    "speaker",
    "mission_speech",
    "restart",
    "wait",
)
"""What a turn may be; each has also `at` and `expect`."""


class PlayedTurn(NamedTuple):
    """One turn as it went."""

    turn: Mapping[str, Any]
    outputs: tuple[Output, ...]

    def shown(self) -> list[dict[str, Any]]:
        """What went out, without the journal's notes, each as a turn expects it."""
        return [_shown(each) for each in self.outputs if not isinstance(each, TalkNote)]


def settings_from(data: Mapping[str, Any]) -> Settings:
    """The settings of a conversation's file; who may what, and the places, as in a profile."""
    policy = validated(ConversationPolicy, {name: data[name] for name in ("may", "places") if name in data})
    return Settings(**{**data, "may": policy.granted(), "places": policy.places})


def _keys(data: Mapping[str, Any]) -> Iterator[KeyView]:
    for name, each in data.items():
        age = each.get("age_s", 0.1 if each.get("value") is not None else None)
        yield KeyView(name, **{**each, "age_s": age})


def view_from(data: Mapping[str, Any], before: StatusView = StatusView()) -> StatusView:  # noqa: B008 - a frozen value
    """A view of a conversation's file: what it leaves out stays as it was."""
    fields = dict(data)
    if "keys" in data:
        fields["keys"] = {**before.keys, **{key.name: key for key in _keys(data["keys"])}}
    if "missions" in data:
        fields["missions"] = tuple(
            MissionView(each["name"], each.get("about", ""), tuple(_keys(each.get("arguments", {}))))
            for each in data["missions"]
        )
    if "build" in data:
        fields["build"] = BuildView(**data["build"])
    if "progress" in data:
        fields["progress"] = tuple(ProgressView(**each) for each in data["progress"])
    if "happened" in data:
        fields["happened"] = tuple(RunEvent(**each) for each in data["happened"])
    if "question" in data:
        fields["questions"] = [] if fields.pop("question") is None else [data["question"]]
    if "questions" in fields:
        asked = fields["questions"]
        fields["questions"] = tuple(map(_question, asked))
        fields["confirm"] = frozenset(
            (each.get("number", 1), name) for each in asked for name in each.get("confirm", ())
        )
    for name in ("active", "open_goals", "wanted"):
        if name in data:
            fields[name] = tuple(data[name])
    return before._replace(**fields)


def _question(data: Mapping[str, Any]) -> Question:
    parameters = data.get("parameters", {})
    options = tuple(Offer(name, about, parameters.get(name)) for name, about in data["options"].items())
    evidence = tuple(Evidence(key, value, 0.1, fresh=True) for key, value in data.get("evidence", {}).items())
    return Question(data.get("number", 1), data.get("state", "asking"), "operator", data["text"], options, evidence)


def play_conversation(data: Mapping[str, Any]) -> list[PlayedTurn]:
    """Play a conversation; each speech is spoken whole at once, unless the file has `"speech": "by hand"`.

    Args:
        data: `settings`, `view` and `turns`, as `docs/guide/conversation.md` has them.

    Raises:
        DefinitionError: It has unknown words or values of other types, each with its place.
        UsageError: A turn is of no kind.
    """
    validated(ConversationFile, data)
    return list(_Player(data).play())


class _Player:
    def __init__(self, data: Mapping[str, Any]) -> None:
        self.data = data
        self.view = view_from(data.get("view", {}))
        self.dialogue = Dialogue(settings_from(data.get("settings", {})), self.view)
        self.speeches: dict[str, str] = {}
        """Report, or `last`, → the key of its last speech."""
        self.order = self.request = self.look = 0

    def play(self) -> Iterator[PlayedTurn]:
        for turn in self.data["turns"]:
            outputs = self._turn(turn, float(turn["at"]))
            self._remember(outputs)
            if self.data.get("speech") != "by hand":
                for each in [each for each in outputs if isinstance(each, Speech)]:
                    outputs += self.dialogue.on_speech_end(SpeechEnd(each.key, "whole", float(turn["at"])))
            yield PlayedTurn(turn, outputs)

    def _remember(self, outputs: Sequence[Output]) -> None:
        for each in outputs:
            if isinstance(each, Speech):
                self.speeches[each.report.rpartition(":")[2] if each.report.count(":") == 1 else each.report] = each.key
                self.speeches["last"] = each.key
            elif isinstance(each, Order):
                self.order = each.number
            elif isinstance(each, AskModel):
                self.request = each.number
            elif isinstance(each, LookUp):
                self.look = each.number

    def _turn(self, turn: Mapping[str, Any], at: float) -> tuple[Output, ...]:
        kinds = [kind for kind in KINDS if kind in turn]
        if len(kinds) != 1:
            given = ", ".join(map(repr, turn))
            raise UsageError(f"a turn has one of {', '.join(KINDS)}, this has {given}{suggestion(given, KINDS)}")
        played: tuple[Output, ...] = getattr(self, f"_{kinds[0]}")(turn, at)
        return played

    def _person(self, turn: Mapping[str, Any], at: float) -> tuple[Output, ...]:
        self.view = self.view._replace(at=at)
        channel = turn.get("channel", "terminal")
        readings = tuple(turn.get("readings", [turn["person"]] * 2 if channel == "voice" else []))
        role = turn.get("role", "operator")
        utterance = Utterance(turn["person"], role, channel, turn.get("author", ""), at, readings, turn.get("id", ""))
        return self.dialogue.on_utterance(utterance, self.view)

    def _status(self, turn: Mapping[str, Any], at: float) -> tuple[Output, ...]:
        self.view = view_from(turn["status"], self.view)._replace(at=at, revision=self.view.revision + 1)
        return self.dialogue.on_status(self.view, at)

    def _model(self, turn: Mapping[str, Any], at: float) -> tuple[Output, ...]:
        reply = turn["model"]
        return self.dialogue.on_model(
            ModelText(
                reply.get("number", self.request),
                reply.get("text", ""),
                reply.get("order"),
                reply.get("end", True),
                reply.get("failed", ""),
                at,
            )
        )

    def _found(self, turn: Mapping[str, Any], at: float) -> tuple[Output, ...]:
        quotes = tuple(DocumentQuote(**each) for each in turn["found"])
        return self.dialogue.on_found(FoundQuotes(self.look, quotes, at=at))

    def _speech_end(self, turn: Mapping[str, Any], at: float) -> tuple[Output, ...]:
        key = self.speeches.get(turn["speech_end"], turn["speech_end"])
        return self.dialogue.on_speech_end(SpeechEnd(key, turn.get("result", "whole"), at))

    def _order_end(self, turn: Mapping[str, Any], at: float) -> tuple[Output, ...]:
        return self.dialogue.on_order_end(
            OrderEnd(self.order, OrderResult(turn["order_end"], turn.get("kind", "")), at)
        )

    def _speaker(self, turn: Mapping[str, Any], at: float) -> tuple[Output, ...]:
        return self.dialogue.on_speaker(is_alive=turn["speaker"] == "alive", at=at)

    def _mission_speech(self, turn: Mapping[str, Any], at: float) -> tuple[Output, ...]:
        return self.dialogue.on_mission_speech(turn["mission_speech"], at)

    def _wait(self, _: Mapping[str, Any], at: float) -> tuple[Output, ...]:
        return self.dialogue.on_time(at)

    def _restart(self, _: Mapping[str, Any], at: float) -> tuple[Output, ...]:
        self.dialogue = Dialogue.restore(self.dialogue.snapshot(), self.dialogue.settings, self.view)
        return self.dialogue.on_status(self.view, at)


def _shown(output: Output) -> dict[str, Any]:
    if isinstance(output, Speech):
        return {
            "speech": output.text,
            "way": output.way,
            "priority": output.priority,
            "to": output.to,
            "report": output.report,
            "uncut": output.uncut,
            "repeated": output.repeated,
        }
    if isinstance(output, Order):
        return {"order": output.name, **{name: value for name, value in output._asdict().items() if name != "name"}}
    if isinstance(output, AskModel):
        return {"asks_model": output.text}
    if isinstance(output, LookUp):
        return {"looks_up": output.text}
    if isinstance(output, DropModel):
        return {"drops_model": output.number}
    return {"silence": "total" if isinstance(output, Silence) and output.is_total else "polite"}


def _fits(expected: Mapping[str, Any], shown: Mapping[str, Any]) -> bool:
    """A speech fits by a part of its text, everything else by its value."""
    return all(
        name in shown and (value in shown[name] if name in ("speech", "asks_model") else value == shown[name])
        for name, value in expected.items()
    )


def check_conversation(data: Mapping[str, Any]) -> None:
    """Play a conversation, and hold each turn to what it expects.

    Args:
        data: As for `play_conversation`; a turn without `expect` is held to nothing.

    Raises:
        AssertionError: Something else went out, or nothing: the turn, what was expected, and what went out.
    """
    for played in play_conversation(data):
        if "expect" not in played.turn:
            continue
        expected, shown = played.turn["expect"], played.shown()
        pairs = zip(expected, shown, strict=False)
        if len(expected) != len(shown) or not all(_fits(each, other) for each, other in pairs):
            lines = "\n".join(f"    {each}" for each in shown) or "    nothing"
            wanted = "\n".join(f"    {each}" for each in expected) or "    nothing"
            turn = {name: value for name, value in played.turn.items() if name != "expect"}
            raise AssertionError(
                f"'{data.get('name', '')}', at {turn}: expected\n{wanted}\n  and this went out:\n{lines}"
            )
