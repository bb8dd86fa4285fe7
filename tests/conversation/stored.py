# SPDX-License-Identifier: Apache-2.0
"""The stored sentences, and what the tests of sentences share: a robot that assists, and what is read back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rai_missions.conversation import KeyView, MissionView, Order, Output, Settings, StatusView, TalkNote

FOLDER = Path(__file__).parent / "data"


def read(name: str) -> Any:
    """The content of a stored file."""
    return json.loads((FOLDER / name).read_text(encoding="utf-8"))


SENTENCES, CLAIMS = read("sentences.json"), read("claims.json")
ARGUMENTS = tuple(KeyView(name, "string", "argument") for name in ("task", "object", "place"))
ASSISTING = StatusView(mode="running", mission="assist", robot="rob", missions=(MissionView("assist", "", ARGUMENTS),))
KEYS = {name: KeyView(name, "number") for name in ("battery", "ahead_m", "pose")}
PATROLLING = StatusView(run="r1", mode="running", robot="rosbot, simulated", mission="rosbot_patrol", keys=KEYS)


def settings_in(
    code: str, phrases: Mapping[str, Mapping[str, Any]], places: Mapping[str, str], *, has_model: bool = False
) -> Settings:
    """The settings of a robot that is sent to places in one language."""
    names = {"place": places}
    return Settings(language=code, phrases=phrases, names=names, has_model=has_model)


def read_back(outputs: tuple[Output, ...]) -> list[dict[str, str] | None]:
    """The arguments of each order that is read back as a rule reads it; None where an order is given out."""
    found = [order for mapper, order in _read_back(outputs) if mapper != "nearest"]
    done = [None for each in outputs if isinstance(each, Order)]
    return [each.get("arguments", {}) for each in found] + done


def offered(outputs: tuple[Output, ...]) -> list[Mapping[str, Any]]:
    """Each order that is offered for what no rule reads."""
    return [order for mapper, order in _read_back(outputs) if mapper == "nearest"]


def _read_back(outputs: tuple[Output, ...]) -> list[tuple[str, Mapping[str, Any]]]:
    notes = [each.data for each in outputs if isinstance(each, TalkNote) and each.kind == "read_back"]
    return [(each["mapper"], each["order"]) for each in notes]
