# SPDX-License-Identifier: Apache-2.0
"""Orders, judged like proposals: permitted for the role, possible now, and whether a person must confirm them.

Rule: what a model proposes becomes an order only by this closed form, and is always read back.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.conversation.free_answers import text_option
from rai_missions.conversation.language import Language, spoken
from rai_missions.conversation.outputs import Mapper
from rai_missions.conversation.run_words import state_of_run
from rai_missions.conversation.senses import Sense
from rai_missions.conversation.settings import ORDERS, Settings
from rai_missions.conversation.spoken_starts import spoken_start
from rai_missions.conversation.values import value_words
from rai_missions.conversation.view import KeyView, MissionView, StatusView
from rai_missions.engine.modes import next_mode
from rai_missions.event import Role
from rai_missions.keys import Key, type_error
from rai_missions.mission.option_parameters import parameter_faults
from rai_missions.plain_data import listed

__all__ = ("TWO_NEEDED", "binding", "is_request", "may", "must_confirm", "order_forms", "order_words", "proposed",
           "where_to_order", "why_not_now", "why_not_permitted")  # fmt: skip

TWO_NEEDED = frozenset({"start", "resume", "cancel"})
"""The spoken orders that two recognisers must agree on; so must they on the confirming yes."""
IN_ANY_MODE = frozenset({"cancel", "answer"})
"""Orders that mean the same in each mode of a run that is under way: a pause or resume meanwhile leaves them valid."""
CONFIRMED = frozenset({"start", "cancel"})
JSON_TYPE = {"integer": "integer", "number": "number", "boolean": "boolean", "string": "string", "list": "array"}


def may(role: Role, what: str, settings: Settings) -> bool:
    """Whether a role has a permission, by its name; a role that is not listed may do nothing."""
    return what in settings.may.get(role, frozenset())


def why_not_permitted(order: str, role: Role, channel: str, settings: Settings, language: Language) -> str:
    """The refusal, and where the order can be given."""
    where = where_to_order(settings, language)
    return language.text(
        "not_permitted", channel=language.word("channels", channel), role=language.word("roles", role),
        order=language.word("order_names", order), where=where,
    )  # fmt: skip


def where_to_order(settings: Settings, language: Language) -> str:
    """The channels at which an operator is met, in words."""
    return language.listed([language.word("channels", each) for each in settings.answer_at], "or")


def is_request(sense: Sense, view: StatusView) -> bool:
    """Whether it is a start that has to wait for the end of the mission that runs."""
    return sense.name == "start" and view.is_alive and not view.is_before_start


def why_not_now(sense: Sense, view: StatusView, language: Language) -> str:
    """Why an order is not possible in this moment, in words; empty where it is."""
    if not _is_possible(sense, view):
        return language.text(f"why_not_{sense.name}", state=state_of_run(view, language))
    if sense.name == "answer" and _offered(sense, view) is None:
        return language.text("bad_option", given=spoken(sense.option), question="").strip()
    return ""


def _is_possible(sense: Sense, view: StatusView) -> bool:
    """Whether the mode of the run lets an order be carried out; a run that has not begun has nothing to pause."""
    if sense.name == "stop":
        return True
    if sense.name == "start":
        return _can_start(sense, view)
    if sense.name == "answer":
        return bool(view.questions) and view.is_alive
    is_held_back = sense.name == "pause" and view.awaits_start and view.mode == "ready"
    return next_mode(view.mode, sense.name) is not None and not is_held_back


def _can_start(sense: Sense, view: StatusView) -> bool:
    if view.mission_named(sense.mission) is None:
        return False
    return not view.is_alive or (view.is_before_start and sense.mission == view.mission)


def _offered(sense: Sense, view: StatusView) -> Any:
    question = view.question(sense.question)
    options = question.options if question is not None else ()
    return next((offer for offer in options if offer.name == sense.option), None)


def must_confirm(sense: Sense, view: StatusView, *, mapper: Mapper, agreeing: int | None) -> bool:
    """Whether the order is read back before it counts.

    Args:
        sense: The order.
        view: The run.
        mapper: What read the sentence.
        agreeing: Of a spoken one, how many recognisers agree on it; None for a typed one.
    """
    if mapper == "model" or sense.is_partial or sense.name in CONFIRMED:
        return True
    if sense.name != "answer":
        return False
    return (sense.question, sense.option) in view.confirm or (agreeing is not None and agreeing < 2)


def binding(sense: Sense, view: StatusView) -> tuple[object, ...]:
    """What a confirmation rests on: where it differs later, what was read back is void."""
    is_open = sense.name != "answer" or view.question(sense.question) is not None
    mode = "any" if sense.name in IN_ANY_MODE and next_mode(view.mode, "cancel") else view.mode
    return view.run, mode, view.mission, is_open


def _key_of(view: KeyView) -> Key:
    return Key(view.type, source="argument", frame=view.frame, minimum=view.minimum, maximum=view.maximum)


def _argument_words(values: Mapping[str, Any], keys: Mapping[str, KeyView], language: Language) -> str:
    words = list[str]()
    for name, value in values.items():
        key = keys.get(name, KeyView(name, "string"))
        shown = listed(value) if key.type in ("pose", "object", "list") else value_words(value, key, language)
        words.append(language.text("argument", name=language.name_of(key.name), value=shown))
    return language.listed(words)


def order_words(sense: Sense, view: StatusView, settings: Settings, language: Language) -> str:
    """The order in words, with all that it does: `start the mission 'x' with alleys 4`, or as the profile calls it."""
    if sense.name == "start":
        keys = (view.mission_named(sense.mission) or MissionView(sense.mission)).keys
        if called := spoken_start(settings.spoken, settings.names, sense.arguments, keys, language):
            return called
        arguments = _argument_words(sense.arguments, keys, language)
        form = "order_start_with" if arguments else "order_start"
        return language.text(form, mission=spoken(sense.mission), arguments=arguments)
    if sense.name == "answer":
        asked = view.question(sense.question)
        question, text = ("", None) if asked is None else (asked.text, text_option([asked]))
        if text is not None and text.offer.name == sense.option and text.parameter in sense.parameters:
            return language.text("order_answer_text", text=sense.parameters[text.parameter], question=question)
        arguments = _argument_words(sense.parameters, {}, language)
        form = "order_answer_with" if arguments else "order_answer"
        return language.text(form, option=spoken(sense.option), arguments=arguments, question=question)
    return language.text(f"order_{sense.name}")


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
            optional = {"parameters": dict(offer.parameters)} if offer.parameters else {}
            forms.append(_form({"order": {"const": "answer"}, **which, "option": {"const": offer.name}}, **optional))
    return tuple(forms)


def _argument_schema(key: KeyView) -> Mapping[str, Any]:
    bounds = {"minimum": key.minimum, "maximum": key.maximum}
    kind = JSON_TYPE.get(key.type, "object")
    return {"type": kind, **{name: bound for name, bound in bounds.items() if bound is not None}}


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
    offer = _offered(sense, view)
    if offer is None or not isinstance(values, Mapping):
        return None
    if (offer.parameters is None and values) or (
        offer.parameters is not None and parameter_faults(offer.parameters, values)
    ):
        return None
    return sense._replace(parameters=dict(values))
