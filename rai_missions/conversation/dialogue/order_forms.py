# SPDX-License-Identifier: Apache-2.0
"""What a model may propose, as closed JSON Schemas, and the order that a proposal is.

Rule: what a model proposes becomes an order only by this closed form, and is always read back.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.conversation.grammar.arguments import IN_WORDS
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.view import KeyView, StatusView
from rai_missions.engine.decision import Offer
from rai_missions.keys import Key, type_error
from rai_missions.mission.option_parameters import parameter_faults
from rai_missions.profile.conversation import ORDERS

__all__ = ("order_forms", "proposed")


def order_forms(view: StatusView, allowed: frozenset[str]) -> tuple[Mapping[str, Any], ...]:
    """What a model may propose now, each a closed JSON Schema."""
    forms = list[Mapping[str, Any]]()
    for name in ("pause", "resume", "cancel", "stop"):
        if name in allowed:
            forms.append(_form({"order": {"const": name}}))
    if "start" in allowed:
        for mission in view.missions:
            arguments = {key.name: _argument_schema(key) for key in mission.arguments}
            fields = {"order": {"const": "start"}, "mission": {"const": mission.name}}
            forms.append(
                _form(fields, arguments={"type": "object", "properties": arguments, "additionalProperties": False})
            )
    for question in view.questions if "answer" in allowed else ():
        which = {"question": {"const": question.number}} if len(view.questions) > 1 else {}
        for offer in question.options:
            forms.append(_answer_form({"order": {"const": "answer"}, **which, "option": {"const": offer.name}}, offer))
    return tuple(forms)


def _answer_form(fields: Mapping[str, Any], offer: Offer) -> Mapping[str, Any]:
    if not offer.parameters:
        return _form(fields)
    parameters = {"parameters": dict(offer.parameters)}
    has_to_have = bool(parameter_faults(offer.parameters, {}))
    return _form({**fields, **parameters}) if has_to_have else _form(fields, **parameters)


def _argument_schema(key: KeyView) -> Mapping[str, Any]:
    limits = {"minimum": key.minimum, "maximum": key.maximum, "enum": None if key.enum is None else list(key.enum)}
    kind = "array" if key.type == "list" else key.type if key.type in IN_WORDS else "object"
    return {"type": kind, **{name: limit for name, limit in limits.items() if limit is not None}}


def _form(fields: Mapping[str, Any], **optional: Any) -> Mapping[str, Any]:
    properties = {**fields, **optional}
    return {"type": "object", "properties": properties, "required": list(fields), "additionalProperties": False}


def proposed(order: object, view: StatusView) -> Sense | None:
    """The order that a model proposes; None where it is not exactly of the closed form.

    Args:
        order: Anything: it comes from outside.
        view: The run at this moment.
    """
    if not isinstance(order, Mapping):
        return None
    name = order.get("order")
    fields = {"start": {"mission", "arguments"}, "answer": {"question", "option", "parameters"}}
    if not isinstance(name, str) or name not in ORDERS or set(order) - {"order"} - fields.get(name, set()):
        return None
    if name == "start":
        return _proposed_start(order, view)
    if name == "answer":
        return _proposed_answer(order, view)
    return Sense("order", name)


def _proposed_start(order: Mapping[str, Any], view: StatusView) -> Sense | None:
    mission = view.mission_named(order.get("mission"))
    values = order.get("arguments", {})
    if mission is None or not isinstance(values, Mapping):
        return None
    keys = mission.keys
    if any(
        name not in keys or value is None or type_error(_key_of(keys[name]), value) for name, value in values.items()
    ):
        return None
    return Sense("order", "start", mission=mission.name, arguments=dict(values))


def _proposed_answer(order: Mapping[str, Any], view: StatusView) -> Sense | None:
    option, values = order.get("option"), order.get("parameters", {})
    number = order.get("question", view.questions[0].number if len(view.questions) == 1 else 0)
    if type(number) is not int or not isinstance(option, str):
        return None
    sense = Sense("order", "answer", question=number, option=option)
    offer = view.offer(number, option)
    if offer is None or not isinstance(values, Mapping):
        return None
    if parameter_faults(offer.parameters, values) if offer.parameters else "parameters" in order:
        return None
    return sense._replace(parameters=dict(values))


def _key_of(view: KeyView) -> Key:
    return Key(
        view.type, source="argument", frame=view.frame, minimum=view.minimum, maximum=view.maximum, enum=view.enum
    )
