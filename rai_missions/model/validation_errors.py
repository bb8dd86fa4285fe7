# SPDX-License-Identifier: Apache-2.0
"""What a model refuses, as its author reads it: each fault with its place, in a plain sentence.

Rule: no sentence of pydantic's reaches an author.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import Annotated, Any, Protocol, Self, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from rai_missions.errors import DefinitionError, Fault, article, pointer, suggestion, uncalled, without_marks
from rai_missions.redaction import shown

__all__ = ("KEY", "NULL", "faults_of", "model_at", "place_of", "refusals", "validated", "words_of")

NULL = "null is no value; leave the word out"
"""What is wrong with null in place of a word that may be left out."""
MOST = 1000
"""How many faults are listed one by one; anyone who has more reads no further."""
KEY = "[key]"
"""pydantic's last step to the name of an entry, where the name and not the entry is at fault."""
DESCRIBING = frozenset(("Entry", "Fields", "File", "Spec", "Words"))
"""Last words of the names of classes that describe what the words before them name."""


class Validates(Protocol):
    """A model of pydantic's, and what type checkers take for one."""

    @classmethod
    def model_validate(cls, obj: Any, /) -> Self: ...


M = TypeVar("M", bound=Validates)


def validated(model: type[M], data: Any, source: str = "") -> M:
    """Plain data as a model.

    Args:
        model: What it is to be.
        data: As its author wrote it.
        source: Where it was found, for the error.

    Raises:
        DefinitionError: It is at fault, every fault with its place.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise DefinitionError(faults_of(error, model, data), source) from None


def faults_of(error: ValidationError, model: type[Any], data: Any, known: Collection[str] = ()) -> Iterator[Fault]:
    """What a validation found, one fault a place and sentence.

    Args:
        error: What validating `data` as `model` raised.
        model: Has the words that there are.
        data: Decides which of pydantic's steps are places in the document.
        known: The words of a constructor in Python, where `data` is what it was given.
    """
    reported: set[tuple[str, ...]] = set()
    found = refusals(error)
    if any(item["type"] == "package" for item in found):  # the words of its kinds are unknown until it is installed
        found = [item for item in found if item["type"] != "kind"]
    for item in _whole_lists(found[:MOST]):
        steps, rest = _steps(_loc(item), data)
        place = pointer(steps)
        # The branches of a union are no places: the fault of the first of them is enough.
        of_union = rest and item["type"] != "missing"
        seen = (place,) if of_union else (place, item["type"], str(item["loc"]), item["msg"])
        if seen in reported:
            continue
        reported.add(seen)
        there, words = model_at(model, data, steps), known if len(item["loc"]) == 1 else ()
        is_absent = item["input"] is None and item["type"] in WANTED and _may_lack(there, steps[-1] if steps else "")
        yield Fault(place, NULL if is_absent else _sentence(item, there, words))
    if len(found) > MOST:
        yield Fault("", f"and {len(found) - MOST} more faults; mend these first")


def refusals(error: ValidationError) -> list[Any]:
    """What a validation refused, as pydantic has it; a list of which items were refused counts as long as it was."""
    items = (each for item in error.errors(include_url=False) for each in (item, *_more(item)))
    return [item for item in items if not _is_shortened(item)]


def _more(item: Any) -> Iterator[Any]:
    """The other faults that a validator raised at once, each as pydantic has one."""
    for other in item.get("ctx", {}).get("more", ()):
        yield {**item, "type": other.type, "msg": other.message(), "ctx": other.context}


def _is_shortened(item: Any) -> bool:
    return bool(item["type"] == "too_short" and len(item["input"]) >= item["ctx"]["min_length"])


def _whole_lists(found: Sequence[Any]) -> Iterator[Any]:
    """Faults, with one for each list in which items are missing: in a list of a fixed length each is one of its own."""
    needed = {item["loc"][:-1]: item["loc"][-1] + 1 for item in found if _is_item_missing(item)}
    for item in found:
        if not _is_item_missing(item):
            yield item
        elif (length := needed.pop(item["loc"][:-1], None)) is not None:
            yield {**item, "type": "too_short", "ctx": {"actual_length": len(item["input"]), "min_length": length}}


def _is_item_missing(item: Any) -> bool:
    return item["type"] == "missing" and isinstance(item["loc"][-1], int)


def place_of(item: Any, data: Any) -> list[str | int]:
    """The steps of a fault's location that are places in the document; the fault is as pydantic has it."""
    return _steps(_loc(item), data)[0]


def _loc(item: Any) -> tuple[str | int, ...]:
    """Where a fault is: in what pydantic was validating, at the place that the validator names."""
    return (*item["loc"], *item.get("ctx", {}).get("at", ()))


