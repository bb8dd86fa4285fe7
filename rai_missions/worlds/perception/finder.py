# SPDX-License-Identifier: Apache-2.0
"""The object finder: asks a detector while something is looked for, and reports what it finds on the map.

Rule: a look counts only while the robot is still, and only with a picture, its depth and its pose of the same moment;
a sighting was in the camera's picture at that moment, whatever was seen before.
"""

from __future__ import annotations

import json
import math
import threading
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from rai_missions.connectors.connector import Close, Connector, Message, Reply
from rai_missions.connectors.stamps import stamp_of
from rai_missions.errors import ConnectorError
from rai_missions.redaction import cut, logger
from rai_missions.worlds.perception.detections import CLASSIFY, classes_of, detections_of, request
from rai_missions.worlds.perception.looks import AgreedObject, Looks, Sighting
from rai_missions.worlds.perception.projection import Lens, Mount, Robot2D, depth_of, lens_of, locate

__all__ = ("FinderConfig", "ObjectFinder")

log = logger(__name__)
Kept = OrderedDict[float, Message]
"""Stamp → picture or depth."""
TEXT = "std_msgs/msg/String"
MOST_NAMES, LONGEST = 20, 60
"""How many things are looked for at once, and how long a name may be."""
KEPT = 4
"""Pictures, and depths, that wait for their other half."""
STILL_M, STILL_RAD = 0.03, 0.03
"""How far the robot may have moved between two poses and count as still."""
AGAIN_S = 2.0
"""How long a detector that failed is left alone."""
LATE_S = 2.0
"""A reply to a picture that is older than this is dropped."""


@dataclass(frozen=True)
class FinderConfig:
    """Where the finder reads, asks and reports."""

    camera: str = "/camera/color/image_raw"
    depth: str = "/camera/depth/image_raw"
    lens: str = "/camera/color/camera_info"
    pose: str = "/amcl_pose"
    pose_type: str = "geometry_msgs/msg/PoseWithCovarianceStamped"
    detector: str = CLASSIFY[0][0]
    look_for: str = "/look_for"
    """Comma-separated names (std_msgs/msg/String); empty: nothing is looked for."""
    sighting: str = "/sighting"
    """JSON: the most certain thing that is looked for and seen now."""
    seen: str = "/seen"
    """JSON: what most looks from here agree on, after each look, also where that is nothing."""
    mount: Mount = field(default_factory=Mount)
    range_m: float = 4.0
    """What is farther away is not reported: depth is too coarse there."""
    rooms: Mapping[str, Sequence[float]] = field(default_factory=dict)
    """Name → west, south, east, north in m on the map."""
    furniture: Mapping[str, Sequence[float]] = field(default_factory=dict)
    """Name of furniture that things may be on → west, south, east, north in m on the map."""


