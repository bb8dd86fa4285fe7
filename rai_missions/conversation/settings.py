# SPDX-License-Identifier: Apache-2.0
"""What a robot's profile sets of a dialogue: who may order what, and what becomes of requests and late sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.event import Role
from rai_missions.profile.conversation import (
    ConversationPolicy,
    NamedPlace,
    OrderName,
    WhileAnswering,
    WhileRunning,
)

__all__ = ("Settings",)


class Settings(NamedTuple):
    """How a dialogue behaves."""

    language: str = "en"
    """The file of `languages/` with its grammar and templates."""
    may: Mapping[Role, frozenset[OrderName]] = ConversationPolicy().granted()
    """What each role may order; each may ask."""
    requests: WhileRunning = "queue"
    most_requests: int = 3
    late: WhileAnswering = "queue"
    """What becomes of a sentence for the model while that answers another; rules answer theirs at once."""
    most_late: int = 5
    """Sentences that wait for the model at most, where the policy is `queue`."""
    has_model: bool = False
    """Whether a model can be asked; else what the rules do not know is answered by "I do not know"."""
    model_s: float = 20.0
    """Seconds that a model has for its reply."""
    has_documents: bool = False
    """Whether the robot's documents can be asked what no rule answers."""
    look_up_s: float = 20.0
    """Seconds that a look into the documents may take."""
    confirm_s: float = 20.0
    """Seconds after which what was read back is void."""
    speech_s: float = 60.0
    """Seconds after which a speech without an end counts as failed."""
    history: int = 40
    """Turns that are kept."""
    answer_at: tuple[str, ...] = ("terminal", "page")
    """The channels at which an operator is met; a refusal names them."""
    results: tuple[str, ...] = ()
    """The keys whose values are spoken with the end of a mission, where they have one."""
    asked_with: tuple[str, ...] = ()
    """The evidence, keys or fields of one, whose text is spoken with a question."""
    places: Mapping[str, NamedPlace] = {}
    """The name of a place → where it is."""
    questions: Mapping[str, str] = {}
    """Questions of this robot → the key, or the field of one, whose value answers them."""
    phrases: Mapping[str, Mapping[str, Any]] = {}
    """Sentences of this robot that start a mission with arguments."""
    spoken: Mapping[str, Mapping[str, Any]] = {}
    """What starts with arguments are called, the first that fits."""
    names: Mapping[str, Mapping[str, Any]] = {}
    """Of phrases: argument → the words for each of its values, where it has no other values."""
