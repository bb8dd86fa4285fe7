# SPDX-License-Identifier: Apache-2.0
"""The node under Nav2's lifecycle manager, whose calls are made here one by one.

Source: `LifecycleManager::changeStateForNode` of nav2_lifecycle_manager: a transition by its number, then the state,
which must at once be the one that the transition leads to. A bond is wanted only with a `bond_timeout` above 0.
"""

from __future__ import annotations

import pytest

from tests.node.conftest import Scene
from tests.node.scenes import Client

CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE, SHUTDOWN = 1, 2, 3, 4, 5
WANTED = {
    CONFIGURE: "inactive", CLEANUP: "unconfigured", ACTIVATE: "active", DEACTIVATE: "inactive", SHUTDOWN: "finalized",
}  # fmt: skip
STARTUP, PAUSE, RESUME, RESET = (CONFIGURE, ACTIVATE), (DEACTIVATE,), (ACTIVATE,), (DEACTIVATE, CLEANUP)
STOP = (DEACTIVATE, CLEANUP, SHUTDOWN)


def did(client: Client, *numbers: int) -> bool:
    """Whether the manager would take each of these for done."""
    return all(client.change(number=number) and client.state() == WANTED[number] for number in numbers)


def test_a_node_that_runs_nothing_follows_every_command_of_the_manager(scene: Scene) -> None:
    for command in (STARTUP, PAUSE, RESUME, RESET, STARTUP, STOP):
        assert did(scene.client, *command), (command, scene.client.state())


@pytest.mark.parametrize("moves", [False, True])
def test_pause_and_resume_of_the_manager_pause_and_resume_a_mission(scene: Scene, moves: bool) -> None:
    assert did(scene.client, *STARTUP)
    scene.client.start()
    if moves:
        assert scene.client.command(command="post", event="go")["success"]
        scene.robot.asked.wait(lambda asked: "move" in asked, "the robot moves")
    assert did(scene.client, *PAUSE)
    scene.client.await_status("it is paused", mode="paused")
    assert did(scene.client, *RESUME)
    scene.client.await_status("it runs again", mode="running")


def test_a_reset_while_a_mission_is_under_way_ends_after_the_managers_look(scene: Scene) -> None:
    """The manager takes its reset for failed then, as the guide reports; a mission that has ended is no such case."""
    client = scene.client
    assert did(client, *STARTUP)
    client.start()
    assert client.command(command="post", event="go")["success"]
    scene.robot.asked.wait(lambda asked: "move" in asked, "the robot moves")
    assert did(client, DEACTIVATE) and client.change(number=CLEANUP)
    client.moves.wait(lambda moves: ("transition_success", "unconfigured") in moves, "the mission has ended")
    assert did(client, *STARTUP), "the manager's next startup succeeds"
    client.start()
    assert client.call("cancel")["success"]
    client.statuses.wait(lambda all_: all_[-1]["outcome"] == "canceled", "canceled first")
    assert did(client, *RESET)
