# SPDX-License-Identifier: Apache-2.0
"""Values of events and the blackboard as JSON, and back, exactly.

Rule: what cannot come back equal is refused. An object of the format's own has one word that begins with `$`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, cast

from rai_missions.errors import UsageError
from rai_missions.image import Image
from rai_missions.plain_data import are_finite
from rai_missions.redaction import cut_repr

__all__ = ("Fetch", "Keep", "from_json", "keep_nothing", "pictures_in", "to_json")

Keep = Callable[[Image], str]
"""Stores the bytes of a picture and gives their SHA-256 in hex; empty where they are not kept."""
Fetch = Callable[[str, str], Callable[[], bytes]]
"""What makes the bytes of a picture that was read, by its reference and SHA-256 (empty: they were not kept)."""


def keep_nothing(image: Image) -> str:
    """Every picture is a reference alone."""
    return ""


def to_json(value: Any, keep: Keep = keep_nothing) -> Any:
    """A value as JSON has it.

    | value                        | JSON                                                                     |
    |------------------------------|--------------------------------------------------------------------------|
    | a picture                    | `{"$image": ref, "width", "height", "encoding"}`, `"sha256"` if it is kept |
    | a tuple                      | `{"$tuple": […]}`                                                        |
    | an infinite number           | `{"$number": "inf"}`, `{"$number": "-inf"}`                              |
    | an object with a word in `$` | `{"$object": {…}}`                                                       |

    Raises:
        UsageError: A value that JSON has not: NaN, bytes, a key that is no text, any other type.
    """
    kind = type(value)
    if kind is str or kind is int or value is None or kind is bool:
        return value
    if kind is float:
        return value if math.isfinite(value) else _infinite(value)
    if kind is list:
        return value.copy() if are_finite(value) else [to_json(item, keep) for item in value]
    if isinstance(value, Mapping):
        return _object(value, keep)
    if isinstance(value, Image):
        return _picture(value, keep)
    if isinstance(value, tuple):
        return {"$tuple": [to_json(item, keep) for item in value]}
    raise UsageError(
        f"a journal holds text, numbers, true, false, null, lists, objects and pictures, not {cut_repr(value, 80)} "
        f"({kind.__name__}); make plain data of it before it becomes an event"
    )


def _infinite(value: float) -> dict[str, str]:
    if math.isnan(value):
        raise UsageError("a journal holds no NaN, for it never equals itself; state null for an unknown number")
    return {"$number": "inf" if value > 0 else "-inf"}


def _object(value: Mapping[Any, Any], keep: Keep) -> dict[str, Any]:
    plain, own = {}, False
    for name, item in value.items():
        if type(name) is not str:
            raise UsageError(
                f"the names of an object in a journal are text, not {cut_repr(name, 80)}; "
                f"write {cut_repr(str(name), 80)}"
            )
        own = own or name.startswith("$")
        plain[name] = to_json(item, keep)
    return {"$object": plain} if own else plain


def pictures_in(written: Any) -> Iterator[Mapping[str, Any]]:
    """The pictures of which a written value reports that their bytes are kept, each as it is written."""
    if isinstance(written, list):
        for item in written:
            yield from pictures_in(item)
    elif isinstance(written, dict):
        own = written.get("$object")
        if "$image" in written and written.get("sha256"):
            yield written
        for item in (own if isinstance(own, dict) else written).values():
            yield from pictures_in(item)


def _picture(image: Image, keep: Keep) -> dict[str, Any]:
    written = {"$image": image.ref, "width": image.width, "height": image.height, "encoding": image.encoding}
    digest = keep(image)
    return {**written, "sha256": digest} if digest else written


def from_json(value: Any, fetch: Fetch) -> Any:
    """The value that `to_json` wrote.

    Raises:
        ValueError: An object with a `$` word that is none of the format's.
    """
    if isinstance(value, list):
        return value.copy() if are_finite(value) else [from_json(item, fetch) for item in value]
    if not isinstance(value, dict):
        return value
    word = next(iter(value), "")
    if not word.startswith("$"):
        return {name: from_json(item, fetch) for name, item in value.items()}
    own = value[word]
    if word == "$image" and isinstance(own, str):
        return _image(value, fetch)
    if word == "$tuple" and isinstance(own, list):
        return tuple(from_json(item, fetch) for item in own)
    if word == "$number" and own in ("inf", "-inf"):
        return float(own)
    if word == "$object" and isinstance(own, dict):
        return {name: from_json(item, fetch) for name, item in own.items()}
    raise ValueError(f"no value is written with {cut_repr(word, 40)}; there is: $image, $tuple, $number, $object")


def _image(written: Mapping[str, Any], fetch: Fetch) -> Image:
    ref, digest = written["$image"], written.get("sha256", "")
    width, height, encoding = (cast("Any", written.get(name)) for name in ("width", "height", "encoding"))
    if [type(item) for item in (width, height, encoding, digest)] != [int, int, str, str]:
        raise ValueError(f"{cut_repr(written, 80)} is given where a picture belongs")
    return Image(ref, width, height, encoding, fetch(ref, digest))
