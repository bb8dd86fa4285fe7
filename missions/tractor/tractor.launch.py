# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="import-not-found"
"""Starts the tractor's mission as a node of ROS 2: `ros2 launch missions/tractor/tractor.launch.py`.

With `managed:=true` it waits to be configured and activated, and runs the mission whenever it is asked to.
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import FindExecutable, LaunchConfiguration
from launch_ros.actions import LifecycleNode, Node
from launch_ros.parameter_descriptions import ParameterValue

HERE = Path(__file__).resolve().parent
MISSION = HERE / "mission.json"
PROFILE = HERE / "robot.ros2.json"


def generate_launch_description() -> LaunchDescription:
    """The mission's node, under a name that other launch files can remap."""
    name, program = LaunchConfiguration("name"), FindExecutable(name="rai-missions")
    words = ["run", LaunchConfiguration("mission"), "--robot", LaunchConfiguration("robot")]
    words += ["--node"]
    arguments = [{"alleys": ParameterValue(LaunchConfiguration("alleys"), value_type=int)}]  # the mission's
    return LaunchDescription(
        [
            DeclareLaunchArgument("mission", default_value=str(MISSION), description="the mission's file"),
            DeclareLaunchArgument("robot", default_value=str(PROFILE), description="the robot profile"),
            DeclareLaunchArgument("alleys", default_value="6", description="how many alleys are worked"),
            DeclareLaunchArgument("name", default_value="tractor_mission", description="the node's name"),
            DeclareLaunchArgument("managed", default_value="false", description="wait for lifecycle commands"),
            Node(
                executable=program,
                name=name,
                arguments=words,
                parameters=arguments,
                output="screen",
                on_exit=Shutdown(),  # one run, and it is over
                condition=UnlessCondition(LaunchConfiguration("managed")),
            ),
            LifecycleNode(
                package=None,
                executable=program,
                name=name,
                namespace="",
                arguments=[*words, "--managed"],
                parameters=arguments,
                output="screen",
                condition=IfCondition(LaunchConfiguration("managed")),
            ),
        ]
    )
