# SPDX-License-Identifier: Apache-2.0
"""The node's parameters are the mission's arguments, as a launch file gives them; an unknown one is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rai_missions.errors import UsageError
from rai_missions.node import MissionNode
from tests.node.scenes import Client

OpenNode = Callable[..., MissionNode]


def speed_of(node: MissionNode, client: Client) -> float:
    client.activate()
    client.start()
    assert node.session is not None
    return float(node.session.runner.view.board["speed"].value)


def test_a_parameter_is_an_argument(open_node: OpenNode, open_client: Callable[[str], Client]) -> None:
    node = open_node("given", ros_arguments=["-p", "speed:=2.5", "-p", "use_sim_time:=false"])
    assert speed_of(node, open_client(node.name.path)) == 2.5


def test_a_file_of_parameters_gives_them_by_the_nodes_name(
    open_node: OpenNode, open_client: Callable[[str], Client], tmp_path: Path
) -> None:
    file = tmp_path / "launch_params"
    file.write_text("/**:\n  ros__parameters:\n    speed: 1.5\n/other:\n  ros__parameters:\n    unknown: 1\n")
    node = open_node("filed", ros_arguments=["--params-file", str(file)])
    assert speed_of(node, open_client(node.name.path)) == 1.5


def test_a_parameter_that_is_no_argument_is_refused(open_node: OpenNode) -> None:
    with pytest.raises(
        UsageError, match="parameter 'sped': the mission takes no argument 'sped'; did you mean 'speed'"
    ):
        open_node("refused", ros_arguments=["-p", "sped:=2.5"])
