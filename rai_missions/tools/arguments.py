# SPDX-License-Identifier: Apache-2.0
"""What each tool takes, described for models."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

__all__ = (
    "CallService",
    "CancelAction",
    "DescribeType",
    "GetDistanceToObjects",
    "GetImage",
    "GetOccupancyGrid",
    "GetRobotPose",
    "GetTransform",
    "List",
    "ListGoals",
    "NavigateToPose",
    "PublishMessage",
    "Recall",
    "ReceiveMessage",
    "StartAction",
    "WatchAction",
)  # fmt: skip

LONGEST = 255
WAIT = "How long to wait for it, in seconds; 0 to 60."
Name = Annotated[str, Field(min_length=1, max_length=LONGEST)]
Timeout = Annotated[float, Field(ge=0, le=60, allow_inf_nan=False, description=WAIT)]
Age = Annotated[float | None, Field(ge=0, allow_inf_nan=False)]
TypeName = Annotated[
    str, Field(max_length=LONGEST, description="Its type, 'std_msgs/msg/String'; empty: found out from the robot.")
]
Metres = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]
Fields = dict[str, Any]


class Arguments(BaseModel):
    model_config = ConfigDict(extra="forbid")


class List(Arguments):
    containing: str = Field("", max_length=LONGEST, description="Only names with this text in them.")


class DescribeType(Arguments):
    type_name: Name = Field(
        description="'std_msgs/msg/String', 'std_srvs/srv/Trigger' or 'nav2_msgs/action/NavigateToPose'."
    )


class ReceiveMessage(Arguments):
    topic: Name = Field(description="The topic's whole name, such as '/tractor1/battery'.")
    field: str = Field("", max_length=LONGEST, description="Only this field of it, such as 'pose.position.x'.")
    max_age_s: Age = Field(None, description="The oldest that will do, in seconds; wait for a newer one.")
    timeout_s: Timeout = 2.0
    type_name: TypeName = ""


class GetImage(Arguments):
    topic: Name = Field(description="The camera's topic, of sensor_msgs/msg/Image or CompressedImage.")
    max_age_s: Age = Field(None, description="The oldest that will do, in seconds; wait for a newer one.")
    timeout_s: Timeout = 5.0
    type_name: TypeName = ""


class PublishMessage(Arguments):
    topic: Name = Field(description="The topic's whole name.")
    message: Fields = Field(description="The message's fields by name; what is left out keeps its default.")
    type_name: TypeName = ""
    timeout_s: Timeout = 2.0


class CallService(Arguments):
    service: Name = Field(description="The service's whole name, such as '/tractor1/flash'.")
    request: Fields = Field(default_factory=dict, description="The request's fields by name.")
    timeout_s: Timeout = 5.0
    type_name: TypeName = ""


class StartAction(Arguments):
    action: Name = Field(description="The action's whole name, such as '/navigate_to_pose'.")
    goal: Fields = Field(default_factory=dict, description="The goal's fields by name.")
    timeout_s: Timeout = 5.0
    type_name: TypeName = ""


class WatchAction(Arguments):
    goal_id: Name = Field(description="The id that the start gave.")
    timeout_s: Timeout = Field(0.0, description="How long to wait for its end, in seconds; 0 to 60.")


class ListGoals(Arguments):
    only_running: bool = Field(False, description="Only those that are not over.")


class CancelAction(Arguments):
    goal_id: Name = Field(description="The id that the start gave.")
    timeout_s: Timeout = 5.0


class GetTransform(Arguments):
    target: Name = Field(description="The frame in which the answer is reported, such as 'map'.")
    source: Name = Field(description="The frame whose pose is asked for, such as 'base_link'.")
    at_s: float | None = Field(
        None, allow_inf_nan=False, description="When, in seconds, as the stamps of messages state; empty: the newest."
    )
    max_age_s: Age = Field(None, description="The oldest that will do, in seconds.")
    timeout_s: Timeout = 2.0


class GetDistanceToObjects(Arguments):
    detections_topic: Name = Field(description="Where a detector reports what it sees: boxes with names.")
    depth_topic: str = Field("", max_length=LONGEST, description="A depth image's topic; this or cloud_topic.")
    cloud_topic: str = Field("", max_length=LONGEST, description="A point cloud's topic; this or depth_topic.")
    camera_info_topic: str = Field("", max_length=LONGEST, description="The camera's calibration; for a depth image.")
    names: list[str] = Field(default_factory=list, max_length=100, description="Only objects with these names.")
    max_age_s: Age = Field(2.0, description="The oldest that will do, in seconds.")
    max_apart_s: float = Field(0.5, ge=0, le=60, description="How far apart in time detections and depth may be.")
    timeout_s: Timeout = 5.0


class GetRobotPose(Arguments):
    topic: str = Field(
        "",
        max_length=LONGEST,
        description="Where the robot publishes its pose, such as '/amcl_pose' or '/odom'; empty: from the transforms.",
    )
    frame: Name = Field("map", description="Without a topic: the frame in which the pose is reported.")
    robot_frame: Name = Field("base_link", description="Without a topic: the robot's own frame.")
    max_age_s: Age = Field(None, description="The oldest that will do, in seconds.")
    timeout_s: Timeout = 2.0


class GetOccupancyGrid(Arguments):
    topic: Name = Field("/map", description="The map's topic, of nav_msgs/msg/OccupancyGrid.")
    x: Metres | None = Field(None, description="Only around this point of the map's frame, in metres; with y.")
    y: Metres | None = Field(None, description="Its other coordinate.")
    radius_m: float = Field(5.0, gt=0, le=1e6, description="Around the point: half of the side shown, in metres.")
    max_age_s: Age = Field(None, description="The oldest that will do, in seconds.")
    timeout_s: Timeout = 5.0


class NavigateToPose(Arguments):
    x: Metres = Field(description="Where to, in metres of the frame.")
    y: Metres = Field(description="Its other coordinate.")
    yaw: float = Field(0.0, ge=-7, le=7, allow_inf_nan=False, description="The heading there, in radians.")
    frame: Name = Field("map", description="The frame of x, y and yaw.")
    action: Name = Field("/navigate_to_pose", description="The action's whole name.")
    timeout_s: Timeout = Field(5.0, description="How long its server may take to accept it, in seconds; 0 to 60.")


class Recall(Arguments):
    question: str = Field(min_length=1, max_length=500, description="A question in plain English, about one subject.")
    count: int = Field(5, ge=1, le=10, description="How many passages at most.")
