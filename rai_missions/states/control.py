# SPDX-License-Identifier: Apache-2.0
"""Who may command the robot's actuators, and who can hold control of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, get_args

__all__ = ("CONTROLLERS", "HOLDERS", "Controller", "Holder")

Controller = Literal["autonomy", "agent", "operator"]
"""Who may command the robot's actuators."""
Holder = Literal[Controller, "nobody"]
"""Who can hold control."""
HOLDERS: tuple[Holder, ...] = get_args(Holder)
CONTROLLERS: Mapping[str, str] = {
    "autonomy": "the autonomy stack", "agent": "the mission itself", "operator": "the operator", "nobody": "no one",
}  # fmt: skip
"""Who holds control, for a reader."""
