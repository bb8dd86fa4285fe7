# SPDX-License-Identifier: Apache-2.0
"""The mission as a citizen of the robot's graph: a node that other programs start, watch, steer and answer.

Rule: everything travels through a `Connector`, with types by name. Nothing of ROS is known here.

Imports `agents`, `check`, `connectors`, `engine`, `guards`, `journal`, `mission`, `profile`, `runtime` and `states`,
and the modules of the root.
"""

from rai_missions.node.names import NodeName, node_name
from rai_missions.node.node import MissionNode

__all__ = ("MissionNode", "NodeName", "node_name")
