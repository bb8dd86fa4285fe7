# SPDX-License-Identifier: Apache-2.0
"""What is in a journal's rows, and the chain of hashes that holds them together.

Rule: a row's content is JSON text, and its hash covers that text byte for byte; nothing is worked out again to check
it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.journal.codec import form_of, wrong
from rai_missions.journal.json_values import Fetch, to_json
from rai_missions.redaction import cut_repr

__all__ = (
    "GENESIS",
    "MIGRATED",
    "Blob",
    "Confirmation",
    "Header",
    "JournalRow",
    "Note",
    "Raw",
    "StepRow",
    "chained",
    "parsed",
    "read_header",
    "text_of",
    "written_header",
)  # fmt: skip

GENESIS = "0" * 64
"""What row 0 follows."""
MIGRATED = "the run continues in another mission"
"""The text of the note that is a journal's last row from then on; its data names the other journal."""
LEFT_OUT = ("migrated", "programs", "played")
"""Fields of row 0 that are written only where they hold something."""
Raw = tuple[int, Any, Any, Any]
"""A row as it is in the file: number, kind, content and hash."""
ENCODER = json.JSONEncoder(separators=(",", ":"), allow_nan=False)
"""Writes a row's content; `json.dumps` would make one for each row."""
Blob = tuple[str, str, bytes]
"""Bytes that a journal keeps: their SHA-256 in hex, their media type, and they themselves."""


class Header(NamedTuple):
    """Row 0: what is needed to run it all again."""

    mission: str
    """The mission as `dump` writes it."""
    profile: str = ""
    """The robot profile as it was read; empty for a run without one."""
    arguments: Mapping[str, Any] = {}
    """Argument key → its value in this run."""
    run: str = ""
    """The run's id; `Journal.create` makes one where it is empty."""
    started: str = ""
    """Wall time at the start, ISO 8601 with its zone; filled in where it is empty."""
    versions: Mapping[str, str] = {}
    """`rai_missions`, `python` and each package that offers a kind, connector or world; the first two are added."""
    migrated: Mapping[str, str] = {}
    """Of a run that another mission began: the `journal` of that one, its `seal` then, and the `map`."""
    programs: Mapping[str, str] = {}
    """Files in Python that a person named, as `guards` or `mission` → the SHA-256 of each, in hex."""
    played: bool = False
    """A person played the robot (`rai-missions try`): it is evidence of nothing that a robot did."""


class StepRow(NamedTuple):
    """A step, and what the engine knew right before it."""

    row: int
    step: Step
    since: float
    """The engine's clock right before the event was taken, seconds."""
    before: tuple[tuple[str, Any, float], ...] = ()
    """The blackboard writes that enabled nothing since the row before: key, value and stamp, the newest of a key."""


class Confirmation(NamedTuple):
    """The effects of a step were carried out."""

    row: int
    number: int
    """The step's."""
    how: str


class Note(NamedTuple):
    """Something a reader should know that is no step."""

    row: int
    text: str
    data: Any = None

    @property
    def successor(self) -> Mapping[str, Any] | None:
        """Where the run continues in another mission: the `journal` there, and its `seal`; None where it does not."""
        return self.data if isinstance(self.data, Mapping) and {"journal", "seal"} <= self.data.keys() else None


JournalRow = StepRow | Confirmation | Note


def chained(before: str, number: int, kind: str, content: str) -> str:
    """A row's hash: SHA-256, in hex, of the four parts joined by line feeds.

    Args:
        before: The hash of the row before; `GENESIS` for row 0.
        number: The row's own, from 0.
        kind: `header`, `step`, `confirmation` or `note`.
        content: JSON text.
    """
    return hashlib.sha256(f"{before}\n{number}\n{kind}\n{content}".encode("utf-8", "surrogatepass")).hexdigest()


def text_of(content: Any) -> str:
    """JSON text, ASCII alone, without spaces.

    Raises:
        UsageError: Something in it that JSON has not.
    """
    try:
        return ENCODER.encode(content)
    except (ValueError, TypeError) as error:
        raise UsageError(
            f"a journal holds plain data: {error}; make plain data of it before it becomes a step"
        ) from None


def written_header(header: Header) -> str:
    """The content of row 0."""
    fields = {name: value for name, value in header._asdict().items() if value or name not in LEFT_OUT}
    return text_of({**fields, "format": 1, "arguments": to_json(header.arguments)})


def read_header(kind: str, content: str, fetch: Fetch) -> Header:
    """The header in row 0.

    Raises:
        ValueError, TypeError: There is none in it.
    """
    if kind != "header":
        raise ValueError(f"a {cut_repr(kind, 20)} is in its place")
    fields = _object(content)
    if fields.pop("format", None) != 1:
        raise ValueError("its 'format' is not 1")
    header: Header = form_of(Header).read(fields, fetch)
    for name in ("migrated", "programs"):
        if not all(isinstance(text, str) for text in getattr(header, name).values()):
            raise ValueError(f"its '{name}' is no object of texts")
    return header


def parsed(number: int, kind: str, content: str, fetch: Fetch) -> JournalRow:
    """A row as it was written.

    Raises:
        ValueError, TypeError: It is none.
    """
    if kind not in KINDS:
        raise ValueError(f"a row is one of {', '.join(KINDS)}, not {cut_repr(kind, 40)}")
    fields = _object(content)
    if kind == "step":
        _give_role(fields)
    row: JournalRow = form_of(KINDS[kind]).read({**fields, "row": number}, fetch)
    return row


def _give_role(fields: dict[str, Any]) -> None:
    """Journals of earlier versions have no role: there the name of who asked for control began with it.

    What a client asks for has a role in every journal that is written now, so no name counts there.
    """
    step = fields.get("step")
    event = step.get("event") if isinstance(step, dict) else None
    data = event.get("data") if isinstance(event, dict) and event.get("kind") == "control" else None
    if isinstance(data, dict) and "role" not in data:
        by = data.get("by")
        if isinstance(by, str) and (by == "operator" or by.startswith("operator ")):
            data["role"] = "operator"


def _object(content: str) -> dict[str, Any]:
    try:
        found = json.loads(content, parse_constant=_refused)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    if not isinstance(found, dict):
        raise wrong(found, "an object")
    return found


def _refused(word: str) -> Any:
    raise ValueError(f"{word} is no JSON")


KINDS: Mapping[str, Any] = {"step": StepRow, "confirmation": Confirmation, "note": Note}
