# SPDX-License-Identifier: Apache-2.0
"""`rai-missions gate` reports who else commands the actuators."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from tests.tractor.ros2_processes import Graph, graph_in


@pytest.mark.long
def test_a_node_that_commands_past_the_gate_and_another_gate_are_reported(tmp_path: Path) -> None:
    for graph in graph_in(tmp_path, Graph):
        words = ("gate", "--ros")
        first = graph.start(*words)
        first.wait_for("guards /cmd_vel")
        second = graph.start(*words, "--name", "/other")
        assert "past this gate" in first.wait_for("another node publishes on /cmd_vel as well")
        assert "/other/{autonomy,agent,operator}/cmd_vel" in second.wait_for(
            "another node publishes on /cmd_vel as well"
        )
        for each in (first, second):
            each.signal(signal.SIGINT)
            assert each.ends() == 0