def _steps(loc: tuple[str | int, ...], data: Any) -> tuple[list[str | int], bool]:
    """The steps that are places in the document, and whether any is left out."""
    if loc and loc[-1] == KEY:
        return list(loc[:-1]), False
    steps: list[str | int] = []
    for step in loc:
        listed = isinstance(data, list | tuple) and isinstance(step, int) and step < len(data)
        if not listed and not (isinstance(data, Mapping) and step in data):
            break
        data = data[step]
        steps.append(step)
    return steps, len(steps) < len(loc)


def model_at(model: type[Any], data: Any, steps: Iterable[str | int]) -> type[Any] | None:
    """The model as which a place, or what holds it, is read."""
    kind: Any = model
    found: type[BaseModel] | None = None
    for step in (*steps, None):
        kind = _bare(kind)
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            found = kind if kind is model else _chosen(kind, data)
            if found is None:
                return None
            fields = found.model_fields.items()
            kind = next((each.annotation for name, each in fields if (each.alias or name) == step), None)
        elif get_origin(kind) in (dict, tuple):
            arguments = get_args(kind)
            kind = arguments[1] if get_origin(kind) is dict else arguments[0]
        try:
            data = data[step]
        except (KeyError, IndexError, TypeError):
            break
    return found


def _chosen(kind: Any, data: Any) -> type[BaseModel] | None:
    """The kind as which data is read, where a model has several; None where it is none of them."""
    found: type[BaseModel] = kind
    if hasattr(kind, "choose") and isinstance(data, Mapping):
        try:
            found = kind.kind(kind.choose(data))
        except ValueError:
            return None
    return found


def _bare(kind: Any) -> Any:
    """A type without its annotations and without the choice of None."""
    while True:
        if get_origin(kind) is Annotated:
            kind = get_args(kind)[0]
            continue
        members = [each for each in get_args(kind) if each is not type(None)]
        if type(None) in get_args(kind) and len(members) == 1:
            kind = members[0]
            continue
        return kind


def _thing(model: type[Any] | None) -> str:
    """What a model is called, with its article."""
    if model is None:
        return "this"
    family, word = getattr(model, "family", ""), getattr(model, "word", "")
    name = f"{family} with '{word}'" if family and word else family or _noun(model.__name__)
    return article(name)


def _noun(class_name: str) -> str:
    """What an author calls the part of a file that a class describes: `ServiceEntry` is a service."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", class_name).split()
    return " ".join(words[:-1] if len(words) > 1 and words[-1] in DESCRIBING else words).lower()


def words_of(model: type[Any] | None) -> list[str]:
    """The words that an object of a model may have."""
    return [field.alias or name for name, field in model.model_fields.items()] if model else []


def _may_lack(model: type[Any] | None, word: str | int) -> bool:
    """Whether an object of a model may be without a word."""
    fields = model.model_fields.items() if model is not None else ()
    return any(word == (field.alias or name) and not field.is_required() for name, field in fields)


def _home(word: str, model: type[Any] | None) -> str:
    """The field of a model whose value has a word as its own; empty where none or several have."""
    inner = {
        field.alias or name: _bare(field.annotation) for name, field in (model.model_fields if model else {}).items()
    }
    homes = [
        name
        for name, kind in inner.items()
        if isinstance(kind, type) and issubclass(kind, BaseModel) and word in words_of(kind)
    ]
    return homes[0] if len(homes) == 1 else ""


def _other_form(word: str, model: type[Any] | None, known: Collection[str]) -> str:
    """How a field is called here, of which a word is the name in Python, or JSON's: `as`, which is `item` in Python."""
    fields = model.model_fields.items() if model is not None else ()
    python = next((name for name, field in fields if field.alias == word.rstrip("_") and name != word), "")
    if known:
        return python if python in known else ""
    return next((field.alias for name, field in fields if name == word and field.alias), "")