class ObjectFinder:
    """One robot's finder, on a connector.

    Args:
        config: The names there.
    """

    LEADS_OUT: ClassVar = {"_connector": lambda: None}

    def __init__(self, config: FinderConfig) -> None:
        self._config = config
        self._connector: Connector | None = None
        self._lock = threading.Lock()
        self._names: tuple[str, ...] = ()
        self._looks, self._asked = Looks(), False
        self._lens: Lens | None = None
        self._pose: tuple[float, Robot2D] | None = None
        self._still_since = math.inf
        self._pictures: Kept = OrderedDict()
        self._depths: Kept = OrderedDict()
        self._is_failing, self._silent_until = False, -math.inf

    def open(self, connector: Connector) -> list[Close]:
        """Subscribe where the camera, the detector and the mission are; what ends it all."""
        config, self._connector = self._config, connector
        return [
            connector.subscribe(config.pose, config.pose_type, self._on_pose),
            connector.subscribe(config.lens, "sensor_msgs/msg/CameraInfo", self._on_lens),
            connector.subscribe(config.depth, "sensor_msgs/msg/Image", self._on_depth),
            connector.subscribe(config.camera, "sensor_msgs/msg/Image", self._on_picture),
            connector.subscribe(config.look_for, TEXT, self._on_order),
        ]

    def _on_order(self, message: Message) -> None:
        names = classes_of(str(message.data.get("data", "")))
        with self._lock:
            self._names = tuple(name for name in names if len(name) <= LONGEST)[:MOST_NAMES]
            self._looks.clear()

    def _on_lens(self, message: Message) -> None:
        with self._lock:
            self._lens = lens_of(message.data)

    def _on_pose(self, message: Message) -> None:
        pose = _pose(message.data)
        with self._lock:
            if pose is None:
                return
            before = self._pose
            self._pose = message.at, pose
            if before is None or not _is_near(before[1], pose):
                self._still_since = math.inf
                self._looks.clear()
            else:
                self._still_since = min(self._still_since, before[0])

    def _on_depth(self, message: Message) -> None:
        self._keep(self._depths, message)
        self._look()

    def _on_picture(self, message: Message) -> None:
        self._keep(self._pictures, message)
        self._look()

    def _keep(self, kept: Kept, message: Message) -> None:
        with self._lock:
            kept[_stamp(message)] = message
            while len(kept) > KEPT:
                kept.popitem(last=False)

    def _look(self) -> None:
        """Ask the detector about a picture and a depth of one moment, if there is something to look for."""
        connector = self._connector
        with self._lock:
            pair = self._pair()
            if connector is None or not (self._names and pair and self._pose and self._lens) or self._asked:
                return
            (at, picture, depth), pose = pair, self._pose[1]
            if at < self._silent_until:
                return
            names, lens, self._asked = self._names, self._lens, True
        try:
            connector.call(
                self._config.detector,
                CLASSIFY[1],
                request(names, picture),
                timeout_s=LATE_S,
                on_reply=lambda reply: self._on_reply(reply, at, names, pose, lens, depth),
            )
        except ConnectorError as fault:
            self._fail(at, str(fault))

    def _pair(self) -> tuple[float, Mapping[str, Any], Mapping[str, Any]] | None:
        """The newest picture and depth of one moment, and when it was, if the robot is still since; older ones go."""
        both = sorted(self._pictures.keys() & self._depths.keys())
        if not both:
            return None
        picture, depth = self._pictures[both[-1]], self._depths[both[-1]]
        for kept in (self._pictures, self._depths):
            for stamp in [each for each in kept if each <= both[-1]]:
                del kept[stamp]
        at = min(picture.at, depth.at)
        return (at, picture.data, depth.data) if at >= self._still_since else None

    def _on_reply(
        self, reply: Reply, at: float, names: tuple[str, ...], pose: Robot2D, lens: Lens, depth: Mapping[str, Any]
    ) -> None:
        if reply.outcome != "succeeded":
            self._fail(at, reply.why or reply.outcome)
            return
        found = list(self._located(reply.data, names, pose, lens, depth))
        with self._lock:
            self._asked = self._is_failing = False
            if self._names != names or at < self._still_since:
                return
            self._looks.add(found)
            seen, agreed, looks = self._looks.seen(), self._looks.agreed(), len(self._looks)
        self._report(seen, agreed, looks)

    def _located(
        self, reply: Mapping[str, Any], names: Sequence[str], pose: Robot2D, lens: Lens, depth: Mapping[str, Any]
    ) -> Iterator[Sighting]:
        """The detections that have a place on the map within range."""
        detections = [one for one in detections_of(reply.get("detections")) if one.name in names]
        metres = depth_of(depth) if detections else None
        if metres is None:
            return
        for one in detections:
            place = locate(one.box, metres, lens, self._config.mount, pose)
            if place is not None and place.distance_m <= self._config.range_m:
                yield Sighting(one.name, place, one.score)

    def _fail(self, at: float, why: str) -> None:
        """A look without an answer is no look; the first of several is logged."""
        with self._lock:
            self._asked, self._silent_until = False, at + AGAIN_S
            was_failing, self._is_failing = self._is_failing, True
        if not was_failing:
            log.warning("the detector %s gives no answer: %s", self._config.detector, cut(why, 200))

    def _report(self, seen: Sequence[AgreedObject], agreed: Sequence[AgreedObject], looks: int) -> None:
        for best in seen[:1]:
            fact = self._fact(best)
            self._publish(self._config.sighting, {**fact, "text": _sentence(fact)})
        facts = [self._fact(one) for one in agreed]
        text = "; ".join(map(_sentence, facts)) or "nothing that is looked for"
        self._publish(self._config.seen, {"looks": looks, "count": len(facts), "objects": facts, "text": text})

    def _fact(self, one: AgreedObject) -> dict[str, Any]:
        x, y, z, away = (round(value, 2) for value in one.place)
        return {
            "object": one.name,
            "x": x,
            "y": y,
            "z": z,
            "distance_m": away,
            "certainty": round(one.certainty, 2),
            "agreeing": one.agreeing,
            "looks": one.looks,
            "score": round(one.score, 2),
            "room": _area(self._config.rooms, x, y, 0.0),
            "on": (_area(self._config.furniture, x, y, 0.15) if z > 0.3 else "") or "floor",
        }

    def _publish(self, topic: str, fact: Mapping[str, Any]) -> None:
        connector = self._connector
        if connector is None:
            return
        try:
            connector.publish(topic, TEXT, {"data": json.dumps(fact)})
        except ConnectorError as fault:
            log.warning("%s cannot be published: %s", topic, cut(str(fault), 200))


def _sentence(fact: Mapping[str, Any]) -> str:
    """A fact for a person to read."""
    place = f"on the {fact['on']}" + (f" in the {fact['room']}" if fact["room"] else "")
    return (
        f"{fact['object']} {place}, at x {fact['x']:.1f} m, y {fact['y']:.1f} m, {fact['distance_m']:.1f} m away; "
        f"{fact['agreeing']} of {fact['looks']} looks agree, certainty {fact['certainty']:.0%}"
    )


def _stamp(message: Message) -> float:
    """What identifies the moment: the stamp in the header, or the receipt."""
    return round(stamp_of(message.data) or message.at, 4)


def _pose(data: Mapping[str, Any]) -> Robot2D | None:
    """The pose in a PoseStamped, a PoseWithCovarianceStamped or an Odometry."""
    inner: Any = data.get("pose") or {}
    inner = inner.get("pose", inner)
    try:
        place, turn = inner["position"], inner["orientation"]
        x, y, yaw = float(place["x"]), float(place["y"]), 2 * math.atan2(float(turn["z"]), float(turn["w"]))
    except (KeyError, TypeError, ValueError):
        return None
    return Robot2D(x, y, yaw) if all(map(math.isfinite, (x, y, yaw))) else None


def _is_near(one: Robot2D, other: Robot2D) -> bool:
    turned = abs(math.remainder(one.yaw - other.yaw, 2 * math.pi))
    return math.dist(one[:2], other[:2]) <= STILL_M and turned <= STILL_RAD


def _area(areas: Mapping[str, Sequence[float]], x: float, y: float, margin_m: float) -> str:
    for name, (west, south, east, north) in areas.items():
        if west - margin_m <= x <= east + margin_m and south - margin_m <= y <= north + margin_m:
            return name
    return ""
