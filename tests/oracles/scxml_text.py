# SPDX-License-Identifier: Apache-2.0
"""A generated chart as SCXML text, for interpreters that read it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from xml.sax.saxutils import quoteattr

from tests.oracles.appendix_d import many

__all__ = ("scxml_text",)

Json = dict[str, Any]


def scxml_text(document: Json) -> str:
    """The chart in the data model `python`; what is logged is the `expr` of `<log>`."""
    return "\n".join(_document(document))


def _document(document: Json) -> Iterator[str]:
    initial = " ".join(many(document["initial"]))
    words = 'xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="python"'
    yield f"<scxml {words} initial={quoteattr(initial)}>"
    yield "<datamodel>"
    for name, key in document["blackboard"].items():
        yield f'<data id="{name}" expr="{key["initial"]}"/>'
    yield "</datamodel>"
    for name, state in document["states"].items():
        yield from _state(name, state, document)
    yield "</scxml>"


def _state(name: str, state: Json, parent: Json) -> Iterator[str]:
    if "history" in state:
        target = " ".join(many(parent["initial"]))
        yield f'<history id="{name}" type="{state["history"]}"><transition target="{target}"/></history>'
        return
    word = next((word for word in ("parallel", "final") if word in state), "state")
    initial = f' initial="{" ".join(many(state["initial"]))}"' if "states" in state else ""
    yield f'<{word} id="{name}"{initial}>'
    yield f"<onentry>{_content(state.get('entry', []))}</onentry>"
    yield f"<onexit>{_content(state.get('exit', []))}</onexit>"
    for transition in state.get("transitions", []):
        yield _transition(name, transition)
    for child, inner in (state.get("states") or state.get("parallel") or {}).items():
        yield from _state(child, inner, state)
    yield f"</{word}>"


def _transition(source: str, transition: Json) -> str:
    names = [f"done.state.{source}" if name == "succeeded" else name for name in many(transition.get("on"))]
    words = {
        "event": " ".join(names), "cond": _condition(transition["when"]) if "when" in transition else "",
        "target": " ".join(many(transition.get("to"))), "type": "internal" if transition.get("internal") else "",
    }  # fmt: skip
    given = " ".join(f"{word}={quoteattr(value)}" for word, value in words.items() if value)
    return f"<transition {given}>{_content(transition.get('do', []))}</transition>"


def _condition(guard: Json) -> str:
    if "key" in guard:
        op = next(word for word in guard if word != "key")
        return f"{guard['key']} {op} {guard[op]}"
    if "in" in guard:
        return f"In('{guard['in']}')"
    if "not" in guard:
        return f"not ({_condition(guard['not'])})"
    word = "all" if "all" in guard else "any"
    return {"all": " and ", "any": " or "}[word].join(f"({_condition(each)})" for each in guard[word])


def _content(effects: list[Json]) -> str:
    return "".join(map(_element, effects))


def _element(effect: Json) -> str:
    if "log" in effect:
        return f"<log expr={quoteattr(repr(effect['log']))}/>"
    if "set" in effect:
        key = effect["set"]
        value = f"{key} + {effect['add']}" if "add" in effect else str(effect["value"])
        return f'<assign location="{key}" expr={quoteattr(value)}/>'
    return f'<raise event="{effect["raise"]}"/>'
