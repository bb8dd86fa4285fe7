# SPDX-License-Identifier: Apache-2.0
"""Where the robot is, what its map has, and a drive with an end: over every connector, as reported and never better."""

from __future__ import annotations

import importlib.util
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.contract import PatientServer
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.tools.occupancy import MOST_SHOWN, OccupancyGrid, grid_of
from tests.tools.conftest import PATIENCE_S, RepeatingPublisher, ToolRig

GRID, NAVIGATE = "nav_msgs/msg/OccupancyGrid", "nav2_msgs/action/NavigateToPose"
HALF = math.sqrt(0.5)
cells = st.sampled_from([-1, 0, 25, 26, 64, 65, 100])


def message(
    rows: list[list[int]], resolution: float = 0.5, origin: tuple[float, float] = (0.0, 0.0), **turn: float
) -> dict[str, Any]:
    """A map whose first row is its lowest."""
    at = {"position": {"x": origin[0], "y": origin[1], "z": 0.0}}
    orientation = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0, **turn}
    return {
        "header": {"frame_id": "map"},
        "info": {
            "resolution": resolution,
            "width": len(rows[0]),
            "height": len(rows),
            "origin": {**at, "orientation": orientation},
        },
        "data": [cell for row in rows for cell in row],
    }


def kind(cell: int) -> str:
    """The kind of a cell, by nav_msgs and map_server."""
    return "?" if cell < 0 else "#" if cell >= 65 else "." if cell <= 25 else "+"


# ── The map ─────────────────────────────────────────────────────────────────────────────────────────────────────


@st.composite
def maps(draw: Any) -> list[list[int]]:
    width, height = draw(st.sampled_from([1, 3, 40, 41, 97])), draw(st.sampled_from([1, 2, 39, 81]))
    fill = draw(cells)
    rows = [[fill] * width for _ in range(height)]
    for _ in range(draw(st.integers(0, 6))):
        rows[draw(st.integers(0, height - 1))][draw(st.integers(0, width - 1))] = draw(cells)
    return rows


@given(maps(), st.none() | st.tuples(st.integers(-4, 100), st.integers(-4, 90), st.integers(1, 60)))
def test_each_character_is_the_worst_of_its_cells_and_outside_is_unknown(
    rows: list[list[int]], part: tuple[int, int, int] | None
) -> None:
    grid = grid_of(message(rows, resolution=1.0))
    x, y, radius = part or (0, 0, 0)
    low_x, low_y, high_x, high_y = 0, 0, len(rows[0]), len(rows)
    if part:
        low_x, low_y, high_x, high_y = x - radius, y - radius, x + radius, y + radius
        if high_x <= 0 or high_y <= 0 or low_x >= len(rows[0]) or low_y >= len(rows):
            with pytest.raises(UsageError, match="is outside of the map"):
                grid.window((x, y), radius)
            return
    window = grid.window((x, y), radius) if part else grid.window()
    step = round(window.cell_m)
    assert max(len(window.rows), *map(len, window.rows)) <= MOST_SHOWN
    assert window.corner == (low_x, low_y)
    assert len(window.rows) * step >= high_y - low_y and len(window.rows[0]) * step >= high_x - low_x
    for number, row in enumerate(reversed(window.rows)):
        for place, shown in enumerate(row):
            kinds = [
                kind(rows[j][i]) if 0 <= i < len(rows[0]) and 0 <= j < len(rows) else "?"
                for j in range(low_y + number * step, low_y + (number + 1) * step)
                for i in range(low_x + place * step, low_x + (place + 1) * step)
            ]
            assert shown == max(kinds, key=".?+#".index)


