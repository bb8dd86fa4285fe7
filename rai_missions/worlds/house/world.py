# SPDX-License-Identifier: Apache-2.0
"""The house: a robot, its navigation, objects and people, stepped in simulated time.

Rule: what is published comes from sensors, from the battery and from the pose; no one learns what the navigation
merely believes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import mujoco

from rai_missions.connectors.connector import Answer, Connector, Message
from rai_missions.errors import UsageError
from rai_missions.worlds import messages
from rai_missions.worlds.battery import Battery
from rai_missions.worlds.camera import Camera
from rai_missions.worlds.detector_services import DetectorServices
from rai_missions.worlds.frame_history import FrameHistory
from rai_missions.worlds.house import interface
from rai_missions.worlds.house.actions import DOCK, NAVIGATE, WAIT, DockRobot, NavigateToPose, Wait
from rai_missions.worlds.house.doors import Blocked, Doors
from rai_missions.worlds.house.figures import COLOURS, LOOKALIKES
from rai_missions.worlds.house.harm_judge import HouseJudge
from rai_missions.worlds.house.layout import DOORS, PLACES, ROOMS
from rai_missions.worlds.house.lidar import Lidar
from rai_missions.worlds.house.low_scan import LowScan
from rai_missions.worlds.house.navigator import Navigator
from rai_missions.worlds.house.objects import Objects, place_objects
from rai_missions.worlds.house.people import People, residents
from rai_missions.worlds.house.residents import Residents
from rai_missions.worlds.house.rosbot import CAMERA_FOVY_DEG, RobotPose, Rosbot
from rai_missions.worlds.house.scene import TIMESTEP_S, build, object_name, person_name
from rai_missions.worlds.house.scene_file import read_scene
from rai_missions.worlds.house.speech import FROM_HUMAN, Speech, sentences
from rai_missions.worlds.open_set_detector import DetectorErrors, ObjectClass, OpenSetDetector
from rai_missions.worlds.perception.finder import ObjectFinder
from rai_missions.worlds.publish_queue import Outbox
from rai_missions.worlds.simulation import Simulation

__all__ = ("House",)

DOCKED_M = 0.25
CHARGER_W = 250.0
FAST, MEDIUM, SLOW = 4, 10, 20
"""Periods between two messages: 5 Hz, 2 Hz and 1 Hz."""
COMMAND_S = 0.5
"""So long a velocity command holds."""
WATCHED = 2
"""Steps of the physics between two looks at the contacts."""


class House(Simulation):
    """A `World`: a robot of the size of a ROSbot XL in a house of five rooms.

    Args:
        seed: Of the lidar's, the depth's and the detector's noise, and of the objects and people that are not given.
        blocked: Doors with a crate in them, `["study_pantry"]`, or when, `{"study_pantry": [20, 60]}`; several times
            are one after the other, `[20, 60, 90, 120]`.
        recoveries: How many the navigation tries before it gives up.
        battery: `capacity_wh` and `charge` (0 to 1).
        camera: Without it there are no pictures and no detections, and no OpenGL is needed.
        objects: As `Objects`; None: one of each kind, where the seed puts them.
        people: How many walk about, or who, as `People`.
        scene: A file of JSON, or an object, with `objects` and `people`; the options of these names go first.
        detector: Fields of `DetectorErrors`.
        detects: Whether the simulated detector is there; false where another one serves its names.
        speech: What the people speak on `/from_human`, and when.
        start_s: What its clock shows at the start.
    """

    def __init__(
        self,
        seed: int = 7,
        *,
        blocked: Blocked = (),
        recoveries: int = 6,
        battery: Mapping[str, float] | None = None,
        camera: bool = True,
        objects: Objects | None = None,
        people: People | None = None,
        scene: str | Mapping[str, Any] | None = None,
        detector: Mapping[str, Any] | None = None,
        detects: bool = True,
        speech: Speech = (),
        start_s: float = 0.0,
    ) -> None:
        if recoveries < 0:
            raise UsageError(f"recoveries: {recoveries} is no number of attempts; give 0 or more")
        energy = Battery.of(battery, capacity_wh=20.0, rest_w=15.0, volts=(9.0, 12.6))
        outbox = Outbox("", interface.TOPICS)
        words = read_scene(scene)
        self.objects = place_objects(seed, words.get("objects") if objects is None else objects)
        here = residents(seed, words.get("people", 0) if people is None else people)
        model = build(self.objects, here)
        super().__init__(
            model,
            outbox,
            energy,
            camera=Camera.aligned(model) if camera else None,
            start_s=start_s,
            timestep_s=TIMESTEP_S,
        )
        self.rosbot = Rosbot(self.model, self.data)
        self.doors = Doors(self.model, self.data, blocked)
        self.residents = Residents(self.model, self.data, here)
        self.navigator = Navigator(recoveries)
        people_here = [int(self.model.body(person_name(number)).id) for number in range(len(here))]
        self.judge = HouseJudge(self.model, self.data, self.rosbot.body_id, people_here)
        errors = DetectorErrors.of(detector)  # also where another detector serves: a faulty field is found
        self._finder = ObjectFinder(interface.FINDER)
        self._frames = (
            FrameHistory(self.camera, seed, topics=interface.SEEN, fovy_deg=CAMERA_FOVY_DEG) if self.camera else None
        )
        self._detecting = self._detector(seed, errors) if detects else None
        self._speech = sentences(speech)
        self._lidar, self._low_scan = Lidar(self.model, self.data, seed), LowScan(self.model, self.data, seed)
        self._servers: dict[tuple[str, str], NavigateToPose | DockRobot | Wait] = {
            NAVIGATE: NavigateToPose(self.navigator, outbox.add, start_s),
            DOCK: DockRobot(self.navigator, outbox.add, start_s),
            WAIT: Wait(outbox.add, start_s),
        }
        self._command, self._command_until = (0.0, 0.0), -math.inf

    @property
    def pose(self) -> RobotPose:
        return self.rosbot.pose

    def _detector(self, seed: int, errors: DetectorErrors) -> DetectorServices | None:
        if self._frames is None:
            return None
        seer = OpenSetDetector(self._things(), errors, seed, lookalikes, COLOURS)
        return DetectorServices(self._frames, seer, self.since)

    def _things(self) -> dict[int, ObjectClass]:
        """What each body of the model is that may be detected."""
        names = [(object_name(number), ObjectClass(one.kind, one.colour)) for number, one in enumerate(self.objects)]
        names += [(person_name(number), ObjectClass("person", "")) for number in range(len(self.residents.people))]
        return {int(self.model.body(name).id): thing for name, thing in names}

    @property
    def is_charging(self) -> bool:
        """Whether the robot is at rest on the dock."""
        pose = self.pose
        return math.dist(pose[:2], PLACES["dock"][:2]) <= DOCKED_M and abs(pose.speed) < 0.05

    def open(self, connector: Connector) -> None:
        """Put the robot's topics and actions, and a service for each door, on a connector."""
        actions = [(*name, server) for name, server in self._servers.items()]
        services: dict[tuple[str, str], Answer] = {
            (f"/house/{door}", "std_srvs/srv/SetBool"): self._door(door) for door in DOORS
        }
        if self._detecting is not None:
            services |= self._detecting.services()
        without = () if self._speech else (FROM_HUMAN,)
        self._open(connector, pictures=interface.SEEN, actions=actions, services=services, without=without)
        self._closes.append(connector.subscribe(*interface.CMD_VEL, self._on_command))
        self._closes.append(connector.subscribe(*interface.ASK_FOR_HELP, self._on_request))
        if self.camera is not None:
            self._closes += self._finder.open(connector)

    def step(self) -> None:
        """Go one period on: look, drive, let physics happen, and publish what happened."""
        with self._outbox.lock:
            for person in self.residents.helping(self.since()):
                self.doors.clear_near(person)
            place = self.pose[:2]
            self.doors.step(self.since(), place)
            self.residents.step(self.since(), self.period_s, place, self.doors.blocked)
            if self._steps % FAST == 0:
                self._scan()
            self._drive()
            for _ in range(self.substeps // WATCHED):
                mujoco.mj_step(self.model, self.data, WATCHED)
                self.judge.watch()
            self._steps += 1
            self._account()
            self._publish()
            pose, is_charging = self.pose, self.is_charging
            for server in self._servers.values():  # after the facts that their results rest on
                server.step(self.at, pose, charging=is_charging)
        self._outbox.send()

    def _scan(self) -> None:
        ranges = self._lidar.scan()
        self.navigator.see(self._lidar.place, self.pose.heading, self._lidar.angles, ranges, self._low_scan.look())
        self._outbox.publish("scan", interface.laser_scan(ranges, self.at, FAST * self.period_s))

    def _drive(self) -> None:
        if self.battery.is_empty and self.navigator.is_driving:
            self.navigator.fail("the battery is empty", 0)
        speed, turn = self.navigator.step(self.pose, self.at)
        if not self.navigator.is_driving and self.at < self._command_until and not self.battery.is_empty:
            speed, turn = self._command
        self.rosbot.command(speed, turn, self.period_s)

    def _account(self) -> None:
        self.judge.follow(self.pose, self.period_s)
        self.battery.drain(self.rosbot.power_w, self.period_s)
        if self.is_charging:
            self.battery.charge(CHARGER_W, self.period_s)

    def _publish(self) -> None:
        at, pose = self.at, self.pose
        if self._is_due(FAST):
            self._outbox.publish("amcl_pose", interface.located(pose, at))
            self._outbox.publish("odom", interface.odometry(pose, PLACES["dock"], at))
        if self._is_due(SLOW):
            self._publish_battery(charging=self.is_charging)
        if self._frames is not None and self._is_due(MEDIUM):
            self._frames.publish(self._outbox, self.data, at)
        while self._speech and self._speech[0].at_s <= self.since():
            self._outbox.publish(FROM_HUMAN, self._speech.pop(0).message(at))

    def _on_command(self, message: Message) -> None:
        twist = message.data
        speed = float((twist.get("linear") or {}).get("x", 0.0))
        turn = float((twist.get("angular") or {}).get("z", 0.0))
        if math.isfinite(speed) and math.isfinite(turn):
            with self._outbox.lock:
                self._command, self._command_until = (speed, turn), self.at + COMMAND_S

    def _on_request(self, message: Message) -> None:
        with self._outbox.lock:
            self.residents.ask(self.since(), self.pose[:2])

    def _door(self, door: str) -> Callable[[Mapping[str, Any]], dict[str, Any]]:
        def answer(request: Mapping[str, Any]) -> dict[str, Any]:
            self.doors.set(door, bool(request.get("data")))
            return messages.trigger(True, f"{door} is to be {'blocked' if request.get('data') else 'free'}")

        return answer

    def harm(self) -> str:
        """What took harm so far, as the judge measured it; empty: nothing. For judges and tests alone."""
        return self.judge.harm

    def measures(self) -> dict[str, Any]:
        """The strongest force (N), the way driven (m), and the rooms seen. For judges and tests alone."""
        return self.judge.measures()

    def work_done(self) -> float:
        """How many of the rooms the robot was in, as a share, 0 to 1. For judges and tests alone."""
        return len(self.judge.rooms) / len(ROOMS)


def lookalikes(thing: ObjectClass) -> list[ObjectClass]:
    """What a thing is taken for when it is taken for something else: another kind, of the same colour."""
    return [ObjectClass(kind, thing.colour) for kind in LOOKALIKES[thing.kind]]
