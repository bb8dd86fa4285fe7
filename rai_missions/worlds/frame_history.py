# SPDX-License-Identifier: Apache-2.0
"""The pictures that a world's camera took lately, by their stamps, so that each can be measured later.

Rule: a picture, its depth and what a detector reads in it are of one moment; nothing is rendered before it is asked
for.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

import numpy as np

from rai_missions.connectors.stamps import stamp_of
from rai_missions.image import Image
from rai_missions.worlds import messages
from rai_missions.worlds.camera import Camera, Frame, Moment
from rai_missions.worlds.publish_queue import Outbox

__all__ = ("FrameHistory",)

KEPT, MEASURED = 40, 3
"""Moments, and measured frames, that are kept."""
DEPTH_NOISE = 0.004
"""Standard deviation of a pixel's depth, as a share of it."""
NEAREST_M, FARTHEST_M = 0.2, 8.0
"""What is nearer or farther has no depth."""


class FrameHistory:
    """The last moments of one camera.

    Args:
        camera: Whose frames are as large as its pictures.
        seed: The seed of the depth's noise.
        topics: The topics of the picture, of its depth and of the lens.
        fovy_deg: The camera's field of view, top to bottom.
    """

    def __init__(self, camera: Camera, seed: int, *, topics: tuple[str, str, str], fovy_deg: float) -> None:
        self._camera, self._seed, self._topics, self._fovy_deg = camera, seed, topics, fovy_deg
        self._lock = threading.Lock()
        self._moments: OrderedDict[int, Moment] = OrderedDict()
        self._measured: OrderedDict[int, Frame] = OrderedDict()

    def publish(self, outbox: Outbox, data: Any, at: float) -> None:
        """Publish what the camera sees now, and remember it.

        Args:
            outbox: Where to.
            data: The state of the physics.
            at: When that is, s.
        """
        moment, (colour, depth, lens) = self._camera.moment(data), self._topics
        width, height = self._camera.width, self._camera.height
        measured = Image(f"/{depth}@{at:.3f}", width, height, "16UC1", lambda: self._depth_mm(at, moment))
        outbox.publish(lens, messages.camera_info(width, height, self._fovy_deg, at))
        outbox.publish(depth, messages.image(measured, at))
        outbox.publish(colour, messages.image(self._camera.picture(moment, f"/{colour}@{at:.3f}"), at))
        with self._lock:
            self._moments[_milliseconds(at)] = moment
            while len(self._moments) > KEPT:
                self._moments.popitem(last=False)

    def of_picture(self, picture: Any) -> tuple[int, Frame] | None:
        """When a picture was taken, in ms, and its frame; None where it is none of the last ones.

        Args:
            picture: A sensor_msgs/msg/Image; its stamp counts.
        """
        stamp = stamp_of(picture) if isinstance(picture, Mapping) else None
        if stamp is None:
            return None
        moment_ms = _milliseconds(stamp)
        with self._lock:
            moment = self._moments.get(moment_ms)
        return None if moment is None else (moment_ms, self._frame(moment_ms, moment))

    def _depth_mm(self, at: float, moment: Moment) -> bytes:
        """The depth of a moment in mm, two bytes a pixel, the low one first, with the sensor's noise; 0 is unknown."""
        moment_ms = _milliseconds(at)
        frame = self._frame(moment_ms, moment)
        noise = np.random.default_rng((self._seed, moment_ms)).normal(1, DEPTH_NOISE, frame.depth_m.shape)
        depth = frame.depth_m * noise
        known = (depth > NEAREST_M) & (depth < FARTHEST_M)
        return np.where(known, np.rint(depth * 1000), 0).astype("<u2").tobytes()

    def _frame(self, moment_ms: int, moment: Moment) -> Frame:
        with self._lock:
            known = self._measured.get(moment_ms)
        if known is not None:
            return known
        frame, _ = self._camera.frame(moment)
        with self._lock:
            self._measured[moment_ms] = frame
            while len(self._measured) > MEASURED:
                self._measured.popitem(last=False)
        return frame


def _milliseconds(at: float) -> int:
    return round(at * 1000)
