# SPDX-License-Identifier: Apache-2.0
"""How a mission's node is called, and the names below its own."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from rai_missions.errors import UsageError
from rai_missions.redaction import cut_repr

__all__ = ("NodeName", "node_name")

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
NAMESPACE = re.compile(rf"/?(?:{NAME.pattern}(?:/{NAME.pattern})*)?")
REMAPPING = ("-r", "--remap")


class NodeName(NamedTuple):
    """A node's name in its namespace."""

    name: str
    namespace: str = ""
    """Without slashes at its ends; empty for the root."""

    @property
    def path(self) -> str:
        """`/fields/tractor`."""
        return f"/{self.namespace}/{self.name}" if self.namespace else f"/{self.name}"

    def below(self, name: str) -> str:
        """The full name of a node's own (`~/status`)."""
        return f"{self.path}/{name}"


def node_name(given: str, *, namespace: str = "", ros_arguments: Sequence[str] = ()) -> NodeName:
    """The name that a node gets; what `ros2 launch` remaps it to comes first.

    Args:
        given: A name, or a path whose last part is one.
        namespace: Where the path has none.
        ros_arguments: What follows `--ros-args`: `["-r", "__node:=tractor", "-r", "__ns:=/fields"]`.

    Raises:
        UsageError: ROS takes no node of that name.
    """
    before, _, name = given.rpartition("/")
    space = before or namespace
    for word, rule in pairwise(ros_arguments):
        asked, sign, target = rule.partition(":=")
        if word in REMAPPING and sign and asked in ("__node", "__name"):
            name = target
        elif word in REMAPPING and sign and asked == "__ns":
            space = target
    if not NAME.fullmatch(name):
        raise UsageError(
            f"--node {cut_repr(name, 80)}: a node's name has letters, digits and '_', and begins with no digit"
        )
    if not NAMESPACE.fullmatch(space):
        raise UsageError(f"--node: {cut_repr(space, 80)} is no namespace, such as /fields/north")
    return NodeName(name, space.strip("/"))
