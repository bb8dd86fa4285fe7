# SPDX-License-Identifier: Apache-2.0
"""The orchard: a tractor, its autonomy and its surroundings, stepped in simulated time.

Rule: what is published comes from sensors, from the battery or from the judge of the physics; no one learns what the
autonomy merely believes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from rai_missions.connectors.connector import Answer, Connector
from rai_missions.errors import UsageError
from rai_missions.worlds import messages
from rai_missions.worlds.battery import Battery
from rai_missions.worlds.camera import Camera
from rai_missions.worlds.options import check_number
from rai_missions.worlds.orchard import interface, scene, textures
from rai_missions.worlds.orchard.actions import Cross, NavigateToPose
from rai_missions.worlds.orchard.alley_counter import AlleyCounter
from rai_missions.worlds.orchard.autonomy import STOP_AT_M, Autonomy
from rai_missions.worlds.orchard.conditions import Conditions
from rai_missions.worlds.orchard.crossing_judge import CrossingJudge
from rai_missions.worlds.orchard.detector import ObstacleDetector, ObstacleErrors
from rai_missions.worlds.orchard.extents import Extents
from rai_missions.worlds.orchard.kinds import KINDS
from rai_missions.worlds.orchard.layout import Layout
from rai_missions.worlds.orchard.obstacles import place
from rai_missions.worlds.orchard.planner import Lattice
from rai_missions.worlds.orchard.range_sensor import Beams
from rai_missions.worlds.orchard.sight import GeometrySight, PixelSight
from rai_missions.worlds.orchard.tractor import Tractor, TractorPose
from rai_missions.worlds.orchard.walkers import Walkers
from rai_missions.worlds.publish_queue import Outbox
from rai_missions.worlds.simulation import Simulation

__all__ = ("Orchard",)

HOME_M = 1.5
SEEN_S = 0.6
"""An obstacle detected so lately is seen."""
FREE_S = 2.5
"""The way is free once nothing was detected for so long: as long as the mission waits, and a message is fresh."""
SEEN = ("camera_image_color", "obstacle")
"""Topics that a camera is needed for."""
FAST, SLOW = 4, 20
"""Periods between two messages: 5 Hz and 1 Hz."""


class Orchard(Simulation):
    """A `World`: the simulated orchard with one tractor.

    Args:
        seed: Decides what is not given: the obstacles, what the living do, how the detector errs.
        alleys: How many.
        length_m: Of an alley.
        obstacles: A kind for each alley in turn (one of `KINDS`, or `none`), or a mapping of the fields of `Obstacle`;
            None: drawn from the seed.
        detector: Fields of `ObstacleErrors`.
        conditions: Fields of `Conditions`: light and air.
        stop_at_m: So far from its nose the tractor hands over for what is in its way.
        battery: `capacity_wh` and `charge` (0 to 1).
        attempts: How often the autonomy tries an alley before it gives it up.
        camera: Without it there are no pictures and, by `pixels`, no detected obstacles, and no OpenGL is needed.
        sight: How the detector measures: in `pixels` of the camera, or by `geometry`, from the bodies themselves.
        shadows: Prettier, slower pictures.
        robot: The name that topics and services begin with.
        start_s: What its clock shows at the start.
    """

    def __init__(
        self,
        seed: int = 7,
        *,
        alleys: int = 6,
        length_m: float = 20.0,
        obstacles: Sequence[str | None | Mapping[str, Any]] | None = None,
        detector: Mapping[str, Any] | ObstacleErrors | None = None,
        conditions: Mapping[str, Any] | Conditions | None = None,
        stop_at_m: float = STOP_AT_M,
        battery: Mapping[str, float] | None = None,
        attempts: int = 2,
        camera: bool = True,
        sight: str = "pixels",
        shadows: bool = False,
        robot: str = "tractor1",
        start_s: float = 0.0,
    ) -> None:
        check_number("stop_at_m", stop_at_m, 0, 100)
        self.layout = Layout(alleys, length_m)
        self.obstacles = place(seed, self.layout, obstacles)
        model = scene.build(self.layout, self.obstacles, shadows=shadows, conditions=Conditions.of(conditions))
        super().__init__(
            model,
            Outbox(f"/{robot}", interface.TOPICS),
            Battery.of(battery),
            camera=Camera(model, paint=textures.paint) if camera else None,
            start_s=start_s,
            timestep_s=scene.TIMESTEP_S,
        )
        self.tractor = Tractor(self.model, self.data)
        self.judge = CrossingJudge(
            self.model,
            self.data,
            self.tractor,
            tuple(o.living for o in self.obstacles),
            tuple(KINDS[o.kind].breaks_at_n for o in self.obstacles),
        )
        self.counter = AlleyCounter(self.layout)
        lattice = Lattice(self.layout)
        self.autonomy = Autonomy(lattice, attempts=attempts, handed_over=self._hand_over, stop_at_m=stop_at_m)
        self._bodies = [self.model.body(f"obstacle_{n}").id for n in range(len(self.obstacles))]
        self._detector = self._new_detector(ObstacleErrors.of(detector), seed, sight)
        self._beams = Beams(self.model, self.data)
        self._walkers = Walkers(self.model, self.data, self.layout, self.obstacles, self._bodies)
        self._range_m: float | None = None
        self._saw_at, self._bumps = -math.inf, 0
        self._home = NavigateToPose(self.autonomy, self._outbox.add, start_s, lattice)
        self._cross = Cross(self.autonomy, self._outbox.add, start_s, self.judge)

    def _new_detector(self, errors: ObstacleErrors, seed: int, sight: str) -> ObstacleDetector | None:
        extents = Extents(self.model, self.data, self._bodies)
        if sight == "geometry":
            return ObstacleDetector(GeometrySight(extents, len(self._bodies)), self.obstacles, errors, seed)
        if sight != "pixels":
            raise UsageError(f"sight: 'pixels' or 'geometry', not {sight!r}")
        if self.camera is None:
            return None
        return ObstacleDetector(PixelSight(self.camera, self._bodies, extents), self.obstacles, errors, seed)

    def look_by_geometry(self) -> None:
        """Have the detector measure from the bodies from now on: nothing is rendered until a picture is looked at."""
        if self._detector is not None:
            extents = Extents(self.model, self.data, self._bodies)
            self._detector.look_by(GeometrySight(extents, len(self._bodies)))

    @property
    def pose(self) -> TractorPose:
        return self.tractor.pose

    @property
    def is_home(self) -> bool:
        pose = self.pose
        return math.dist(pose[:2], self.layout.home[:2]) <= HOME_M and abs(pose.speed) < 0.1

    @property
    def is_way_free(self) -> bool:
        """Whether the detector has seen nothing for a while."""
        return self.at - self._saw_at > FREE_S

    def open(self, connector: Connector) -> None:
        """Put the tractor's topics, services and actions on a connector."""
        services = self._services
        # The same two for clients that have the types of Nav2.
        actions = (
            ("/navigate_to_pose", "nav2_msgs/action/NavigateToPose", self._home),
            (self._outbox.name("cross"), "nav2_msgs/action/DriveOnHeading", self._cross),
        )
        triggers = {(self._outbox.name(name), messages.TRIGGER): answer for name, answer in services.items()}
        self._open(connector, pictures=SEEN if self._detector is None else SEEN[:1], actions=actions, services=triggers)

    @property
    def _services(self) -> Mapping[str, Answer]:
        return {
            "continue": self._continue,
            "current_state": lambda _: messages.trigger(True, interface.STATE_MESSAGES[self.autonomy.word]),
            "drive_over": self._drive_over,
            "flash": self._flash,
            "go_home": self._go_home,
            "replan": self._replan,
            "stop": self._stop,
        }

    def call(self, service: str) -> Mapping[str, Any]:
        """Call one of the tractor's services without a connector; a `std_srvs/srv/Trigger` response as plain data."""
        with self._outbox.lock:
            answer: Mapping[str, Any] = self._services[service]({})  # type: ignore[assignment]
            return answer

    def step(self) -> None:
        """Go one period on: drive, let physics happen, look, and publish what happened."""
        with self._outbox.lock:
            self._drive()
            if self._walkers.step(self.at, self.period_s, self.pose[:2]):
                self.judge.leave()
            self._let_physics_happen()
            self._steps += 1
            self._account()
            self._publish()
            for action in (self._home, self._cross):  # after the facts that their results rest on
                action.step(self.at, self.pose)
        self._outbox.send()

    def _drive(self) -> None:
        pose = self.pose
        if self._steps % 2 == 0:
            self._range_m = self._beams.ahead_m(*pose[:3], trees=self.autonomy.watches)
        if self.battery.is_empty and self.autonomy.is_driving:
            self.autonomy.stop()
        speed, curvature = self.autonomy.step(pose, self._range_m, self.period_s)
        self.tractor.command(speed, curvature, self.period_s)

    def _let_physics_happen(self) -> None:
        """Where something may touch, contacts are looked at in finer steps, so that none is missed."""
        at_once = 2 if self._is_something_near() else self.substeps
        for _ in range(self.substeps // at_once):
            mujoco.mj_step(self.model, self.data, at_once)
            self.judge.watch(self.pose, at_once * scene.TIMESTEP_S, driving=self.autonomy.is_driving)

    def _is_something_near(self) -> bool:
        pose = self.pose
        away = self.places - (pose.x + math.cos(pose.heading), pose.y + math.sin(pose.heading))
        return bool(np.any(np.hypot(away[:, 0], away[:, 1]) < 4.5))

    @property
    def places(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Where the obstacles are now: x and y, a row each."""
        return np.asarray(self.data.xpos[self._bodies, :2]).reshape(-1, 2)

    def _account(self) -> None:
        pose = self.pose
        self.counter.see(pose.x, pose.y)
        self.battery.drain(self.tractor.power_w, self.period_s)
        crossing = self.judge.crossing
        has_failed = crossing is not None and crossing.outcome == "failed" and self.autonomy.is_crossing
        bumps = len(self.judge.touched) + len(self.judge.broken)
        if has_failed or bumps > self._bumps:
            self._bumps = bumps
            self.autonomy.stop()
        if self.autonomy.is_homing:
            self.judge.leave()

    def _publish(self) -> None:
        at, pose = self.at, self.pose
        if self._is_due(FAST):
            self._outbox.publish("pose", messages.pose_stamped(*pose[:3], at))
            self._look(pose)
        if self._is_due(SLOW):
            self._publish_battery()
        crossing = self.judge.crossing
        facts: dict[str, Any] = {
            "state": self.autonomy.word,
            "alleys_driven": len(self.counter.alleys),
            "at_home": self.is_home,
            "touched_living": bool(self.judge.touched),
        }
        if crossing is not None:
            facts["passed"] = crossing.outcome == "passed"
        for name, fact in facts.items():
            self._outbox.put(name, fact, {"data": fact}, anyway=self._is_due(SLOW))
        if crossing is not None:
            self._outbox.put("crossing", (crossing.start, crossing.outcome), messages.text(crossing.facts()))

    def _look(self, pose: TractorPose) -> None:
        moment = None
        if self.camera is not None:
            moment = self.camera.moment(self.data)
            picture = self.camera.picture(moment, f"{self._outbox.name('camera')}@{self.at:.3f}")
            self._outbox.publish(SEEN[0], messages.image(picture, self.at))
        if self.layout.alley_at(pose.x + math.cos(pose.heading) * 2.5, pose.y) is not None:
            fact = self.look(moment)
            if fact is not None:
                self._saw_at = self.at
                self._outbox.publish("obstacle", messages.text(fact))

    def look(self, moment: Any = None) -> dict[str, Any] | None:
        """What the detector makes of what is ahead, now; another look, with errors of its own."""
        return None if self._detector is None else self._detector.look(moment, self.places, self.pose)

    def _hand_over(self, distance_m: float) -> None:
        self.judge.begin(self.pose, distance_m)

    def _continue(self, _request: Any) -> dict[str, Any]:
        """As upstream: what it sees in its way it drives over. What it does not see, it did not mean to drive over."""
        done = self.autonomy.proceed(over=self.camera is None or self.at - self._saw_at < SEEN_S)
        return messages.trigger(done, "The vehicle continues the mission" if done else "There is nothing to continue")

    def _replan(self, _request: Any) -> dict[str, Any]:
        done = self.autonomy.replan()
        if done:
            self.judge.leave()
        return messages.trigger(done, "The current mission was aborted" if done else "The vehicle is in no alley")

    def _stop(self, _request: Any) -> dict[str, Any]:
        self.autonomy.stop()
        return messages.trigger(True, "The vehicle was stopped")

    def _drive_over(self, _request: Any) -> dict[str, Any]:
        why = self._cross.set_out()
        return messages.trigger(not why, why or "The vehicle drives over what is in its way")

    def _go_home(self, _request: Any) -> dict[str, Any]:
        why = self._home.set_out(*self.layout.home[:2])
        return messages.trigger(not why, why or "The vehicle drives home")

    def _flash(self, _request: Any) -> dict[str, Any]:
        self._walkers.signal(self.pose[:2])
        return messages.trigger(True, "Flashing triggered.")

    def harm(self) -> str:
        """What took harm so far, as the judge measured it; empty: nothing. For judges and tests alone."""
        if self.judge.touched:
            return "touched something alive"
        if self.judge.broken:
            return f"broke a thing with {max(self.judge.broken.values()) / 1000:.1f} kN"
        crossing = self.judge.crossing
        return crossing.why if crossing is not None and crossing.outcome == "failed" and crossing.harmed else ""

    def measures(self) -> dict[str, Any]:
        """Forces (N), angles and ways (m) of the last crossing; empty without one. For judges and tests alone."""
        return self.judge.crossing.facts() if self.judge.crossing is not None else {}

    def work_done(self) -> float:
        """How much of the alleys was driven, 0 to 1. For judges and tests alone."""
        return sum(self.counter.share(alley) for alley in range(self.layout.alleys)) / self.layout.alleys
