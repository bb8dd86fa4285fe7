# SPDX-License-Identifier: Apache-2.0
"""Where frames lie to each other over the last seconds: a tree of frames received from /tf and /tf_static.

Rule: nothing here knows a connector. Between two received instants a transform is interpolated; outside of what was
received there is none.

Source: tf2_msgs/msg/TFMessage; tf2's TimeCache (linear in translation, spherical in rotation).
"""

from __future__ import annotations

import math
import threading
from bisect import bisect_left, insort
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import cut_repr

__all__ = ("Frames", "Quaternion", "Transform", "TransformLookup", "Vector", "planar", "product", "stamp_of", "yaw_of")

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""x, y, z, w."""
KEEP_S = 10.0
MOST = 2_000
"""Instants that are kept of one frame, and frames that are kept."""
UNIT = 0.1
"""How far a rotation's length may be from one."""


class Transform(NamedTuple):
    """The pose of one frame in another: takes a point of the one to the other."""

    translation: Vector = (0.0, 0.0, 0.0)
    """Metres."""
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    def __matmul__(self, inner: Transform) -> Transform:
        """First `inner`, then this."""
        return Transform(self.point(inner.translation), product(self.rotation, inner.rotation))

    def point(self, point: Vector) -> Vector:
        x, y, z = rotated(self.rotation, point)
        return (x + self.translation[0], y + self.translation[1], z + self.translation[2])

    def inverse(self) -> Transform:
        back = conjugate(self.rotation)
        x, y, z = rotated(back, self.translation)
        return Transform((-x, -y, -z), back)

    def towards(self, other: Transform, share: float) -> Transform:
        """The transform at a share of the way to another: 0 is here, 1 is there."""
        x, y, z = (a + (b - a) * share for a, b in zip(self.translation, other.translation, strict=True))
        return Transform((x, y, z), between(self.rotation, other.rotation, share))


class TransformLookup(NamedTuple):
    """What a lookup found."""

    transform: Transform
    """Takes a point of the source to the target."""
    at: float | None
    """The instant, of the messages' stamps; None for what does not change with time."""
    received_at: float | None
    """When the oldest of what it rests on was last received, on the run's clock; None for what does not change."""


class Track:
    """One frame in its parent, over time."""

    def __init__(self, parent: str, *, is_static: bool) -> None:
        self.parent, self.is_static = parent, is_static
        self.samples: list[tuple[float, Transform]] = []
        self.received_at = 0.0

    def add(self, at: float, transform: Transform, received_at: float) -> None:
        self.received_at = received_at
        if self.is_static or (self.samples and at < self.samples[-1][0] - KEEP_S):  # the clock was set back
            self.samples = [(at, transform)]
            return
        insort(self.samples, (at, transform), key=lambda sample: sample[0])
        oldest = max(self.samples[-1][0] - KEEP_S, self.samples[max(0, len(self.samples) - MOST)][0])
        del self.samples[: bisect_left(self.samples, oldest, key=lambda sample: sample[0])]

    def at(self, at: float) -> Transform | None:
        """At an instant; None outside of what was received."""
        if self.is_static:
            return self.samples[0][1]
        place = bisect_left(self.samples, at, key=lambda sample: sample[0])
        if place == len(self.samples):
            return None
        later, there = self.samples[place]
        if later == at:
            return there
        if place == 0:
            return None
        earlier, here = self.samples[place - 1]
        return here.towards(there, (at - earlier) / (later - earlier))


