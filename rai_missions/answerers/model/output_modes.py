# SPDX-License-Identifier: Apache-2.0
"""What a chat model can do, found out without asking it: structured output, calls of tools, pictures.

Rule: a model's class and profile are believed until a call shows otherwise; then the next mode is tried. A
provider's package is given schemas of its own, for it may cut out of them what its server does not know; never a tool.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

from langchain_core.language_models import BaseChatModel
from langchain_core.runnables import Runnable, RunnableSequence
from langchain_core.tools import BaseTool
from langchain_core.utils.function_calling import convert_to_openai_tool

from rai_missions.answerers.model.parse_reply import callable_name
from rai_missions.engine.decision import Offer, Question
from rai_missions.plain_data import apart

__all__ = (
    "AnswerForm",
    "Bound",
    "OutputMode",
    "bound",
    "calls_tools",
    "fills_schemas",
    "form_of",
    "modes_of",
    "takes_images",
    "tool_specifications",
    "wish_schema",
)  # fmt: skip

Bound = Runnable[Any, Any]
"""Takes messages, gives a message."""
OutputMode = Literal["json_schema", "tools", "text"]
WHY = {"type": "string", "maxLength": 120, "description": "The reason, in a few words."}
NO_PARAMETERS = {"type": "object", "properties": {}, "additionalProperties": False}


class AnswerForm(NamedTuple):
    """What an answer may be, as data."""

    schema: Mapping[str, Any]
    """The JSON Schema of a choice of one of the options."""
    tools: Sequence[Mapping[str, Any]] = ()
    """The read-only tools and the options, as functions that every provider's package understands."""


def form_of(question: Question, tools: Mapping[str, BaseTool]) -> AnswerForm:
    """What may be answered to a question.

    Args:
        question: What is asked.
        tools: The read-only tools that may be called before the answer.
    """
    looks = map(convert_to_openai_tool, tools.values())
    return AnswerForm(wish_schema(question.options), [*looks, *tool_specifications(question.options)])


def modes_of(*, schemas: bool, tools: bool, wanted: str, uses_tools: bool) -> tuple[OutputMode, ...]:
    """The ways in which a model can be asked for one option, best first.

    Args:
        schemas: Its output can be held to a JSON Schema.
        tools: It can be bound to tools.
        wanted: `auto`, or the one mode to use.
        uses_tools: Read-only tools may be used while it thinks; they need calls of tools.
    """
    if wanted != "auto":
        return (wanted,)  # type: ignore[return-value]  # checked where the agent is made
    able: list[OutputMode] = ["json_schema"] if schemas else []
    if tools:
        able.insert(0 if uses_tools else len(able), "tools")
    return (*able, "text")


def calls_tools(model: BaseChatModel) -> bool:
    """Whether tools can be bound to a model, by its profile, else by its class."""
    known = _profile(model).get("tool_calling")
    return bool(known) if known is not None else type(model).bind_tools is not BaseChatModel.bind_tools


def fills_schemas(model: BaseChatModel) -> bool:
    """Whether a model's class takes `method="json_schema"`, and its profile does not deny it."""
    if _profile(model).get("structured_output") is False:
        return False
    method = inspect.signature(type(model).with_structured_output).parameters.get("method")
    return method is not None and "json_schema" in str(method.annotation)


def takes_images(model: BaseChatModel) -> bool:
    """Whether a model takes pictures by its profile; a model without a profile is not sent any."""
    return bool(_profile(model).get("image_inputs"))


def _profile(model: BaseChatModel) -> Mapping[str, Any]:
    return getattr(model, "profile", None) or {}


def bound(model: BaseChatModel, mode: OutputMode, form: AnswerForm) -> Bound:
    """The model, set up to answer in a mode; its answers are messages, to be read by ourselves."""
    if mode == "json_schema":
        return _unparsed(model.with_structured_output(apart(form.schema), method="json_schema"))
    if mode == "tools":
        offered = list(form.tools)
        try:
            return model.bind_tools(apart(offered), tool_choice="any")
        except (NotImplementedError, TypeError, ValueError):
            return model.bind_tools(apart(offered))
    return model


def _unparsed(chain: Runnable[Any, Any]) -> Bound:
    """The model at the head of a chain that would parse its reply, or raise on it.

    The chain that keeps the raw answer is of no use: its pool of threads holds up the program's end where one hangs.
    """
    return chain.first if isinstance(chain, RunnableSequence) else chain


def wish_schema(offers: Sequence[Offer]) -> dict[str, Any]:
    """The JSON Schema of an answer to these offers; the reason first, since it is to come before the choice."""
    properties: dict[str, Any] = {"why": WHY, "option": {"type": "string", "enum": [offer.name for offer in offers]}}
    given = [dict(offer.parameters) for offer in offers if offer.parameters]
    if given:
        free = [NO_PARAMETERS] if len(given) < len(offers) else []
        choices = [*free, *given]
        properties["parameters"] = choices[0] if len(choices) == 1 else {"anyOf": choices}
    return {
        "title": "answer",
        "description": "The option chosen, and why.",
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


def tool_specifications(offers: Sequence[Offer]) -> list[dict[str, Any]]:
    """One function an option, in the form that every provider's package understands."""
    return [
        {
            "type": "function",
            "function": {
                "name": callable_name(offer.name),
                "description": f"Choose this option: {offer.about or offer.name}",
                "parameters": _with_why(dict(offer.parameters or NO_PARAMETERS)),
            },
        }
        for offer in offers
    ]


def _with_why(schema: dict[str, Any]) -> dict[str, Any]:
    properties = schema.get("properties", {})
    return schema if "why" in properties else schema | {"type": "object", "properties": {"why": WHY, **properties}}
