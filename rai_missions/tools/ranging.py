# SPDX-License-Identifier: Apache-2.0
"""How far away detected objects are: boxes in a camera's picture, and the depth image or point cloud there.

Rule: pure. What has too few valid measurements is unknown, never a guess; NaN, infinity and zero are no measurements.

Source: sensor_msgs/msg/Image (REP 118: 16UC1 in millimetres, 32FC1 in metres), CameraInfo, PointCloud2.
"""

from __future__ import annotations

import math
import statistics
import struct
import sys
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.errors import ConnectorError
from rai_missions.redaction import cut_repr
from rai_missions.tools.transforms import Transform, Vector

__all__ = ("PinholeCamera", "Range", "camera_of", "cloud_points", "depth_points", "ranged")

Sample = tuple[float, float, Vector]
"""Column, row, and the point in the camera's optical frame (x right, y down, z ahead), in metres."""
LEAST = 10
"""Valid measurements in a box below which its distance is unknown."""
LEAST_SHARE = 0.02
"""The share of valid measurements below which a box's distance is unknown."""
MIDDLE = 0.6
"""The share of a box's width and height, around its middle, that is looked at: its edges show what is behind."""
LARGEST = 20_000_000
"""Pixels or points that are read."""
DEPTHS = {"16UC1": ("H", 0.001), "mono16": ("H", 0.001), "32FC1": ("f", 1.0)}
NUMBERS = {1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f", 8: "d"}
"""sensor_msgs/msg/PointField's datatypes, as `struct` calls them."""


class PinholeCamera(NamedTuple):
    """A pinhole camera, in pixels of its picture; lenses that bend are not undone."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def ray(self, column: float, row: float, depth_m: float) -> Vector:
        """The point seen in a pixel at a depth."""
        return ((column - self.cx) / self.fx * depth_m, (row - self.cy) / self.fy * depth_m, depth_m)

    def pixel(self, point: Vector) -> tuple[float, float] | None:
        """Where a point is seen; None behind the camera."""
        x, y, z = point
        return (self.fx * x / z + self.cx, self.fy * y / z + self.cy) if z > 0 else None


class Range(NamedTuple):
    """How far away a box's object is."""

    distance_m: float | None
    """From the camera to the object; None: unknown."""
    position: Vector | None = None
    """In the camera's optical frame, metres."""
    measurements: int = 0
    why: str = ""
    """Why it is unknown."""


def camera_of(info: Mapping[str, Any]) -> PinholeCamera:
    """The camera of a sensor_msgs/msg/CameraInfo.

    Raises:
        ConnectorError: It is none, or not calibrated.
    """
    try:
        k = [float(each) for each in info["k"]]
        camera = PinholeCamera(int(info["width"]), int(info["height"]), k[0], k[4], k[2], k[5])
    except (KeyError, TypeError, ValueError, IndexError) as fault:
        raise ConnectorError(f"{cut_repr(info, 80)} is no sensor_msgs/msg/CameraInfo: {cut_repr(fault, 60)}") from None
    if not (camera.fx > 0 and camera.fy > 0 and all(map(math.isfinite, camera[2:])) and min(camera[:2]) > 0):
        raise ConnectorError(f"the camera is not calibrated: {camera}")
    return camera


def depth_points(image: Mapping[str, Any], camera: PinholeCamera, box: Sequence[float]) -> tuple[list[Sample], int]:
    """The points that a depth image shows in the middle of a box, and how many pixels were looked at.

    Args:
        image: A sensor_msgs/msg/Image of the same view as the camera's; of another size, it is scaled.
        camera: Whose pixels the box is reported in.
        box: Left, top, right, bottom.

    Raises:
        ConnectorError: It is no depth image.
    """
    width, height, rows = _depths(image)
    across, down = width / camera.width, height / camera.height
    left, top, right, bottom = _middle(box)
    samples, looked_at = [], 0
    columns = _pixels(left * across, right * across, width)
    for row in _pixels(top * down, bottom * down, height):
        depths = rows(row)
        looked_at += len(columns)
        for column in columns:
            depth_m = depths[column]
            if 0 < depth_m < math.inf:
                seen = ((column + 0.5) / across - 0.5, (row + 0.5) / down - 0.5)
                samples.append((*seen, camera.ray(*seen, depth_m)))
    return samples, looked_at


def _depths(image: Mapping[str, Any]) -> tuple[int, int, Any]:
    """Width, height, and what gives a row's depths in metres."""
    width, height, step, encoding = (image.get(word) for word in ("width", "height", "step", "encoding"))
    if str(encoding) not in DEPTHS:
        raise ConnectorError(f"a depth image is in {', '.join(DEPTHS)}, not in {cut_repr(encoding, 40)}")
    code, scale = DEPTHS[str(encoding)]
    size = struct.calcsize(code)
    if not isinstance(width, int) or not isinstance(height, int) or not 0 < width * height <= LARGEST:
        raise ConnectorError(f"a depth image of {cut_repr(width, 20)} × {cut_repr(height, 20)} pixels")
    data, line = _bytes(image.get("data")), step if isinstance(step, int) and step else width * size
    if line < width * size or len(data) < line * height:
        raise ConnectorError(f"a depth image of {width} × {height} in {encoding} needs more than its {len(data)} bytes")
    swapped = bool(image.get("is_bigendian")) != (sys.byteorder == "big")

    def row(number: int) -> list[float]:
        values = array(code, bytes(data[number * line : number * line + width * size]))
        if swapped:
            values.byteswap()
        return [value * scale for value in values]

    return width, height, row


def cloud_points(
    cloud: Mapping[str, Any], camera: PinholeCamera | None, box: Sequence[float], to_camera: Transform | None = None
) -> tuple[list[Sample], int]:
    """The points of a cloud in the middle of a box, and how many were to be expected there.

    Args:
        cloud: A sensor_msgs/msg/PointCloud2; one with rows has a point for each pixel of the picture.
        camera: By which a cloud without rows is seen; may be left out for one with rows.
        box: Left, top, right, bottom, in pixels of the picture.
        to_camera: From the cloud's frame to the camera's optical frame; left out, they are the same.

    Raises:
        ConnectorError: It is no cloud, or it has no rows and there is no camera.
    """
    width, height = cloud.get("width"), cloud.get("height")
    if not isinstance(width, int) or not isinstance(height, int) or not 0 <= width * height <= LARGEST:
        raise ConnectorError(f"a point cloud of {cut_repr(width, 20)} × {cut_repr(height, 20)} points")
    left, top, right, bottom = _middle(box)
    if height > 1:
        across, down = (width / camera.width, height / camera.height) if camera else (1.0, 1.0)
        columns, rows = _pixels(left * across, right * across, width), _pixels(top * down, bottom * down, height)
        seen: Iterable[tuple[int, int]] = ((row, column) for row in rows for column in columns)
        found = [(float(place[1]), float(place[0]), point) for place, point in _points(cloud, seen)]
        return [(u, v, _moved(to_camera, point)) for u, v, point in found], len(rows) * len(columns)
    if camera is None:
        raise ConnectorError("a point cloud without rows is seen through a camera: state its camera_info topic")
    samples = []
    for _, point in _points(cloud, ((0, column) for column in range(width))):
        moved = _moved(to_camera, point)
        pixel = camera.pixel(moved)
        if pixel is not None and left <= pixel[0] <= right and top <= pixel[1] <= bottom:
            samples.append((*pixel, moved))
    return samples, 0


def _moved(transform: Transform | None, point: Vector) -> Vector:
    return point if transform is None else transform.point(point)


def _points(cloud: Mapping[str, Any], places: Iterable[tuple[int, int]]) -> Iterator[tuple[tuple[int, int], Vector]]:
    """The valid points at these rows and columns."""
    try:
        fields = {str(each["name"]): (int(each["offset"]), NUMBERS[int(each["datatype"])]) for each in cloud["fields"]}
        (x_at, x_code), (y_at, y_code), (z_at, z_code) = (fields[axis] for axis in "xyz")
        step, line = int(cloud["point_step"]), int(cloud["row_step"])
    except (KeyError, TypeError, ValueError) as fault:
        raise ConnectorError(f"a point cloud without numbers x, y and z: {cut_repr(fault, 80)}") from None
    data, order = _bytes(cloud.get("data")), ">" if cloud.get("is_bigendian") else "<"
    read = [
        (struct.Struct(order + code).unpack_from, at) for code, at in ((x_code, x_at), (y_code, y_at), (z_code, z_at))
    ]
    try:
        for place in places:
            start = place[0] * line + place[1] * step
            x, y, z = (unpack(data, start + at)[0] for unpack, at in read)
            if math.isfinite(x) and math.isfinite(y) and math.isfinite(z) and (x or y or z):
                yield place, (float(x), float(y), float(z))
    except struct.error:
        raise ConnectorError(f"a point cloud needs more than its {len(data)} bytes") from None


def ranged(samples: Sequence[Sample], looked_at: int) -> Range:
    """The distance of a box's object: the median of what was measured in it.

    Args:
        samples: The valid measurements.
        looked_at: How many there could be; 0 where no one knows.
    """
    least = max(LEAST, math.ceil(looked_at * LEAST_SHARE)) if looked_at >= LEAST else max(1, looked_at)
    if not looked_at:
        least = LEAST
    if len(samples) < least:
        return Range(None, None, len(samples), f"only {len(samples)} valid measurements; {least} are needed")
    distance_m = statistics.median(math.hypot(*point) for _, _, point in samples)
    x, y, z = (statistics.median(point[axis] for _, _, point in samples) for axis in range(3))
    return Range(distance_m, (x, y, z), len(samples))


def _middle(box: Sequence[float]) -> tuple[float, float, float, float]:
    left, top, right, bottom = box
    aside, above = (right - left) * (1 - MIDDLE) / 2, (bottom - top) * (1 - MIDDLE) / 2
    return left + aside, top + above, right - aside, bottom - above


def _pixels(first: float, last: float, size: int) -> range:
    """The pixels whose middles lie between two edges, at least the one in between, inside the picture."""
    begin, end = math.ceil(first - 0.5), math.floor(last - 0.5)
    if end < begin:
        begin = end = math.floor((first + last) / 2)
    return range(max(0, begin), min(size - 1, end) + 1)


def _bytes(data: Any) -> bytes:
    if isinstance(data, bytes | bytearray | memoryview):
        return bytes(data)
    if isinstance(data, array):
        return data.tobytes()
    try:
        return bytes(data)
    except (TypeError, ValueError):
        raise ConnectorError(f"{cut_repr(data, 40)} is given where bytes belong") from None
