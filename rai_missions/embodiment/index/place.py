# SPDX-License-Identifier: Apache-2.0
"""Where the index of a folder is kept: in the user's cache, under the folder's own name and path."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

__all__ = ("index_place",)

ENDING = ".identity"


def index_place(folder: Path) -> Path:
    """The file for a folder's index (XDG base directories: `XDG_CACHE_HOME`, else `~/.cache`)."""
    home = os.environ.get("XDG_CACHE_HOME", "")
    cache = Path(home) if os.path.isabs(home) else Path.home() / ".cache"
    real = os.path.realpath(folder)
    digest = hashlib.sha256(os.fsencode(real)).hexdigest()[:16]
    return cache / "rai-missions" / f"{Path(real).parent.name or 'root'}-{digest}{ENDING}"
