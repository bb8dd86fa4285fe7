# SPDX-License-Identifier: Apache-2.0
"""The smallest mission that ends by itself, and a working directory with its file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

__all__ = ("LAMP", "lamp_folder")

LAMP: dict[str, Any] = {
    "name": "lamp",
    "initial": "on",
    "states": {"on": {"transitions": [{"after_s": 0.01, "to": "off"}]}, "off": {"final": "aborted"}},
}


def lamp_folder(folder: Path, monkeypatch: pytest.MonkeyPatch, lamp: Mapping[str, Any] = LAMP) -> Path:
    """A folder with `lamp.json`, which is the working directory until the test ends."""
    monkeypatch.chdir(folder)
    (folder / "lamp.json").write_text(json.dumps(lamp), encoding="utf-8")
    return folder