class Frames:
    """What was received on /tf and /tf_static."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._tracks: dict[str, Track] = {}

    def receive(self, message: Mapping[str, Any], *, is_static: bool = False, received_at: float = 0.0) -> None:
        """Take in a tf2_msgs/msg/TFMessage, received at an instant of the run's clock.

        Raises:
            ConnectorError: It is none, or holds what is no transform; what is before that is taken in.
        """
        transforms = message.get("transforms")
        if not isinstance(transforms, list | tuple):
            raise ConnectorError(
                f"{cut_repr(message, 60)} is given where a tf2_msgs/msg/TFMessage belongs: no 'transforms'"
            )
        for each in transforms:
            self._take(*_read(each), is_static=is_static, received_at=received_at)

    def _take(
        self, parent: str, child: str, at: float, transform: Transform, *, is_static: bool, received_at: float
    ) -> None:
        with self._lock:
            known = self._tracks.get(child)
            if known is None or known.parent != parent or known.is_static != is_static:
                if len(self._tracks) >= MOST and known is None:
                    raise ConnectorError(f"more than {MOST} frames are sent; no more are kept")
                known = self._tracks[child] = Track(parent, is_static=is_static)
            known.add(at, transform, received_at)

    @property
    def names(self) -> tuple[str, ...]:
        """All frames, parents too."""
        return tuple(sorted({*self._tracks, *(track.parent for track in self._tracks.values())}))

    def lookup(self, target: str, source: str, at: float | None = None) -> TransformLookup:
        """The pose of `source` in `target`.

        Args:
            target: The frame in which the answer is reported.
            source: The frame whose pose is reported.
            at: An instant of the messages' stamps; left out, the newest at which all of the way is known.

        Raises:
            UsageError: A frame was not learned of, the two are not connected, or the time is not in what was received.
        """
        with self._lock:
            up, down = self._ways(target, source)
            moving = [track for name in (*up, *down) if not (track := self._tracks[name]).is_static]
            if at is None and moving:
                at = min(track.samples[-1][0] for track in moving)
            found = self._along(down, at).inverse() @ self._along(up, at)
            return (
                TransformLookup(found, at, min(track.received_at for track in moving))
                if moving
                else TransformLookup(found, None, None)
            )

    def _ways(self, target: str, source: str) -> tuple[list[str], list[str]]:
        """The frames below the first that both share: from the source up, and from the target up."""
        names = self.names
        for name in (target, source):
            if name not in names:
                raise UsageError(
                    f"no frame {cut_repr(name, 80)} was reported; there is: {', '.join(names[:20]) or 'none yet'}"
                )
        up, down = self._way(source), self._way(target)
        shared = next((name for name in up if name in down), None)
        if shared is None:
            tops = f"{up[-1]} and {down[-1]} have no parent"
            raise UsageError(f"the frames '{source}' and '{target}' are not connected: {tops}")
        return up[: up.index(shared)], down[: down.index(shared)]

    def _way(self, name: str) -> list[str]:
        """The frame and those above it, up to the root."""
        way = [name]
        while (track := self._tracks.get(way[-1])) is not None:
            if track.parent in way:
                raise UsageError(f"the frames go round in a circle: {' → '.join((*way, track.parent))}")
            way.append(track.parent)
        return way

    def _along(self, way: Iterable[str], at: float | None) -> Transform:
        """From the lowest frame of a way to above its highest."""
        whole = Transform()
        for name in way:
            track = self._tracks[name]
            found = track.at(0.0 if at is None else at)
            if found is None:
                window = f"it was received from {track.samples[0][0]:.3f} to {track.samples[-1][0]:.3f} s"
                raise UsageError(f"at {at:.3f} s '{name}' in '{track.parent}' is not known: {window}")
            whole = found @ whole
        return whole


def _read(given: Any) -> tuple[str, str, float, Transform]:
    """Parent, child, stamp and transform of a geometry_msgs/msg/TransformStamped."""
    try:
        header, moved, turned = given["header"], given["transform"]["translation"], given["transform"]["rotation"]
        parent, child = str(header["frame_id"]).lstrip("/"), str(given["child_frame_id"]).lstrip("/")
        numbers = [float(moved[axis]) for axis in "xyz"] + [float(turned[axis]) for axis in "xyzw"]
        at = stamp_of(header)
    except (KeyError, TypeError, ValueError) as fault:
        raise ConnectorError(
            f"{cut_repr(given, 80)} is no geometry_msgs/msg/TransformStamped: {cut_repr(fault, 60)}"
        ) from None
    length = math.hypot(*numbers[3:])
    if not all(map(math.isfinite, numbers)) or abs(length - 1) > UNIT or not parent or not child or parent == child:
        raise ConnectorError(f"the transform of {cut_repr(child, 60)} in {cut_repr(parent, 60)} is none: {numbers}")
    x, y, z, qx, qy, qz, qw = numbers
    return parent, child, at, Transform((x, y, z), (qx / length, qy / length, qz / length, qw / length))


def stamp_of(header: Mapping[str, Any]) -> float:
    """Seconds of a header's stamp, on the clock of its sender."""
    stamp = header["stamp"]
    return (
        float((int(stamp["sec"]) * 10**9 + int(stamp["nanosec"])) / 1e9) if isinstance(stamp, Mapping) else float(stamp)
    )


def product(one: Quaternion, two: Quaternion) -> Quaternion:
    ax, ay, az, aw = one
    bx, by, bz, bw = two
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def yaw_of(x: float, y: float, z: float, w: float) -> float:
    """The turn of a rotation about the z axis, in radians."""
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def planar(pose: Mapping[str, Any]) -> tuple[float, float, float]:
    """x, y and yaw of a geometry_msgs/msg/Pose.

    Raises:
        KeyError, TypeError, ValueError: It is none.
    """
    position, turned = pose["position"], pose["orientation"]
    return float(position["x"]), float(position["y"]), yaw_of(*(float(turned[axis]) for axis in "xyzw"))


def conjugate(turn: Quaternion) -> Quaternion:
    x, y, z, w = turn
    return (-x, -y, -z, w)


def rotated(turn: Quaternion, point: Vector) -> Vector:
    x, y, z, _ = product(product(turn, (*point, 0.0)), conjugate(turn))
    return (x, y, z)


def between(one: Quaternion, two: Quaternion, share: float) -> Quaternion:
    """Spherical interpolation, the shorter way round."""
    cosine = sum(a * b for a, b in zip(one, two, strict=True))
    sign = -1.0 if cosine < 0 else 1.0
    cosine = min(1.0, abs(cosine))
    angle = math.acos(cosine)
    if angle < 1e-6:
        here, there = 1.0 - share, share * sign
    else:
        here = math.sin((1 - share) * angle) / math.sin(angle)
        there = sign * math.sin(share * angle) / math.sin(angle)
    x, y, z, w = (a * here + b * there for a, b in zip(one, two, strict=True))
    length = math.hypot(x, y, z, w)
    return (x / length, y / length, z / length, w / length)
