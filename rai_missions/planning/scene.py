# SPDX-License-Identifier: Apache-2.0
"""What is seen on the desk: things with their poses and extents, as the robot's fact `objects` has them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, PlainSerializer, model_validator

from rai_missions.errors import DefinitionError, UsageError, suggestion
from rai_missions.model import Bool, Integer, MissionModel, Number, Text, fault
from rai_missions.model.validation_errors import validated
from rai_missions.planning.geometry import Footprint, box, disc

__all__ = ("CONTAINERS", "DESK", "ROUND", "Scene", "Thing", "ThingType", "has_colour", "judged_by", "read_scene")

DESK = "desk"
"""The name of what carries everything; no thing may have it."""
ThingType = Literal["cube", "apple", "tomato", "carrot", "corn", "tray", "bin"]
CONTAINERS = frozenset({"tray", "bin"})
"""Types that hold things inside."""
ROUND = frozenset({"apple", "tomato", "carrot", "corn"})
"""Types on which nothing can rest."""
BALLS = frozenset({"apple", "tomato"})
"""Types whose footprint is a disc."""
COLOURS: Mapping[str, frozenset[str]] = {
    "apple": frozenset({"red", "green", "yellow"}),
    "tomato": frozenset({"red"}),
    "carrot": frozenset({"orange"}),
    "corn": frozenset({"yellow"}),
}
"""Types → the colours that they may have, where what is seen does not name one; other types may have any."""
AGREEING = 3
"""Looks that must agree on a thing's class before it counts."""
MOST = 100
"""Things of a scene at the most."""
Coordinate = Annotated[Number, Field(ge=-100, le=100)]
Extent = Annotated[Number, Field(gt=0, le=2)]


@lru_cache(maxsize=4096)
def _footprint(is_ball: bool, x: float, y: float, size: tuple[float, float], yaw: float) -> Footprint:
    return disc(x, y, max(size) / 2) if is_ball else box(x, y, size, yaw)


class Thing(MissionModel):
    """One thing as the camera measured it."""

    # A fact may have more fields than are used here.
    model_config = ConfigDict(extra="ignore")

    name: Annotated[Text, Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=64)]
    """Its own: `red_cube_2`."""
    type: ThingType
    """Its class."""
    colour: Text = ""
    """Empty where it is not known."""
    x: Coordinate
    """Of its centre, metres."""
    y: Coordinate
    """Of its centre, metres."""
    z: Coordinate
    """Of its centre, metres above the desk's top."""
    yaw: Number = 0.0
    """Of its own x axis, radians, counter-clockwise seen from above."""
    size: Annotated[tuple[Extent, Extent, Extent], PlainSerializer(list)]
    """Extents along its own axes, metres."""
    sigma_m: Annotated[Number, Field(ge=0, le=1)]
    """The standard deviation of its measured position, metres."""
    looks: Annotated[Integer, Field(ge=0)] = 0
    """How often it was looked at."""
    agreeing: Annotated[Integer, Field(ge=0)] = 0
    """How many of the looks agree on its class."""
    at_rest: Bool
    """Whether it does not move."""

    def __init__(
        self,
        name: str,
        type: ThingType,
        x: float,
        y: float,
        z: float,
        *,
        size: tuple[float, float, float],
        sigma_m: float,
        at_rest: bool,
        yaw: float = 0.0,
        colour: str = "",
        looks: int = 0,
        agreeing: int = 0,
    ) -> None: ...

    @property
    def bottom(self) -> float:
        """The height of its lowest point, metres."""
        return self.z - self.size[2] / 2

    @property
    def top(self) -> float:
        """The height of its highest point, metres."""
        return self.z + self.size[2] / 2

    @property
    def is_certain(self) -> bool:
        """Whether enough looks agree on its class."""
        return self.agreeing >= AGREEING

    @property
    def footprint(self) -> Footprint:
        """What it covers of the plane below it."""
        return _footprint(self.type in BALLS, self.x, self.y, self.size[:2], self.yaw)

    def moved(self, x: float, y: float, z: float, yaw: float | None = None) -> Thing:
        """A copy of the thing, elsewhere."""
        return self.model_copy(update={"x": x, "y": y, "z": z, "yaw": self.yaw if yaw is None else yaw})


class Scene(MissionModel):
    """All that is seen, and what the gripper holds."""

    model_config = ConfigDict(extra="ignore")

    things: Annotated[tuple[Thing, ...], Field(max_length=MOST), PlainSerializer(list)]
    """Each with a name of its own."""
    gripper: Literal["empty", "holding", "unknown"] = "unknown"
    """What is in the gripper, by the gripper."""
    looks: Annotated[Integer, Field(ge=0)] = 0
    """How often the camera looked since anything moved."""
    stamp_s: Number = 0.0
    """The time of the last picture used, seconds."""

    def __init__(
        self, things: tuple[Thing, ...], gripper: str = "unknown", *, looks: int = 0, stamp_s: float = 0.0
    ) -> None: ...

    @model_validator(mode="after")
    def _named_once(self) -> Scene:
        names = [thing.name for thing in self.things]
        for name in names:
            if name == DESK:
                raise fault("name", f"a thing cannot be called '{DESK}': it is what carries all of them")
            if names.count(name) > 1:
                raise fault("name", f"two things are called '{name}'; number them, as in '{name}_2'")
        return self

    @property
    def by_name(self) -> Mapping[str, Thing]:
        """Name → thing, in the order seen."""
        return {thing.name: thing for thing in self.things}

    def thing(self, name: str) -> Thing:
        """The thing of a name.

        Raises:
            UsageError: It is not seen.
        """
        found = self.get(name)
        if found is None:
            raise UsageError(f"no '{name}' is seen{suggestion(name, self.by_name)}")
        return found

    def get(self, name: str) -> Thing | None:
        """The thing of a name; None where it is not seen."""
        return next((thing for thing in self.things if thing.name == name), None)


def read_scene(data: Any) -> Scene:
    """A scene from plain data, as the fact `objects` has it.

    Raises:
        DefinitionError: With every fault, each with its JSON pointer.
    """
    if isinstance(data, Scene):
        return data
    return validated(Scene, data)


def has_colour(thing: Thing, colour: str) -> bool | None:
    """Whether a thing has a colour; None where that is not known. Without a colour it is true."""
    if thing.colour or not colour:
        return thing.colour == colour or not colour
    return None if colour in COLOURS.get(thing.type, (colour,)) else False


def judged_by(data: Any) -> str:
    """All that goals are judged by of what is seen: the same for two sights that differ in looks and stamp alone."""
    try:
        scene = read_scene(data)
    except DefinitionError:
        return repr(data)
    return scene.model_copy(update={"looks": 0, "stamp_s": 0.0}).model_dump_json()
