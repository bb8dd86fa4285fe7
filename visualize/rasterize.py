# SPDX-License-Identifier: Apache-2.0
"""The door to resvg: an SVG as a PNG, set in the fonts of this machine, whichever of them has a character.

Rule: nothing else knows `resvg_py`. It runs in a process of its own, which alone can determine what it had no font for.
"""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys

from rai_missions.image import file_kind
from rai_missions.redaction import logger

__all__ = ("can_raster", "raster")

PROGRAM = """
import os, sys
from resvg_py import svg_to_bytes
with os.fdopen(os.dup(1), "wb") as out:
    os.dup2(2, 1)
    svg = sys.stdin.buffer.read().decode("utf-8")
    out.write(bytes(svg_to_bytes(svg_string=svg, dpi=float(sys.argv[1]), log_information=True)))
"""
"""A program of one process each: what resvg prints to stdout, where the picture goes, is sent to stderr."""
LACKING = re.compile(r"No fonts with a .*?/U\+([0-9A-F]+) character")
SHOWN = 12
"""Characters that are sent one by one."""
log = logger(__name__)


def can_raster() -> bool:
    """Whether resvg is installed."""
    return importlib.util.find_spec("resvg_py") is not None


def raster(svg: bytes, dpi: int) -> bytes | None:
    """The bytes of a PNG; None where resvg refuses, for then another program must.

    Warns of characters that no font here has: those are boxes in the picture.
    """
    ended = subprocess.run([sys.executable, "-c", PROGRAM, str(dpi)], input=svg, capture_output=True, check=False)
    if ended.returncode or file_kind(ended.stdout) != "png":
        return None
    lacking = dict.fromkeys(chr(int(found, 16)) for found in LACKING.findall(ended.stderr.decode(errors="replace")))
    if lacking:
        some = " ".join(list(lacking)[:SHOWN]) + (" …" if len(lacking) > SHOWN else "")
        log.warning(
            "no font on this machine has %d of the characters of this picture, which are boxes in the PNG: %s;"
            " install a font that has them (on Debian: apt-get install fonts-noto), or draw an .svg",
            len(lacking),
            some,
        )
    return ended.stdout
