# SPDX-License-Identifier: Apache-2.0
"""Colours, pens and fonts, and how wide a text is.

Rule: nothing is shown by colour alone; a shape, a word or a pen's width shows it too. The colours are those of
Okabe and Ito (Color Universal Design, 2008), which readers with any common colour blindness can distinguish.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from typing import NamedTuple

from visualize.model import PictureNode

__all__ = (
    "FONT",
    "FONTS",
    "INK",
    "LOOKS",
    "MARKS",
    "MUTED",
    "OUTCOMES",
    "Look",
    "clean",
    "look_of",
    "width",
    "wrapped",
)

FONT = "Helvetica"
"""In DOT: the one name whose measures every Graphviz knows."""
FONTS = "Helvetica,Arial,Liberation Sans,DejaVu Sans,Noto Sans,sans-serif"
"""In SVG: the first of these that the reader's machine has."""
INK, MUTED = "#1A1A1A", "#6B6B6B"
BLACK, ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILLION, PURPLE = (
    "#000000", "#E69F00", "#56B4E9", "#009E73", "#F0E442", "#0072B2", "#D55E00", "#CC79A7",
)  # fmt: skip


class Look(NamedTuple):
    """How a kind of state looks."""

    word: str
    """What is on it."""
    pen: str
    fill: str
    shape: str = "box"
    rounded: bool = True


LOOKS: Mapping[str, Look] = {
    "": Look("wait", "#7A7A7A", "#FFFFFF"),
    "action": Look("action", BLUE, "#E6F1F8"),
    "call": Look("call", SKY, "#F1F9FE", "component", False),
    "decision": Look("decision", ORANGE, "#FFF6E3", "box", False),
    "tree": Look("tree", GREEN, "#EDF8F4", "folder", False),
    "mission": Look("mission", PURPLE, "#FBF1F6", "box3d", False),
    "states": Look("states", "#5A5A5A", "#FAFAFA"),
    "parallel": Look("parallel", "#5A5A5A", "#F4F4F8"),
    "each": Look("each", "#5A5A5A", "#F8F6F2"),
    "history": Look("history", "#5A5A5A", "#FFFFFF", "circle"),
    "final": Look("final", INK, "#FFFFFF", "ellipse"),
}
OUTCOMES: Mapping[str, Look] = {
    "succeeded": Look("succeeded", GREEN, "#E3F4EE", "ellipse"),
    "failed": Look("failed", VERMILLION, "#FCEBE1", "octagon"),
    "aborted": Look("aborted", VERMILLION, "#FCEBE1", "octagon"),
    "canceled": Look("canceled", PURPLE, "#FBF1F6", "hexagon"),
}


def look_of(node: PictureNode) -> Look:
    """How a state looks, a final by its outcome; one of another package's kind as one that waits."""
    return OUTCOMES[node.outcome] if node.kind == "final" else LOOKS.get(node.kind, LOOKS[""])


MARKS: Mapping[str, tuple[str, str, str]] = {
    "+": (BLUE, "bold", "added"),
    "-": (VERMILLION, "dashed", "removed"),
    "~": ("#9C4A7C", "dotted", "changed"),
}
"""Mark → pen, line style, word."""

ADVANCES = {
    **dict.fromkeys(map(chr, range(128)), 0.64),
    **dict.fromkeys("ABCDEFGHIJKLMNOPQRSTUVWXYZ", 0.74),
    **dict.fromkeys("ijl|.,:;'!` \u00a0", 0.34),
    **dict.fromkeys('ftrI()[]{}/\\-"*', 0.46),
    **dict.fromkeys("mwMW@%&", 1.0),
}
"""How far a character takes a line, in ems: DejaVu Sans, the widest of the fonts, rounded up."""
UNDRAWN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff\u200e\u200f\u202a-\u202e\u2066-\u2069]")
"""What no XML document may hold, and marks that would turn the reading direction of what follows."""

UNIT = re.compile(r"(\d) (s|m)\b")
"""A number and its unit stay together."""


def clean(text: str) -> str:
    """A text without characters that a picture cannot hold; each of them shows as `�`."""
    return UNDRAWN.sub("�", text.replace("\r\n", "\n").replace("\t", " "))


def width(text: str, size: float, *, bold: bool = False) -> float:
    """Points that a line takes at most, in any of `FONTS`: the reader may have another than the layout knew."""
    return math.fsum(map(_advance, text)) * size * (1.1 if bold else 1.0)


def _advance(character: str) -> float:
    """The advance of one character, in ems."""
    if character in ADVANCES:
        return ADVANCES[character]
    if unicodedata.category(character) in ("Mn", "Me", "Cf"):
        return 0.0
    if character >= "\U0001f000":
        return 1.4
    return 1.05 if unicodedata.east_asian_width(character) in "WF" else 0.85


LONGEST = 20_000
"""Characters of a text that are set at all; of more a picture shows nothing anyway."""


def wrapped(text: str, size: float, limit: float, *, bold: bool = False, lines: int = 12) -> list[str]:
    """A text in lines of at most so many points; words that are wider are broken, what is too long ends in `…`."""
    found: list[str] = []
    shown = text if len(text) <= LONGEST else f"{text[:LONGEST]} …"
    for paragraph in UNIT.sub("\\1\u00a0\\2", clean(shown)).split("\n"):
        line = ""
        for begins, piece in (each for word in paragraph.split(" ") for each in _pieces(word, size, limit, bold)):
            joined = f"{line} {piece}" if line and begins else line + piece
            if line and width(joined, size, bold=bold) > limit:
                found.append(line)
                line = piece
            else:
                line = joined
        found.append(line)
    if len(found) > lines:
        found = [*found[: lines - 1], f"{found[lines - 1]} …"]
    return [line for line in found if line.strip()] or [""]


def _pieces(word: str, size: float, limit: float, bold: bool) -> list[tuple[bool, str]]:
    """A word as it can be set, in pieces: (begins a word, characters); cut after `_`, `.` or `/` if possible."""
    if width(word, size, bold=bold) <= limit:
        return [(True, word)]
    pieces: list[tuple[bool, str]] = []
    piece = ""
    for character in word:
        if piece and width(piece + character, size, bold=bold) > limit:
            cut = max(piece.rfind("_"), piece.rfind("."), piece.rfind("/")) + 1
            cut = cut if cut > len(piece) // 2 else len(piece)
            pieces.append((not pieces, piece[:cut]))
            piece = piece[cut:]
        piece += character
    return [*pieces, (not pieces, piece)]
