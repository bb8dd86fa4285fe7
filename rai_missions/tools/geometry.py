# SPDX-License-Identifier: Apache-2.0
"""What measures: where a frame lies in another, and how far away detected objects are.

Rule: nothing here changes anything on the robot; what cannot be measured is unknown, with the reason.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any

from pydantic import Field

from rai_missions.connectors.connector import Close, Message, OnMessage
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import logger
from rai_missions.tools.access import AllowedConnector, Sample, until
from rai_missions.tools.arguments import Age, Name, Text, Timeout
from rai_missions.tools.detections import Detection, detections_of
from rai_missions.tools.latest import Latest
from rai_missions.tools.ranging import PinholeCamera, Range, camera_of, cloud_points, depth_points, ranged
from rai_missions.tools.result import ToolResult
from rai_missions.tools.transforms import Frames, Transform, TransformLookup, yaw_of

__all__ = ("GeometryTools",)

log = logger(__name__)

TF_TYPE = "tf2_msgs/msg/TFMessage"
AT_S = "When, in seconds, as the stamps of messages state; empty: the newest."
APART_S = "How far apart in time detections and depth may be."
TOPICS = (("/tf", False), ("/tf_static", True))


class GeometryTools:
    """The tools that measure.

    Args:
        reach: The way to the robot.
    """

    def __init__(self, reach: AllowedConnector) -> None:
        self._reach = reach
        self._frames = Frames()
        self._news: Latest[int] = Latest()
        self._closes: dict[str, Close] = {}
        self._count = 0

    def stop(self) -> None:
        """Listen to no transforms any more."""
        closes, self._closes = self._closes, {}
        for close in closes.values():
            close()

    def get_transform(
        self,
        target: Annotated[Name, Field(description="The frame in which the answer is reported, such as 'map'.")],
        source: Annotated[Name, Field(description="The frame whose pose is asked for, such as 'base_link'.")],
        *,
        at_s: Annotated[float | None, Field(allow_inf_nan=False, description=AT_S)] = None,
        max_age_s: Age = None,
        timeout_s: Timeout = 2.0,
    ) -> ToolResult:
        """Where one coordinate frame lies in another: translation in metres, rotation as a quaternion, yaw."""
        target, source = target.lstrip("/"), source.lstrip("/")
        found = self._lookup(target, source, at_s, until(timeout_s))
        age_s = None if found.received_at is None else max(0.0, self._reach.now() - found.received_at)
        if max_age_s is not None and age_s is not None and age_s > max_age_s:
            raise ConnectorError(
                f"'{source}' in '{target}' was last received {age_s:.2f} s ago, more than {max_age_s:g} s"
            )
        (x, y, z), (qx, qy, qz, qw) = found.transform
        data = {
            "target": target,
            "source": source,
            "translation": {"x": x, "y": y, "z": z},
            "rotation": {"x": qx, "y": qy, "z": qz, "w": qw},
            "yaw": yaw_of(qx, qy, qz, qw),
            "stamp_s": found.at,
            "age_s": age_s,
        }
        when = "it does not change" if age_s is None else f"received {age_s:.2f} s ago"
        words = f"The pose of the frame '{source}' in '{target}' (metres, radians), {when}:"
        return ToolResult(words, data, {word: data[word] for word in ("translation", "rotation", "yaw", "stamp_s")})

    def get_distance_to_objects(
        self,
        detections_topic: Annotated[
            Name, Field(description="Where a detector reports what it sees: boxes with names.")
        ],
        *,
        depth_topic: Annotated[Text, Field(description="A depth image's topic; this or cloud_topic.")] = "",
        cloud_topic: Annotated[Text, Field(description="A point cloud's topic; this or depth_topic.")] = "",
        camera_info_topic: Annotated[Text, Field(description="The camera's calibration; for a depth image.")] = "",
        names: Annotated[Sequence[str], Field(max_length=100, description="Only objects with these names.")] = (),
        max_age_s: Age = 2.0,
        max_apart_s: Annotated[float, Field(ge=0, le=60, description=APART_S)] = 0.5,
        timeout_s: Timeout = 5.0,
    ) -> ToolResult:
        """How far from the camera, in metres, the objects are that a detector sees."""
        if bool(depth_topic) == bool(cloud_topic):
            raise UsageError("state one of depth_topic and cloud_topic: what the distances are measured with")
        if depth_topic and not camera_info_topic:
            raise UsageError("a depth image needs its camera_info_topic")
        depth, ends = depth_topic or cloud_topic, until(timeout_s)
        wanted = {detections_topic: "", depth: "", **({camera_info_topic: ""} if camera_info_topic else {})}
        oldest_s = math.inf if max_age_s is None else max_age_s

        def fault(received: Mapping[str, Sample]) -> str:
            return _misfit(received, wanted, (detections_topic, depth), oldest_s, max_apart_s)

        received = self._reach.receive(wanted, ends, lambda so_far: not fault(so_far))
        if why := fault(received):
            return ToolResult(f"The distances are unknown: {why}.", {"objects": [], "why": why})
        camera = camera_of(received[camera_info_topic].data) if camera_info_topic else None
        found = [each for each in detections_of(received[detections_topic].data) if not names or each.name in names]
        look = self._sight(
            received[depth], received.get(camera_info_topic), camera, is_cloud=not depth_topic, ends=ends
        )
        objects = [_object(each, look(each)) for each in found]
        age_s = max(received[topic].age_s for topic in (detections_topic, depth))
        some = f"Objects detected: {len(objects)}" if objects else "No such object was detected"
        words = f"{some}, {age_s:.2f} s ago; distances in metres from the camera, null where unknown:"
        return ToolResult(words, {"objects": objects, "age_s": age_s, "why": ""}, objects)

    def _sight(
        self, seen: Sample, info: Sample | None, camera: PinholeCamera | None, *, is_cloud: bool, ends: float
    ) -> Callable[[Detection], Range]:
        """What measures a detection's box."""
        if not is_cloud and camera is not None:
            return lambda each: ranged(*depth_points(seen.data, camera, each.box))
        cloud_frame, camera_frame = _frame(seen), _frame(info) if info is not None else ""
        move: Transform | None = None
        if cloud_frame and camera_frame and cloud_frame != camera_frame:
            move = self._lookup(camera_frame, cloud_frame, None, ends).transform
        return lambda each: ranged(*cloud_points(seen.data, camera, each.box, move))

    def _lookup(self, target: str, source: str, at: float | None, ends: float) -> TransformLookup:
        """A transform, as soon as it is known."""
        self._listen(ends)
        while True:
            count = self._count
            try:
                return self._frames.lookup(target, source, at)
            except UsageError:
                if time.monotonic() >= ends:
                    raise
            self._wait_for_news(count, ends)

    def _wait_for_news(self, seen: int, ends: float) -> None:
        news = self._reach.waiting(self._news)
        try:
            news.wait(ends, lambda now: now > seen)
        finally:
            self._reach.done(news)

    def _listen(self, ends: float) -> None:
        """Listen to the transforms, from the first time on that they are asked for."""
        for topic, _ in TOPICS:
            self._reach.allowed.check(topic, "read")
        for topic, is_static in TOPICS:
            if topic not in self._closes:
                close, _ = self._reach.subscribe(topic, TF_TYPE, self._on_transform(is_static=is_static), ends)
                self._closes[topic] = close

    def _on_transform(self, *, is_static: bool) -> OnMessage:
        def on_message(message: Message) -> None:
            try:
                self._frames.receive(message.data, is_static=is_static, received_at=self._reach.now())
            except ConnectorError as fault:
                log.info("a transform is not taken in: %s", fault)
            self._count += 1
            self._news.put(self._count)

        return on_message


def _misfit(
    received: Mapping[str, Sample], wanted: Mapping[str, str], pair: tuple[str, str], oldest_s: float, apart_s: float
) -> str:
    """Why what was received does not fit together (yet); empty if it does."""
    for topic in wanted:
        if topic not in received:
            return f"nothing was received on {topic}"
    for topic in pair:
        if received[topic].age_s > oldest_s:
            return f"what was received on {topic} is {received[topic].age_s:.2f} s old"
    gap_s = abs(received[pair[0]].at - received[pair[1]].at)
    return f"{pair[0]} and {pair[1]} are {gap_s:.2f} s apart" if gap_s > apart_s else ""


def _frame(sample: Sample) -> str:
    header = sample.data.get("header")
    return str(header.get("frame_id", "")).lstrip("/") if isinstance(header, Mapping) else ""


def _object(detection: Detection, found: Range) -> dict[str, Any]:
    position = None if found.position is None else dict(zip("xyz", found.position, strict=True))
    why = {"why": found.why} if found.why else {}
    return {
        "name": detection.name,
        "score": detection.score,
        "distance_m": found.distance_m,
        "position": position,
        "box": list(detection.box),
        "measurements": found.measurements,
        **why,
    }
