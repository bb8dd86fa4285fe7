# SPDX-License-Identifier: Apache-2.0
"""Parameters of a node as arguments of a mission."""

from __future__ import annotations

import pytest

from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from rai_missions.node.launched import arguments_of

MISSION = Mission.model_validate({
    "name": "given", "initial": "end", "states": {"end": {"final": "aborted"}},
    "blackboard": {"n": {"type": "integer", "source": "argument"}, "word": {"type": "string", "source": "argument"},
                   "target": {"type": "pose", "source": "argument"}, "points": {"type": "list", "source": "argument"},
                   "seen": {"type": "boolean", "source": "mission", "initial": False}},
})  # fmt: skip


def test_fields_and_json_texts_are_put_together() -> None:
    given = {"n": 2, "word": "3", "target.x": 1.0, "target.y": 2.0, "points": '[{"x": 1}]'}
    assert arguments_of(given, MISSION, {}) == {
        "n": 2,
        "word": "3",
        "target": {"x": 1.0, "y": 2.0},
        "points": [{"x": 1}],
    }


@pytest.mark.parametrize(
    ("parameters", "why"),
    [
        ({"m": 1}, "parameter 'm': the mission takes no argument 'm'"),
        ({"seen": True}, "parameter 'seen': the mission takes no argument 'seen'"),
        ({"tarket.x": 1.0}, "parameter 'tarket.x': the mission takes no argument 'tarket'; did you mean 'target'"),
        ({"word": "b"}, "parameter 'word': 'word' is given by --set as well; keep one"),
    ],
)
def test_what_is_no_argument_or_given_twice_is_refused(parameters: dict[str, object], why: str) -> None:
    with pytest.raises(UsageError) as refused:
        arguments_of(parameters, MISSION, {"word": "a"})
    assert str(refused.value).startswith(why)
