# SPDX-License-Identifier: Apache-2.0
"""A fact of the wrong type is reported as it comes, once, and not only where the start is refused for it."""

from __future__ import annotations

import io

from rai_missions.cli.progress import Lines
from rai_missions.engine import Chart
from rai_missions.mission.mission import Mission

MISSION = Mission.model_validate({
    "format": 1, "name": "m", "initial": "a", "states": {"a": {}},
    "blackboard": {"battery": {"type": "number", "source": "robot"}, "at": {"type": "boolean", "source": "robot"}},
})  # fmt: skip


def printed(*, verbose: bool = False) -> str:
    out = io.StringIO()
    lines, chart = Lines(MISSION, out, verbose=verbose), Chart(MISSION)
    for key, value in (("battery", "full"), ("battery", "half"), ("at", 3), ("battery", 0.5)):
        lines.step(chart.write(key, value, 1.0))
    return out.getvalue()


def test_a_fact_of_the_wrong_type_is_reported_at_once_and_once_a_key() -> None:
    first, second = printed().splitlines()
    assert "1.00 s  received and not understood: 'battery' was not written: 'full' is not of type 'number'" in first
    assert "'at' was not written: 3 is not of type 'boolean'" in second


def test_with_verbose_each_is_printed() -> None:
    assert printed(verbose=True).count("was not written") == 3
