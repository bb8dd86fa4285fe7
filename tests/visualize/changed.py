# SPDX-License-Identifier: Apache-2.0
"""The design's example as someone in a hurry would change it: a little of each thing that a review must find."""

from __future__ import annotations

import json

from rai_missions.mission.mission import Mission
from tests.visualize.runs import document

__all__ = ("changed",)


def changed() -> Mission:
    new = document()
    states, decision = new["states"], new["states"]["assessing"]["decision"]
    new["version"] = "1.1.0"
    new["invariants"] = {}
    new["blackboard"]["battery"]["max_age_s"] = 60
    new["transitions"][0]["when"]["all"][1]["any"].pop()
    decision["options"]["drive_over"]["when"]["all"][1]["<"] = 0.4
    decision["options"]["reverse"] = {"about": "drive back a little"}
    states["assessing"]["transitions"].append({"on": "reverse", "to": "reversing"})
    states["reversing"] = {"action": "reverse", "timeout_s": 20, "transitions": [{"on": "succeeded", "to": "resume"}]}
    states["working"]["states"]["driving"]["timeout_s"] = 2000
    states["assessing"]["transitions"][2]["to"] = "aborted"
    del states["signalling"]
    return Mission.model_validate(json.loads(json.dumps(new).replace('"replanning"', '"next_alley"')))
