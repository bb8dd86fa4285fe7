# SPDX-License-Identifier: Apache-2.0
"""The data of a scene, as a store and the generator have it: what its world is built from, and who answers later."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

__all__ = ("later_of", "scene_spec")

LATER = "later"
Later = Mapping[str, Mapping[str, str]]
"""Name in `ask` → the state that asks → the option."""


def scene_spec(world: str, options: Mapping[str, Any], later: Later) -> str:
    """As JSON: `world`, `options` with which `open_world` builds it, and `later` where someone answers then."""
    return json.dumps({"world": world, "options": options, **({LATER: later} if later else {})}, sort_keys=True)


def later_of(spec: str) -> Later:
    """Who answers later questions of a rollout in a scene.

    Args:
        spec: The scene's data, as JSON.
    """
    found: Later = json.loads(spec).get(LATER, {})
    return found