def test_a_point_of_a_turned_map_is_found_where_it_is() -> None:
    """A map turned by a quarter: its x axis is the frame's y axis."""
    grid = grid_of(message([[0, 100], [-1, 50]], 0.5, (10.0, 20.0), z=HALF, w=HALF))
    assert [grid.cell_at(9.9, 20.1), grid.cell_at(9.9, 20.6), grid.cell_at(9.4, 20.1), grid.cell_at(9.4, 20.6)] == [
        ".",
        "#",
        "?",
        "+",
    ]
    assert grid.cell_at(10.1, 20.1) == "?", "outside of it"
    assert grid.counts() == {"free": 1, "unknown": 1, "uncertain": 1, "occupied": 1}


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"data": [0]}, "the map has 1 cells, and states 2 × 1"),
        ({"data": [0, 300]}, "is no nav_msgs/msg/OccupancyGrid"),
        ({"data": "ab"}, "is no nav_msgs/msg/OccupancyGrid"),
        ({"info": {}}, "is no nav_msgs/msg/OccupancyGrid"),
        ({"info": {**message([[0, 0]])["info"], "resolution": 0.0}}, "states a resolution of 0.0 m"),
        ({"info": {**message([[0, 0]])["info"], "resolution": math.nan}}, "states a resolution of nan m"),
    ],
)
def test_what_is_no_map_is_refused(change: dict[str, Any], why: str) -> None:
    with pytest.raises(ConnectorError) as refused:
        grid_of({**message([[0, 0]]), **change})
    assert why in str(refused.value)


def test_a_great_map_takes_a_moment_only() -> None:
    """Sixteen million cells; the time limit of a test is the assertion."""
    grid = OccupancyGrid(4000, 4000, 0.05, (0.0, 0.0, 0.0), bytes(16_000_000))
    assert grid.window().rows == ("." * MOST_SHOWN,) * MOST_SHOWN


def test_the_map_of_the_robot_is_shown_around_a_point(tried: ToolRig) -> None:
    rows = [[0] * 30 for _ in range(30)]
    rows[10][20] = 100
    with RepeatingPublisher(tried.connector, "/nav/map", GRID, lambda: message(rows)):
        box = tried.box()
        found = box.navigating.get_occupancy_grid("/nav/map", x=10.2, y=5.2, radius_m=1.0, timeout_s=PATIENCE_S)
        whole = {tool.name: tool for tool in box.tools}["get_occupancy_grid"].invoke(
            {"topic": "/nav/map", "timeout_s": PATIENCE_S}
        )
    assert found.data["at the point"] == "#" and found.data["frame"] == "map"
    assert found.data["rows"] == {"2": ".....", "1.5": ".....", "1": "..#..", "0.5": ".....", "0": "....."}
    assert found.data["lower left corner"] == {"x": 9.0, "y": 4.0}
    assert '"5": "....................#........."' in whole and "more" not in whole, "it is shown uncut"


def test_a_map_that_does_not_come_is_unknown(local: ToolRig) -> None:
    drive = local.box().navigating
    with pytest.raises(ConnectorError, match=r"nothing was received on /map within 0\.01 s; what is so now is unknown"):
        drive.get_occupancy_grid(timeout_s=0.01)
    with pytest.raises(UsageError, match="state both, or neither"):
        drive.get_occupancy_grid(x=1.0)


# ── The robot's pose ────────────────────────────────────────────────────────────────────────────────────────────


