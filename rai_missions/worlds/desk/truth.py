# SPDX-License-Identifier: Apache-2.0
"""What is so on the desk: for judges and tests alone; no message and no service gives it away."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.worlds.desk.catalogue import KINDS
from rai_missions.worlds.desk.finger_contacts import TOUCHING_M
from rai_missions.worlds.desk.posture import lean_of, yaw_of
from rai_missions.worlds.desk.scene import object_name
from rai_missions.worlds.desk.scene_file import DeskObject

__all__ = ("DeskTruth", "TrueThing", "truth_of")

REST_M_S, REST_RAD_S = 0.005, 0.1
DESK = "desk"


class TrueThing(NamedTuple):
    """One thing as it is."""

    kind: str
    colour: str
    x: float
    y: float
    z: float
    yaw: float
    lean: float
    """From how it lies by itself, rad."""
    size: tuple[float, float, float]
    at_rest: bool


class DeskTruth(NamedTuple):
    """All things at one moment."""

    at: float
    things: Mapping[str, TrueThing]
    """By the scene's names."""
    contacts: frozenset[tuple[str, str]]
    """Pairs that touch, in the order of the alphabet: names of things, `desk`, or a body of the arm."""
    held: str
    """The thing that both fingers touch; else empty."""

    def touch(self, one: str, other: str) -> bool:
        """Whether two touch."""
        return (min(one, other), max(one, other)) in self.contacts


def truth_of(model: Any, data: Any, objects: Sequence[DeskObject], at: float) -> DeskTruth:
    """Read a simulation."""
    names = {int(model.body(object_name(number)).id): one.name for number, one in enumerate(objects)}
    contacts = frozenset(_contacts(model, data, names))
    held = next((name for name in names.values() if _fingers(name, contacts) >= 2), "")
    things = {one.name: _thing(data, number, one) for number, one in enumerate(objects)}
    return DeskTruth(at, things, contacts, held)


def _contacts(model: Any, data: Any, names: Mapping[int, str]) -> list[tuple[str, str]]:
    found = []
    for contact in data.contact[: data.ncon]:
        bodies = (int(model.geom_bodyid[geom]) for geom in contact.geom)
        one, other = sorted(names.get(body) or (DESK if body == 0 else str(model.body(body).name)) for body in bodies)
        if contact.dist <= TOUCHING_M:
            found.append((one, other))
    return found


def _fingers(name: str, contacts: frozenset[tuple[str, str]]) -> int:
    return len({other for pair in contacts if name in pair for other in pair if "finger" in other})


def _thing(data: Any, number: int, one: DeskObject) -> TrueThing:
    joint = data.joint(object_name(number))
    x, y, z = map(float, joint.qpos[:3])
    axes = data.body(object_name(number)).xmat.reshape(3, 3)
    speeds = [abs(float(speed)) for speed in joint.qvel]
    still = max(speeds[:3]) < REST_M_S and max(speeds[3:]) < REST_RAD_S
    yaw, lean = yaw_of(axes), lean_of(one.kind, axes)
    return TrueThing(one.kind, one.colour, x, y, z, yaw, lean, KINDS[one.kind].size, still)
