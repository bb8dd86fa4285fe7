# SPDX-License-Identifier: Apache-2.0
"""What the arm can do, one thing at a time: move the gripper, take a thing, set it down, go home.

Rule: it plans with what the camera measured and its own sensors; a thing is held only if both fingers press on it after
the lift. A skill is a generator: it does what is due in a period of 10 ms and yields, or returns how it ended.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterable, Mapping, Sequence
from itertools import islice
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from rai_missions.worlds.desk.footprints import SeenThing, things
from rai_missions.worlds.desk.grasps import Grasp, HeldThing, grasps, releases, standing_on, too_wide
from rai_missions.worlds.desk.kinematics import TILTS, Joints, Kinematics, ToolPose, Unreachable
from rai_missions.worlds.desk.panda.drive import PandaDrive
from rai_missions.worlds.desk.panda.model import HOME, MAX_WIDTH_M, TIP_BELOW_TCP_M
from rai_missions.worlds.desk.path import across, follow, straight
from rai_missions.worlds.desk.pushes import PUSH_OPENING_M, Push, pushes
from rai_missions.worlds.desk.skill_log import LoggedDrive, ReplayedDrive, Skill, SkillDrive, SkillLog, skill
from rai_missions.worlds.desk.trajectory import CONTROL_S, Trajectory
from rai_missions.worlds.desk.ways import LIFT_M, WayPlanner, WayStart, leaning, transit_height

__all__ = ("Motion", "SkillEnd", "ThingPose")

FINGER_MPS = 0.2
"""How fast the fingers' distance changes."""
SQUEEZE_M = -0.02
IN_HAND_M = 0.03
"""A thing that is seen so near to the TCP while something is held is what is held."""
HANGS_M = (0.04, 0.08)
"""How far what is held reaches below the TCP and to the sides, where it is not known better."""
CLOSED_S, LOOK_S = 0.1, 3.0
"""How long the fingers rest on what they have closed on; how long a new look may take."""
SETTLED_RAD, SETTLE_S = 0.003, 0.3
LOST = 5
"""Periods without a force on both fingers after which what was held is lost."""
ATTEMPTS = 8
"""Ways to take or release a thing that are tried for reach."""
RELEASE_M = 0.0015
"""How much higher a thing is released than it is to stand."""
PUSHES = 3


class ThingPose(NamedTuple):
    """Where the centre of a thing is, or is to be."""

    x: float
    y: float
    z: float
    yaw: float


class SkillEnd(NamedTuple):
    """How a skill ended."""

    end: Literal["succeeded", "failed", "canceled"]
    reason: str = ""
    """A code: cannot_reach, no_room, too_wide, covered, not_held, dropped, nothing_held, holding, not_seen."""
    message: str = ""


Course = Generator[None, None, SkillEnd]
"""A skill under way."""
OWN = ("_joints", "_pose", "_came", "_width", "_held")
"""What a skill writes."""
GIVEN = ("_seen", "_looks", "_is_unwanted")
"""What it reads that others write."""


class SkillStopped(Exception):
    """The arm has come to rest because it was asked to."""


class SkillFailure(Exception):
    """A skill ends without success: a code, and a sentence."""

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason


class Motion:
    """The arm's skills.

    Args:
        drive: The arm.
        kinematics: Its own.
    """

    LEADS_OUT: ClassVar = {"_skill": lambda: None}
    """A skill is no value; `resume_copy` brings the copy to the same place in it."""

    def __init__(self, drive: PandaDrive, kinematics: Kinematics) -> None:
        self._logged = LoggedDrive(drive)
        self._drive: SkillDrive = self._logged
        self._kinematics, self._planner = kinematics, WayPlanner(kinematics)
        self._joints: Joints = np.array(HOME)
        self._pose = self._present()
        self._came: Sequence[Joints] = ()
        """The knots of the last way, from its end."""
        self._width = MAX_WIDTH_M
        self._held: HeldThing | None = None
        self._seen: Sequence[SeenThing] = ()
        self._looks = 0
        self._skill: Course | None = None
        self._log: SkillLog | None = None
        self._is_unwanted = False
        self.ending: SkillEnd | None = None
        """Of the last skill; None while one runs."""

    @property
    def is_busy(self) -> bool:
        return self._skill is not None

    @property
    def pose(self) -> ToolPose:
        """Where the gripper is meant to be."""
        return self._pose

    def see(self, fact: Sequence[Mapping[str, Any]]) -> None:
        """Take note of the things as the camera measured them."""
        self._seen = things(fact)
        self._looks += 1

    def begin(self, skill: Skill) -> None:
        """Start one; the arm must be free."""
        self._is_unwanted, self.ending = False, None
        self._logged.readings.clear()
        self._log = SkillLog(skill, {name: getattr(self, name) for name in OWN})
        self._skill = skill.begun(self)

    def stop(self) -> None:
        """Come to rest within the limits of the joints; the skill ends canceled."""
        self._is_unwanted = True

    def step(self) -> None:
        """Do what is due in one control period."""
        if self._skill is None or self._log is None:
            return
        self._log.note({name: getattr(self, name) for name in GIVEN})
        try:
            next(self._skill)
        except StopIteration as over:
            self._end(over.value)
        except SkillStopped:
            self._end(SkillEnd("canceled", "", "canceled"))
        except SkillFailure as refused:
            self._end(SkillEnd("failed", refused.reason, str(refused)))
        except Unreachable as unreachable:
            self._end(SkillEnd("failed", "cannot_reach", str(unreachable)))

    def _end(self, ending: SkillEnd) -> None:
        self._skill, self._log, self.ending = None, None, ending
        self._logged.readings.clear()

    def resume_copy(self) -> None:
        """Do again, in a copy, what the skill under way has done, with what it read, and without an arm."""
        log = self._log
        if log is None:
            return
        present = {name: getattr(self, name) for name in (*OWN, *GIVEN)}
        self._put(log.start)
        self._skill, self._drive = log.skill.begun(self), ReplayedDrive(self._logged.readings)
        for inputs in log.inputs():
            self._put(inputs)
            next(self._skill)
        self._drive = self._logged
        self._put(present)

    def _put(self, fields: Mapping[str, Any]) -> None:
        for name, value in fields.items():
            setattr(self, name, value)

    # ── The skills ────────────────────────────────────────────────────────────────────────────────────────────────

    @skill
    def move(self, pose: ToolPose, *, before: str = "as_is", after: str = "as_is", grasp: bool = False) -> Course:
        """Bring the TCP to a pose, over what stands.

        Args:
            pose: The pose of the TCP; where it leans by nothing, a lean is chosen that reaches it.
            before: The gripper before it moves: `open`, `closed` or `as_is`.
            after: The gripper once it is there.
            grasp: Whether it must hold something at the end.
        """
        yield from self._set_gripper(before)
        leans = TILTS if pose.tilt == 0.0 else (pose.tilt,)
        yield from self._go(self._way([Grasp(pose._replace(tilt=lean), self._width) for lean in leans], ())[0])
        yield from self._set_gripper(after)
        if grasp and not self._drive.grip().is_holding:
            raise SkillFailure("not_held", "the fingers closed on nothing")
        return SkillEnd("succeeded")

    @skill
    def home(self) -> Course:
        """Raise the gripper and go where the cameras see the desk."""
        yield from self._go_home()
        return SkillEnd("succeeded")

    @skill
    def pick(self, name: str, place: ThingPose) -> Course:
        """Take a thing from above.

        Args:
            name: What it is called in what was seen; one that was not seen is taken for a cube.
            place: Where its centre is.
        """
        if self._drive.grip().is_holding:
            raise SkillFailure("holding", f"the gripper holds something already, so it cannot take {name}")
        self._held = None
        target = self._thing(name, place)
        for left in reversed(range(PUSHES + 1)):
            others = self._others(target)
            self._check(target, others)
            ways = list(islice(grasps(target, others), ATTEMPTS))
            if ways:
                break
            if not left:
                raise SkillFailure(
                    "no_room", f"there is no room for the fingers next to {name}, also after it was pushed"
                )
            target = yield from self._free(target, others)
        way, grasp = self._way(leaning(ways), [*others, target])  # it comes down on the target from above it, too
        yield from self._go(way, opening=grasp.opening_m)
        yield from self._close()
        self._held = HeldThing(target, grasp.pose)
        yield from self._lift()
        if not self._drive.grip().is_holding:
            self._held = None
            yield from self._go_home()
            raise SkillFailure("not_held", f"after the lift the fingers do not press on {name}")
        return SkillEnd("succeeded")

    @skill
    def place(self, name: str, place: ThingPose) -> Course:
        """Set down what is held, from above, open the fingers, and go home.

        Args:
            name: What it is called.
            place: Where its centre is to be.
        """
        if not self._drive.grip().is_holding:
            raise SkillFailure("nothing_held", f"the gripper does not hold {name}")
        held = self._held or HeldThing(self._thing(name, ThingPose(*self._pose[:4])), self._pose)
        others = self._others(held.thing)
        goal = place._replace(z=place.z + RELEASE_M)
        ways = list(islice(releases(held, *goal, others), ATTEMPTS))
        if not ways:
            raise SkillFailure("no_room", f"there is no room for the fingers where {name} is to be set down")
        way, release = self._way(leaning(ways), others, held)
        try:
            yield from self._go(way, holding=name)
        except SkillFailure:
            yield from self._go_home()
            raise
        yield from self._open(release.opening_m)
        self._held = None
        yield from self._go_home()
        return SkillEnd("succeeded")

    # ── What they are made of ─────────────────────────────────────────────────────────────────────────────────────

    def _present(self) -> ToolPose:
        """Where the set-points are, the hand's turn counted from the bearing, so that it changes without a leap."""
        pose = self._kinematics.pose(self._joints)
        bearing = math.atan2(pose.y, pose.x)
        return pose._replace(yaw=bearing + math.remainder(pose.yaw - bearing, math.tau))

    def _thing(self, name: str, place: ThingPose) -> SeenThing:
        """What was seen under a name, at the place given."""
        for one in self._seen:
            if one.name == name:
                return one._replace(x=place.x, y=place.y, z=place.z, yaw=place.yaw)
        return SeenThing(name, "cube", *place, (0.044, 0.044, 0.044))

    def _standing(self) -> list[SeenThing]:
        """Everything that was seen, but for what is in the hand."""
        if not self._drive.grip().is_holding:
            return list(self._seen)
        name = self._held.thing.name if self._held is not None else ""
        pose = self._pose
        return [
            one for one in self._seen if one.name != name and math.dist((one.x, one.y, one.z), pose[:3]) > IN_HAND_M
        ]

    def _others(self, target: SeenThing) -> list[SeenThing]:
        """Everything that was seen, but for one thing."""
        return [one for one in self._seen if one.name != target.name]

    @staticmethod
    def _check(target: SeenThing, others: Sequence[SeenThing]) -> None:
        """Whether a thing can be taken at all.

        Raises:
            SkillFailure: It cannot.
        """
        if too_wide(target):
            raise SkillFailure("too_wide", f"{target.name} is wider than the gripper opens")
        cover = standing_on(target, others)
        if cover is not None:
            raise SkillFailure("covered", f"{cover.name} stands on {target.name}")

    def _way(
        self, ends: Iterable[Grasp], others: Sequence[SeenThing], held: HeldThing | None = None
    ) -> tuple[Trajectory, Grasp]:
        """The way to the first of several ends that the arm can reach.

        Raises:
            Unreachable: It can reach none.
        """
        hanging = TIP_BELOW_TCP_M, 0.0
        if held is not None:
            hanging = held.below_m, held.reach_m
        elif self._drive.grip().is_holding:
            hanging = HANGS_M
        same = math.tau if held is not None else math.pi
        return self._planner.first(self._start, ends, others or self._standing(), hanging, same)

    @property
    def _start(self) -> WayStart:
        return WayStart(self._pose, self._joints)

    def _go(self, way: Trajectory, *, opening: float | None = None, holding: str = "") -> Generator[None, None, None]:
        """Follow a way, opening or closing the fingers meanwhile.

        Raises:
            SkillStopped: It was stopped, and is at rest.
            SkillFailure: What it held is lost.
        """
        lost, is_stopping = 0, False
        while not way.is_over:
            if (self._is_unwanted or lost > LOST) and not is_stopping:
                is_stopping = True
                way.stop()
                continue
            before = self._joints
            self._joints = way.step()
            self._drive.command(self._joints, (self._joints - before) / CONTROL_S)
            if opening is not None:
                self._fingers(opening)
            if holding:
                lost = lost + 1 if lost > LOST or not self._drive.grip().is_holding else 0
            yield
        self._drive.command(self._joints, np.zeros(7))
        self._pose, self._came = self._present(), (() if is_stopping else way.knots[-2::-1])
        for _ in range(round(SETTLE_S / CONTROL_S)):
            is_opening = opening is not None and not self._fingers(opening)
            if not is_opening and np.abs(self._drive.joints - self._joints).max() < SETTLED_RAD:
                break
            yield
        if self._is_unwanted:
            raise SkillStopped
        if lost > LOST:
            self._held = None
            raise SkillFailure("dropped", f"{holding} was lost on the way")

    def _go_home(self) -> Generator[None, None, None]:
        """Straight up, over what stands, and to where the cameras see the desk."""
        home = self._kinematics.pose(np.array(HOME))
        height = transit_height(self._pose, home, self._standing())
        try:
            knots = across(self._pose, home, height)
            way = follow(self._kinematics, knots, self._joints, end=np.array(HOME))
        except Unreachable:
            yield from self._go(self._planner.back_out(self._joints, self._came, height))
            way = Trajectory([self._joints, np.array(HOME)], [0.0])
        yield from self._go(way, opening=MAX_WIDTH_M)

    def _lift(self) -> Generator[None, None, None]:
        """Straight up, so that it is seen whether the thing comes along."""
        up = self._pose.at(z=self._pose.z + LIFT_M)
        try:
            way = follow(self._kinematics, straight(self._pose, up), self._joints)
        except Unreachable:
            way = self._planner.back_out(self._joints, self._came, up.z)
        yield from self._go(way)

    def _free(self, target: SeenThing, others: Sequence[SeenThing]) -> Generator[None, None, SeenThing]:
        """Push a thing out from between its neighbours, and look where it is then.

        Raises:
            SkillFailure: No push frees it, or it is not seen afterwards.
        """
        for push in pushes(target, others):
            try:
                ways = self._push_ways(push)
                break
            except Unreachable:
                continue
        else:
            raise SkillFailure(
                "no_room", f"there is no room for the fingers next to {target.name}, and no push makes it"
            )
        yield from self._open(PUSH_OPENING_M)
        yield from self._go(ways)
        end = push.end._replace(yaw=self._pose.yaw, tilt=self._pose.tilt)
        yield from self._go(follow(self._kinematics, straight(self._pose, end), self._joints, slowly=True))
        yield from self._go_home()
        looks = self._looks
        for _ in range(round(LOOK_S / CONTROL_S)):
            if self._looks >= looks + 3:
                break
            if self._is_unwanted:
                raise SkillStopped
            yield
        for one in self._seen:
            if one.name == target.name:
                return one
        raise SkillFailure("not_seen", f"{target.name} is not seen any more after it was pushed")

    def _push_ways(self, push: Push) -> Trajectory:
        """The way to where a push begins; its end is reachable too."""
        way, grasp = self._way([Grasp(push.start, 0.0)], ())
        end = push.end._replace(yaw=grasp.pose.yaw)
        self._kinematics.reach(end, way.end)
        return way

    def _set_gripper(self, to: str) -> Generator[None, None, None]:
        if to == "open":
            yield from self._open(MAX_WIDTH_M)
            self._held = None
        elif to == "closed":
            yield from self._close()

    def _fingers(self, to: float) -> bool:
        """Move the fingers' set-point on; whether it is there."""
        step = FINGER_MPS * CONTROL_S
        self._width += max(-step, min(step, to - self._width))
        self._drive.open_to(self._width)
        return abs(self._width - to) < 1e-9

    def _open(self, to: float) -> Generator[None, None, None]:
        """Bring the fingers so far apart, where nothing is between them that keeps them farther."""
        self._width = self._drive.grip().width_m
        while not self._fingers(to):
            yield
        for _ in range(round(CLOSED_S / CONTROL_S)):
            yield

    def _close(self) -> Generator[None, None, None]:
        """Close the fingers until they rest on something, or on each other."""
        resting, last = 0, self._drive.grip().width_m
        self._width = last
        while resting * CONTROL_S < CLOSED_S:
            is_there = self._fingers(SQUEEZE_M)
            width = self._drive.grip().width_m
            is_still = abs(width - last) < 2e-5 and (is_there or self._width < width - 0.004)
            resting, last = (resting + 1 if is_still else 0), width
            if self._is_unwanted:
                raise SkillStopped
            yield
