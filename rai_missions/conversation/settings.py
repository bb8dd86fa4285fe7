# SPDX-License-Identifier: Apache-2.0
"""What a robot's profile sets of a dialogue: who may order what, and what becomes of requests and late sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple, get_args

from rai_missions.conversation.places import PlaceArea
from rai_missions.conversation.spoken_starts import SpokenStart
from rai_missions.conversation.start_phrases import StartPhrase
from rai_missions.errors import UsageError, suggestion
from rai_missions.event import Role
from rai_missions.profile.conversation import GRANTED, ORDERS, OrderName

__all__ = ("MAY", "ORDERS", "LatePolicy", "RequestPolicy", "Settings", "permissions")

ROLES: tuple[Role, ...] = get_args(Role)
RequestPolicy = Literal["queue", "refuse"]
"""What becomes of a start that is ordered while a mission runs."""
LatePolicy = Literal["queue", "keep_last", "interrupt"]
"""What becomes of a sentence for the model while the model answers another; rules answer theirs at once."""

MAY: Mapping[Role, frozenset[OrderName]] = {role: frozenset(GRANTED[role]) for role in ROLES}
"""What each role may order where the profile grants nothing more; each may ask."""


class Settings(NamedTuple):
    """How a dialogue behaves."""

    language: str = "en"
    """The file of `languages/` with its grammar and templates."""
    may: Mapping[Role, frozenset[OrderName]] = MAY
    requests: RequestPolicy = "queue"
    most_requests: int = 3
    late: LatePolicy = "queue"
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
    places: Mapping[str, PlaceArea] = {}
    """The name of a place → where it is."""
    questions: Mapping[str, str] = {}
    """Questions of this robot → the key, or the field of one, whose value answers them."""
    phrases: tuple[StartPhrase, ...] = ()
    """Sentences of this robot that start a mission with arguments."""
    spoken: tuple[SpokenStart, ...] = ()
    """What starts with arguments are called, the first that fits."""
    names: Mapping[str, Mapping[str, Any]] = {}
    """Of phrases: argument → the words for each of its values, where it has no other values."""


def permissions(granted: Mapping[str, object]) -> Mapping[Role, frozenset[OrderName]]:
    """The table of a profile's `"may"`: what is granted there is added to what each role has.

    Args:
        granted: Role → the names of orders.

    Raises:
        UsageError: A role or an order that does not exist.
    """
    table = dict(MAY)
    for role, names in granted.items():
        if role not in ROLES:
            raise UsageError(f"'may' names no role: '{role}'{suggestion(role, ROLES)}")
        if not isinstance(names, list | tuple | set | frozenset):
            raise UsageError(f"'may' of '{role}' is no list: {names!r}; give a list of: {', '.join(ORDERS)}")
        for name in names:
            if name not in ORDERS:
                raise UsageError(f"'may' of '{role}' names no order: '{name}'{suggestion(str(name), ORDERS)}")
        table[role] = table[role] | frozenset(names)
    return table
