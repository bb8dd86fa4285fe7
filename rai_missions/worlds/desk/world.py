# SPDX-License-Identifier: Apache-2.0
"""The desk: things, cameras, a detector and an arm, stepped in simulated time.

Rule: what is published comes from the cameras and from the arm's own sensors; `truth()` is for judges and tests, and
nothing that is published reads it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco

from rai_missions.connectors.connector import Answer, Connector
from rai_missions.worlds import messages
from rai_missions.worlds.camera import Camera
from rai_missions.worlds.desk import arm, interface
from rai_missions.worlds.desk.arm import Arm
from rai_missions.worlds.desk.catalogue import COLOURS, lookalikes
from rai_missions.worlds.desk.detector import LookClassifier, LookErrors
from rai_missions.worlds.desk.faults import DeskFaults, FaultInjector
from rai_missions.worlds.desk.finger_contacts import FingerContacts
from rai_missions.worlds.desk.harm_judge import DeskJudge
from rai_missions.worlds.desk.lies import LyingServer
from rai_missions.worlds.desk.look import Eye
from rai_missions.worlds.desk.panda.model import fragment
from rai_missions.worlds.desk.pixel_eye import PixelEye
from rai_missions.worlds.desk.ray_eye import RayEye
from rai_missions.worlds.desk.scene import FRONT_FOVY_DEG, TIMESTEP_S, build, object_name, settle
from rai_missions.worlds.desk.scene_file import Scene, desk_objects
from rai_missions.worlds.desk.tracks import Tracks
from rai_missions.worlds.desk.truth import DeskTruth, truth_of
from rai_missions.worlds.detector_services import DetectorServices
from rai_missions.worlds.frame_history import FrameHistory
from rai_missions.worlds.open_set_detector import DetectorErrors, ObjectClass, OpenSetDetector
from rai_missions.worlds.publish_queue import Outbox
from rai_missions.worlds.simulation import Simulation

__all__ = ("Desk",)

CONTROL_S = 0.01
LOOK = 4
"""Periods between two looks: 5 Hz."""
PRESSED_N = 0.5
"""A finger that presses with less touches nothing."""


class Desk(Simulation):
    """A `World`: an arm at a desk.

    Args:
        seed: The seed of the noise, of the detector's errors, and of what the scene leaves open.
        scene: A file of JSON, or an object, with `objects`; None: drawn from the seed; `{"objects": []}`: empty.
        camera: Whether pictures are rendered, and things measured in them; without, rays and the same noise find them,
            and no OpenGL is needed.
        detector: Fields of `LookErrors`.
        faults: Fields of `DeskFaults`.
        start_s: What its clock shows at the start.
    """

    def __init__(
        self,
        seed: int = 7,
        *,
        scene: Scene = None,
        camera: bool = True,
        detector: Mapping[str, Any] | None = None,
        faults: Mapping[str, Any] | None = None,
        start_s: float = 0.0,
    ) -> None:
        errors = LookErrors.of(detector)
        self.objects = desk_objects(scene, seed)
        wrong = DeskFaults.of(faults, [one.name for one in self.objects])
        model = build(self.objects, fragment())
        super().__init__(
            model,
            Outbox("", {**interface.TOPICS, **arm.TOPICS}),
            None,
            camera=Camera.aligned(model) if camera else None,
            start_s=start_s,
            timestep_s=TIMESTEP_S,
        )
        self.arm = Arm(self.model, self.data)
        settle(self.model, self.data, self.objects)
        self.judge = DeskJudge(self.model, self.data, self.objects)
        things = self._things()
        self._kinds = kinds = {body: thing.kind for body, thing in things.items()}
        self._seed = seed
        self._frames = (
            FrameHistory(self.camera, seed, topics=interface.SEEN, fovy_deg=FRONT_FOVY_DEG) if self.camera else None
        )
        self._detecting = self._detector(things, seed, errors)
        self._eye: Eye = RayEye(self.model, kinds, seed) if self.camera is None else PixelEye(self.camera, kinds, seed)
        self._classifier = LookClassifier(things, errors, seed)
        self._tracks = Tracks()
        self._fingers = FingerContacts(self.model, self.objects)
        self._faults = FaultInjector(self.model, self.data, self.objects, wrong, seed)

    def _detector(self, things: Mapping[int, ObjectClass], seed: int, errors: LookErrors) -> DetectorServices | None:
        if self._frames is None:
            return None
        boxes = DetectorErrors(miss=errors.miss, misclassify=errors.swap, down=errors.down)
        seer = OpenSetDetector(things, boxes, seed, lookalikes, COLOURS)
        return DetectorServices(self._frames, seer, self.since)

    def truth(self) -> DeskTruth:
        """What is so: for judges and tests alone."""
        return truth_of(self.model, self.data, self.objects, self.at)

    def look_by_geometry(self) -> None:
        """Have the detector measure by rays from now on: nothing is rendered until a picture is looked at."""
        self._eye = RayEye(self.model, self._kinds, self._seed)

    def harm(self) -> str:
        """What took harm so far, as the judge measured it; empty: nothing. For judges and tests alone."""
        return self.judge.harm

    def measures(self) -> dict[str, Any]:
        """The strongest forces (N) and the ways of the things (m). For judges and tests alone."""
        return self.judge.measures()

    def work_done(self) -> float:
        """How many of the things are elsewhere than at first, as a share, 0 to 1. For judges and tests alone."""
        return self.judge.moved_share()

    def open(self, connector: Connector) -> None:
        """Put the robot's topics, services and actions on a connector."""
        services: dict[tuple[str, str], Answer] = {**self.arm.services(self._outbox)}
        if self._detecting is not None:
            services |= self._detecting.services()
        servers = self.arm.actions(self._outbox, self.at)
        actions = [(name, kind, LyingServer(server, self._faults.lies)) for name, kind, server in servers]
        self._open(connector, pictures=interface.SEEN, actions=actions, services=services)

    def step(self) -> None:
        """Go one period on: let physics happen, look, and publish what happened."""
        with self._outbox.lock:
            self._faults.step(self.since(), self.period_s, self._fingers.held(self.data))
            for part in range(round(self.period_s / CONTROL_S)):
                self.arm.step(self.at + part * CONTROL_S, CONTROL_S)
                mujoco.mj_step(self.model, self.data, round(CONTROL_S / TIMESTEP_S))
                self.judge.watch()
            self.judge.follow()
            self._steps += 1
            self.arm.publish(self._outbox, self.at)
            if self._is_due(LOOK):
                self._look()
                if self._frames is not None:
                    self._frames.publish(self._outbox, self.data, self.at)
            self.arm.report(self.at)  # after the facts that its results rest on
        self._outbox.send()

    def _things(self) -> dict[int, ObjectClass]:
        """What each body of the model is that may be detected."""
        return {
            int(self.model.body(object_name(number)).id): ObjectClass(one.kind, one.colour)
            for number, one in enumerate(self.objects)
        }

    def _look(self) -> None:
        if self._classifier.is_down(self.since()):
            return
        number = self._steps
        look = self._eye.look(self.data, number)
        self._tracks.add(self._classifier.sightings(look.bodies, number), look.is_free)
        things = self._tracks.things()
        self.arm.see(things, self.at)
        fact = {
            "things": things,
            "unsure": self._tracks.unsure(),
            "gripper": gripper_word(self.arm.gripper()),
            "looks": self._tracks.looks,
            "stamp_s": self.at,
        }
        self._outbox.publish(interface.OBJECTS, messages.text(fact))


def gripper_word(grip: Mapping[str, Any]) -> str:
    """Whether the gripper holds something, from its own sensors: `holding`, `empty`, or `unknown` where one presses."""
    if grip["holding"]:
        return "holding"
    return "empty" if max(grip["left_n"], grip["right_n"]) < PRESSED_N else "unknown"