def _sentence(item: Any, model: type[Any] | None, known: Collection[str]) -> str:
    kind, given, ctx = item["type"], item["input"], item.get("ctx", {})
    if kind == "int_type" and item["loc"][-1] == "int":
        kind = "float_type"  # the first branch of `int | float`
    if "sentence" in ctx:
        return str(ctx["sentence"])
    if kind == "missing":
        return _missing(str(item["loc"][-1]), model, known)
    if kind == "extra_forbidden":
        return _unknown(str(item["loc"][-1]), model, tuple(known))
    if kind == "string_pattern_mismatch":
        return _misnamed(str(given), ctx.get("pattern", ""))
    if kind == "literal_error":
        choices = re.findall(r"'([^']*)'", ctx["expected"])
        near = suggestion(given, choices) if isinstance(given, str) and choices else f"; it is {ctx['expected']}"
        return f"no such choice: {shown(given)}{near}"
    if kind in WANTED:
        what, _, remedy = WANTED[kind].partition("; ")
        return f"{shown(given)} is {what}{uncalled(given) or _of_a_run(given) or f'; {remedy}'}"
    if kind in BOUNDED:
        return BOUNDED[kind](given, ctx)
    return f"{shown(given)} does not belong here: {item['msg'][:1].lower()}{item['msg'][1:]}"


def _of_a_run(given: object) -> str:
    """The remedy for a reference to a key or a field in Python, where only a constant fits; empty for all else."""
    is_reference = isinstance(getattr(given, "__path__", None), str)
    return "; its value is known in a run: write a constant" if is_reference else ""


def _missing(word: str, model: type[Any] | None, known: Collection[str]) -> str:
    """A field that is needed, as its author would write it."""
    fields = model.model_fields.items() if model is not None else ()
    name = next((name for name, field in fields if field.alias == word and name in known), word)
    return f"'{name}' is missing; {_thing(model)} needs it"


def _unknown(word: str, model: type[Any] | None, known: tuple[str, ...]) -> str:
    """A word that a model does not have, and the one that was meant, or where it belongs."""
    example = getattr(model, "example", "")
    if meant := getattr(model, "meant", {}).get(word) or _other_form(word, model, known):
        like = f", as in {example % meant}" if example else ""
        return f"{_thing(model)} has no {shown(word)}; did you mean '{meant}'{like}?"
    near = suggestion(word, known or words_of(model))
    if near.endswith("?"):
        return f"{_thing(model)} has no {shown(word)}{near}"
    if home := _home(word, model):
        near = f"; it belongs in '{home}'"
    like = f"; write it like {example % '<'}" if example else ""
    return f"{_thing(model)} has no {shown(word)}{near}{like}"


WANTED: Mapping[str, str] = {
    "string_type": "not text; write a word in quotes",
    "bool_type": "neither true nor false; write one of them, without quotes",
    "int_type": "not a whole number; write one, without quotes",
    "int_from_float": "not a whole number; write one without a fraction",
    "float_type": "not a number; write one, without quotes",
    "finite_number": "not finite; write a number that JSON has",
    "dict_type": "not an object; write {…}",
    "model_type": "not an object; write {…}",
    "model_attributes_type": "not an object; write {…}",
    "mapping_type": "not an object; write {…}",
    "tuple_type": "not a list; write […]",
    "list_type": "not a list; write […]",
}
"""pydantic's type of a fault → what the given value is, and what would be right."""

BOUNDED: Mapping[str, Callable[[Any, Any], str]] = {
    "greater_than": lambda given, ctx: f"{shown(given)} is too small; it must be more than {ctx['gt']:g}",
    "greater_than_equal": lambda given, ctx: f"{shown(given)} is too small; it must be {ctx['ge']:g} or more",
    "less_than": lambda given, ctx: f"{shown(given)} is too large; it must be less than {ctx['lt']:g}",
    "less_than_equal": lambda given, ctx: f"{shown(given)} is too large; it must be {ctx['le']:g} or less",
    "string_too_short": lambda given, ctx: f"{shown(given)} is too short; it has {ctx['min_length']} letter or more",
    "too_short": lambda given, ctx: f"{ctx['actual_length']} given; write {ctx['min_length']} or more",
    "too_long": lambda given, ctx: f"{ctx['actual_length']} given; write {ctx['max_length']} at the most",
}


def _misnamed(given: str, pattern: str) -> str:
    """Why a word is no name, and the nearest that is one."""
    plain = without_marks(re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", given))
    near = re.sub(r"[^a-z0-9_./]+" if r"\." in pattern else r"[^a-z0-9_/]+", "_", plain)
    near = near.strip("_/.").lstrip("_/.0123456789")
    hint = f"; did you mean '{near}'?" if near and len(near) <= 60 and re.match(pattern, near) else ""
    # a letter of another script may look like the one that was meant
    if foreign := next((each for each in plain if not (each.isascii() and each.isprintable())), ""):
        hint = f"; {shown(foreign)} is {unicodedata.name(foreign, 'no letter')}"
    if r"\." in pattern:
        return f"{shown(given)} is neither a key nor a field of one; write it like 'obstacle.height_m'{hint}"
    return f"{shown(given)} is not a name; a name is lower case letters, digits and '_', a letter first{hint}"
