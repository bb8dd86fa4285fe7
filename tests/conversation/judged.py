# SPDX-License-Identifier: Apache-2.0
"""Whether what came of a sentence is what was meant, in the form of the stored sets.

`start task=go place=kitchen` is that start, `start …; start …` a list of them; further orders are `pause`, `resume`,
`cancel`, `stop`. `option wait minutes=5` is an answer, `doubt skip` one that is read back or none, `asks` none,
`nothing` no order, `no stop` any other; `a or b` is one of both. `key battery` is the value of a key, and any other
word the sense of a question.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rai_missions.conversation import Order, Output, Speech, StatusView, TalkNote
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.language.language import language

__all__ = ("is_meant", "ordered")

SENSES = {
    "state": ("doing", "mission", "happened", "progress"), "where": ("where", "key"), "why": ("why_stopped", "waits"),
    "can": ("capabilities", "places"), "who": ("who",), "progress": ("time_left", "progress"), "options": ("asked",),
    "found": ("result", "happened", "count", "where_is"), "battery": ("key",), "next": ("queued",),
    "long": ("time_left", "since", "progress"), "done": ("happened", "progress", "result"),
}  # fmt: skip
ORDERS = ("start", "stop", "pause", "resume", "cancel")


def ordered(found: Sequence[Output]) -> list[Mapping[str, Any]]:
    """The orders that are given out, or else those of the first that is read back or offered."""
    given = [
        {"order": each.name, "arguments": each.arguments, "option": each.option, "is_given": True}
        for each in found
        if isinstance(each, Order)
    ]
    backs = [each.data["order"] for each in found if isinstance(each, TalkNote) and each.kind == "read_back"]
    return [*given, *(part for back in backs[:1] for part in (back, *back.get("then", ())))]


def is_ordered(order: Mapping[str, Any], expected: str) -> bool:
    """Whether an order has what is named: `start task=go ward=lab`; a text may have more words."""
    words, values = expected.split(), dict[str, str]()
    for each in words[1:]:
        name, sign, value = each.strip("()").partition("=")
        values |= {name: value} if sign else {list(values)[-1]: f"{values[list(values)[-1]]} {name}"}
    given = order.get("arguments") or order.get("parameters") or {}
    texts = {name: str(given.get(name)) for name in values}
    has_each = all(value in (texts[name], *texts[name].split()) for name, value in values.items())
    return order["order"] == words[0] and has_each


def is_meant(
    text: str,
    expected: str,
    found: Sequence[Output],
    view: StatusView,
    code: str,
    answers: Callable[[str, str], bool] = lambda key, spoken: False,
) -> bool:
    """Whether what came of a sentence is what was meant.

    Args:
        text: The sentence.
        expected: In the form above.
        found: What came of it.
        view: The run.
        code: The language.
        answers: Whether what was spoken answers what a key is.
    """
    if " or " in expected:
        return any(is_meant(text, each, found, view, code, answers) for each in expected.split(" or "))
    orders, (first, _, what) = ordered(found), expected.partition(" ")
    if first in ORDERS:
        each = expected.split(" ; ")
        return len(orders) == len(each) and all(map(is_ordered, orders, each))
    names = [each["order"] for each in orders]
    if first == "key":
        return not orders and answers(what, " ".join(each.text for each in found if isinstance(each, Speech)))
    if first in ("nothing", "asks", "no", "option", "doubt"):
        option, *values = what.split() or [""]
        is_chosen = bool(orders) and orders[0].get("option") == option
        return {
            "nothing": not orders,
            "asks": "answer" not in names,
            "no": what not in names,
            "option": is_chosen and is_ordered(orders[0], " ".join(["answer", *values])),
            "doubt": not orders or (is_chosen and "is_given" not in orders[0]),
        }[first]
    grammar = Grammar(language(code))
    senses = (*grammar.senses(text, view), grammar.question_by_sense(text, view))
    return next((each.name for each in senses if each is not None), "") in SENSES[first]
