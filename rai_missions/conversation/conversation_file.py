# SPDX-License-Identifier: Apache-2.0
"""What a conversation as data may hold: its settings, the view that it begins in, and its turns.

The words of settings and views are those of the records that they become, so they are listed there alone.
"""

from __future__ import annotations

from types import GenericAlias
from typing import Any, Literal, get_type_hints

from pydantic import BaseModel, ConfigDict, create_model

from rai_missions.conversation.inputs import DocumentQuote, RefusalKind, SpeechResult
from rai_missions.conversation.outputs import Order
from rai_missions.conversation.settings import Settings
from rai_missions.conversation.view import BuildView, KeyView, MissionView, ProgressView, RunEvent, StatusView
from rai_missions.engine.modes import Mode
from rai_missions.event import Role
from rai_missions.profile.conversation import NamedPlace

__all__ = ("ConversationFile",)


class _FilePart(BaseModel):
    """Words that are not listed are refused."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


def _model(name: str, /, **fields: Any) -> Any:
    """A model of fields, each a type and its default; `...` for one that must be there."""
    return create_model(f"{name}File", __base__=_FilePart, **fields)


def _parts(name: str, record: Any, /, **others: Any) -> Any:
    """A model of a record's fields; a field without a default must be there.

    Args:
        name: What the part is called in errors.
        record: The class of the record, a named tuple.
        others: Words whose type in a file is another than in the record; None: a file does not state it.
    """
    defaults = record._field_defaults
    fields = {each: (kind, defaults.get(each, ...)) for each, kind in get_type_hints(record).items()}
    fields |= {each: (kind, None) for each, kind in others.items()}
    return _model(name, **{each: field for each, field in fields.items() if field[0] is not None})


def _named(kind: Any) -> Any:
    """An object whose values are all of a kind."""
    return GenericAlias(dict, (str, kind))


def _listed(kind: Any) -> Any:
    """A list whose items are all of a kind."""
    return GenericAlias(tuple, (kind, ...))


OBJECT: Any = dict[str, Any]
KEYS = _named(_parts("Key", KeyView, name=None))
QUESTION = _model(
    "Question",
    text=(str, ...),
    options=(_named(str), ...),
    number=(int, 1),
    state=(str, ""),
    confirm=(_listed(str), ()),
    parameters=(_named(OBJECT), None),
    evidence=(OBJECT, None),
)
VIEW = _parts(
    "View",
    StatusView,
    mode=Mode | Literal[""],
    keys=KEYS,
    build=_parts("Build", BuildView) | None,
    question=QUESTION | None,
    questions=_listed(QUESTION),
    missions=_listed(_parts("Mission", MissionView, arguments=KEYS)),
    progress=_listed(_parts("Progress", ProgressView)),
    happened=_listed(_parts("Event", RunEvent)),
)
SETTINGS = _parts(
    "Profile",
    Settings,
    may=_named(_listed(str)),
    places=_named(NamedPlace),
    phrases=_named(OBJECT),
    spoken=_named(OBJECT),
)
REPLY = _model(
    "Reply",
    text=(str, ""),
    order=(OBJECT | None, None),
    number=(int, 0),
    end=(bool, True),
    failed=(str, ""),
)
OF_SPEECH = ("speech", "way", "priority", "to", "report", "uncut", "repeated")
OTHERS = ("order", "asks_model", "looks_up", "drops_model", "silence")
EXPECTED = _model("Output", **dict.fromkeys((*OF_SPEECH, *OTHERS, *Order._fields), (Any, None)))
TURN = _model(
    "Turn",
    at=(float, ...),
    expect=(_listed(EXPECTED), ()),
    person=(str, ""),
    role=(Role, ""),
    channel=(str, ""),
    author=(str, ""),
    id=(str, ""),
    readings=(_listed(str), ()),
    status=(VIEW, None),
    model=(REPLY, None),
    found=(_listed(_parts("Quote", DocumentQuote)), None),
    speech_end=(str, ""),
    result=(SpeechResult, ""),
    order_end=(str, ""),
    kind=(RefusalKind, ""),
    speaker=(Literal["alive", "dead"], ""),
    mission_speech=(str, ""),
    restart=(Any, None),
    wait=(Any, None),
)
ConversationFile = _model(
    "Conversation",
    name=(str, ""),
    settings=(SETTINGS, None),
    view=(VIEW, None),
    speech=(Literal["by hand"], ""),
    turns=(_listed(TURN), ...),
)
"""A whole conversation, for `validated`."""
