# SPDX-License-Identifier: Apache-2.0
"""Where everything stands in the house: walls, doors, furniture, and the places that have a name.

Lengths in metres; the origin is the south-west corner, x goes east, y north. Five rooms: four in a ring, so that a
closed door leaves a way round, and a pantry with one door.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

__all__ = (
    "CRATE", "DEPTH_M", "DOORS", "FURNITURE", "PLACES", "ROOMS", "SPOTS", "WALLS", "WIDTH_M", "Box", "NamedPose",
    "Spot",
)  # fmt: skip

WIDTH_M, DEPTH_M = 10.0, 8.0


class Box(NamedTuple):
    """An upright box on the floor: its corners and how high it is."""

    west: float
    south: float
    east: float
    north: float
    height: float = 2.5
    colour: str = ".91 .89 .84"

    @property
    def middle(self) -> tuple[float, float]:
        return (self.west + self.east) / 2, (self.south + self.north) / 2


class NamedPose(NamedTuple):
    """A pose with a name."""

    x: float
    y: float
    heading: float = 0.0
    """rad, 0 looks east, counter-clockwise."""


WALLS: tuple[Box, ...] = (
    Box(0, 0, 10, 0.1),
    Box(0, 7.9, 10, 8),
    Box(0, 0, 0.1, 8),
    Box(9.9, 0, 10, 8),
    Box(5, 0, 5.1, 1.2),
    Box(5, 2.2, 5.1, 5.4),
    Box(5, 6.4, 5.1, 8),
    Box(0, 4.1, 1, 4.2),
    Box(2, 4.1, 5.8, 4.2),
    Box(6.8, 4.1, 10, 4.2),
    Box(7.6, 0, 7.7, 1.5),
    Box(7.6, 2.5, 7.7, 4.1),
)

DOORS: Mapping[str, tuple[float, float]] = {
    "kitchen_living": (1.5, 4.15),
    "kitchen_study": (5.05, 1.7),
    "living_bedroom": (5.05, 5.9),
    "bedroom_study": (6.3, 4.15),
    "study_pantry": (7.65, 2.0),
}
"""The middle of each doorway, a metre wide, called by the rooms that it joins."""

CRATE = 0.4, 0.4, 0.3
"""Half the size of what stands in a blocked doorway: too wide to pass by."""

FURNITURE: Mapping[str, Box] = {
    "sofa": Box(0.1, 6.6, 0.9, 7.9, 0.8, ".25 .35 .55"),
    "low table": Box(2.4, 5.6, 3.2, 6.4, 0.45, ".55 .38 .22"),
    "bookcase": Box(3.6, 7.5, 4.9, 7.9, 1.5, ".45 .3 .18"),
    "fridge": Box(0.1, 0.1, 0.7, 0.8, 1.7, ".85 .87 .88"),
    "table": Box(2.4, 1.2, 3.4, 2.0, 0.74, ".6 .45 .28"),
    "bed": Box(8.0, 5.8, 9.9, 7.4, 0.6, ".7 .68 .75"),
    "desk": Box(5.1, 2.7, 5.6, 3.7, 0.75, ".5 .35 .2"),
    "shelf": Box(9.4, 0.1, 9.9, 2.6, 1.8, ".75 .72 .65"),
}
"""What is on the map, by name."""

ROOMS: Mapping[str, Box] = {
    "kitchen": Box(0.1, 0.1, 5.0, 4.1),
    "living room": Box(0.1, 4.2, 5.0, 7.9),
    "bedroom": Box(5.1, 4.2, 9.9, 7.9),
    "study": Box(5.1, 0.1, 7.6, 4.1),
    "pantry": Box(7.7, 0.1, 9.9, 4.1),
}
"""Where each room is."""


class Spot(NamedTuple):
    """A place for an object: near an edge that the robot's camera can see from the floor."""

    x: float
    y: float
    height: float
    """Of what it is on, above the floor; 0 is the floor itself."""


SPOTS: Mapping[str, Spot] = {
    "table_north": Spot(2.6, 1.88, 0.74),
    "table_corner": Spot(3.24, 1.86, 0.74),
    "low_table_north": Spot(2.62, 6.3, 0.45),
    "low_table_west": Spot(2.5, 6.02, 0.45),
    "sofa_south": Spot(0.8, 6.95, 0.8),
    "sofa_north": Spot(0.8, 7.5, 0.8),
    "bed_south": Spot(8.1, 6.2, 0.6),
    "bed_north": Spot(8.1, 6.95, 0.6),
    "desk_south": Spot(5.52, 2.95, 0.75),
    "desk_north": Spot(5.52, 3.45, 0.75),
    "kitchen_floor": Spot(4.5, 0.5, 0.0),
    "living_room_floor": Spot(4.4, 4.7, 0.0),
    "bedroom_floor": Spot(5.6, 7.4, 0.0),
    "pantry_floor": Spot(8.3, 0.6, 0.0),
}

PLACES: Mapping[str, NamedPose] = {
    "dock": NamedPose(0.6, 2.6),
    "kitchen": NamedPose(3.9, 3.1),
    "living_room": NamedPose(1.8, 6.9, 1.57),
    "bedroom": NamedPose(7.2, 6.6),
    "study": NamedPose(6.2, 0.9, -1.57),
    "pantry": NamedPose(8.7, 3.2),
}
