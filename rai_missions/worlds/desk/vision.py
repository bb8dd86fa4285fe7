# SPDX-License-Identifier: Apache-2.0
"""What the front camera publishes, and the detector's services on its pictures, as upstream's simulation has them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rai_missions.worlds.camera import Camera, Moment
from rai_missions.worlds.desk import interface
from rai_missions.worlds.desk.catalogue import COLOURS, lookalikes
from rai_missions.worlds.desk.detector import LookErrors, ThingClass
from rai_missions.worlds.desk.scene import FRONT_FOVY_DEG
from rai_missions.worlds.detector_services import Answer, DetectorServices
from rai_missions.worlds.frame_history import FrameHistory
from rai_missions.worlds.open_set_detector import DetectorErrors, OpenSetDetector, Thing
from rai_missions.worlds.publish_queue import Outbox

__all__ = ("DeskVision",)


class DeskVision:
    """The front camera's topics and services.

    Args:
        camera: Its frames are as large as its pictures.
        things: Body of the model → what it is.
        errors: How the detector errs.
        seed: Of the noise and of the errors.
        now: Simulated seconds since the start.
    """

    def __init__(
        self, camera: Camera, things: Mapping[int, ThingClass], errors: LookErrors, seed: int, now: Callable[[], float]
    ) -> None:
        self._frames = FrameHistory(camera, seed)
        boxes = DetectorErrors(miss=errors.miss, misclassify=errors.swap, down=errors.down)
        bodies = {body: Thing(*thing) for body, thing in things.items()}
        self._served = DetectorServices(self._frames, OpenSetDetector(bodies, boxes, seed, _lookalikes, COLOURS), now)

    def services(self) -> dict[tuple[str, str], Answer]:
        """Name and type → what answers."""
        return self._served.services()

    def publish(self, outbox: Outbox, moment: Moment, at: float) -> None:
        """Publish a moment's depth and the lens; the picture itself follows."""
        self._frames.publish(outbox, moment, at, depth=interface.DEPTH, lens=interface.LENS, fovy_deg=FRONT_FOVY_DEG)


def _lookalikes(thing: Thing) -> list[Thing]:
    return [Thing(*other) for other in lookalikes(*thing)]
