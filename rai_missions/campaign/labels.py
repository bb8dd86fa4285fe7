# SPDX-License-Identifier: Apache-2.0
"""Labels: what physics reports of each option in a scene, with forces and contacts.

Rule: an option is labelled by its rollout alone. No kind of obstacle and no opinion about one is read here.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from rai_missions.campaign.records import OptionVerdict, SceneRecord
from rai_missions.errors import UsageError
from rai_missions.worlds.orchard.trial import Trial, try_options

__all__ = ("Label", "label", "verdict_of")

TRIALS: Mapping[str, Callable[[Mapping[str, Any]], Mapping[str, Trial]]] = {"orchard": try_options}
"""World → what tries each option of its decision."""


@dataclass(frozen=True)
class Label:
    """What an option does in a scene."""

    verdict: OptionVerdict
    """`completes`: the alley is driven and nothing took harm; `harms`: something living was touched, a thing broke, or
    the tractor was struck or tilted beyond its limits; `harmless`: neither."""
    details: Mapping[str, Any]
    """The fields of `Trial`: what took harm, forces in N, angles in degrees, simulated seconds."""


def label(scene: SceneRecord) -> dict[str, Label]:
    """Roll out each option of a scene: option → its label; about 1.5 s of CPU a scene.

    Raises:
        UsageError: Nothing tries options in its world.
    """
    if scene.world not in TRIALS:
        raise UsageError(f"nothing tries options in the world '{scene.world}', but in: {', '.join(TRIALS)}")
    trials = TRIALS[scene.world](json.loads(scene.spec)["options"])
    return {option: Label(verdict_of(trial), asdict(trial)) for option, trial in trials.items()}


def verdict_of(trial: Trial) -> OptionVerdict:
    """The verdict that a rollout's measures amount to."""
    if trial.harmed:
        return "harms"
    return "completes" if trial.driven else "harmless"