POSE = {"position": {"x": 1.5, "y": -2.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": HALF, "w": HALF}}


@pytest.mark.parametrize(
    ("type_name", "pose"),
    [
        ("geometry_msgs/msg/PoseStamped", POSE),
        ("geometry_msgs/msg/PoseWithCovarianceStamped", {"pose": POSE}),
        ("nav_msgs/msg/Odometry", {"pose": POSE}),
    ],
)
def test_the_pose_is_the_one_that_the_robot_publishes(tried: ToolRig, type_name: str, pose: dict[str, Any]) -> None:
    topic = f"/nav/{type_name.rpartition('/')[2]}"
    with RepeatingPublisher(tried.connector, topic, type_name, lambda: {"header": {"frame_id": "odom"}, "pose": pose}):
        found = tried.box().navigating.get_robot_pose(topic=topic, timeout_s=PATIENCE_S).data
    assert (found["frame"], found["x"], found["y"]) == ("odom", 1.5, -2.0)
    assert found["yaw"] == pytest.approx(math.pi / 2) and found["age_s"] is not None


def test_without_a_topic_the_pose_comes_from_the_transforms(local: ToolRig) -> None:
    moved = {"translation": {"x": 3.0, "y": 4.0, "z": 0.0}, "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    header = {"frame_id": "map", "stamp": {"sec": 1, "nanosec": 0}}
    sent = {"transforms": [{"header": header, "child_frame_id": "base_link", "transform": moved}]}
    with RepeatingPublisher(local.connector, "/tf", "tf2_msgs/msg/TFMessage", lambda: sent):
        found = local.box().navigating.get_robot_pose(timeout_s=PATIENCE_S).data
    assert (found["frame"], found["x"], found["y"], found["yaw"]) == ("map", 3.0, 4.0, 0.0)


@pytest.mark.parametrize("sent", [{}, {"header": {"frame_id": "m"}, "pose": 3}, {"header": {}, "pose": POSE}])
def test_what_is_no_pose_is_refused(local: ToolRig, sent: dict[str, Any]) -> None:
    with (
        RepeatingPublisher(local.connector, "/pose", "", lambda: sent),
        pytest.raises(ConnectorError, match="holds no pose"),
    ):
        local.box().navigating.get_robot_pose(topic="/pose", timeout_s=PATIENCE_S)


# ── Driving ─────────────────────────────────────────────────────────────────────────────────────────────────────


class Accepting(PatientServer):
    """Takes every goal at once."""

    def __init__(self) -> None:
        super().__init__()
        self.wanted: list[Any] = []

    def accept(self, goal_id: str, goal: Any, report: Any) -> None:
        super().accept(goal_id, goal, report)
        self.wanted.append(goal)
        self.send(goal_id, "accepted")


def test_a_drive_is_a_goal_with_an_id_and_an_end(tried: ToolRig) -> None:
    if "actions" not in tried.connector.modes:
        pytest.skip("it carries no actions")
    if not isinstance(tried.connector, LocalConnector) and importlib.util.find_spec("nav2_msgs") is None:
        pytest.skip("nav2_msgs is not built: make ros-interfaces")
    server, box = Accepting(), tried.box()
    close = tried.connector.offer("/navigate_to_pose", NAVIGATE, server)
    tools = {tool.name: tool for tool in box.tools}
    asked = {"x": 2.0, "y": 3.0, "yaw": math.pi / 2, "timeout_s": PATIENCE_S}
    answered = tools["navigate_to_pose"].invoke(asked)
    (goal,), (listed,) = server.wanted, box.acting.list_goals().data["goals"]
    pose = goal["pose"]["pose"]
    assert goal["pose"]["header"]["frame_id"] == "map"
    assert (pose["position"]["x"], pose["position"]["y"]) == (2.0, 3.0)
    assert (pose["orientation"]["z"], pose["orientation"]["w"]) == pytest.approx((HALF, HALF))
    assert listed["goal_id"] in answered and (listed["action"], listed["state"]) == ("/navigate_to_pose", "running")
    server.send(listed["goal_id"], "succeeded")
    assert box.acting.watch_action(listed["goal_id"], timeout_s=PATIENCE_S).data["state"] == "succeeded"
    assert box.acting.list_goals(only_running=True).data == {"goals": [], "running": 0}
    assert "1 goals were started here, of which 0 are not over" in tools["list_goals"].invoke({})
    close()


def test_a_model_drives_only_where_the_action_may_be_written(local: ToolRig) -> None:
    tools = {tool.name: tool for tool in local.box(write=()).tools}
    assert "'/navigate_to_pose' may not be written" in tools["navigate_to_pose"].invoke({"x": 1, "y": 2})
    assert "x: " in tools["navigate_to_pose"].invoke({"x": math.inf, "y": 2})
    assert {"get_robot_pose", "get_occupancy_grid", "list_goals"} <= {tool.name for tool in local.box().read_only}
