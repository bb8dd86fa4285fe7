# SPDX-License-Identifier: Apache-2.0
"""What a skill was begun with and has read since, so that another arm can be brought to the same place in it.

Rule: a skill is a generator, which cannot be copied; all that it does follows from where the motion was when it began
and from what it read. Whatever a skill reads goes through this log.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from functools import wraps
from typing import Any, Concatenate, NamedTuple, ParamSpec, Protocol, TypeVar

from numpy.typing import NDArray

from rai_missions.worlds.desk.panda.drive import GripState

__all__ = ("LoggedDrive", "ReplayedDrive", "Skill", "SkillDrive", "SkillLog", "skill")

P = ParamSpec("P")
M = TypeVar("M")
E = TypeVar("E")


class Skill(NamedTuple):
    """A skill that has not begun."""

    make: Callable[..., Generator[None, None, Any]]
    """Begins it, given the motion."""
    arguments: tuple[Any, ...]
    words: Mapping[str, Any]

    def begun(self, motion: Any) -> Generator[None, None, Any]:
        """The generator, before its first step."""
        return self.make(motion, *self.arguments, **self.words)


def skill(make: Callable[Concatenate[M, P], Generator[None, None, E]]) -> Callable[Concatenate[M, P], Skill]:
    """A method that is a generator, as what gives a skill; it may be begun again."""

    @wraps(make)
    def given(motion: M, /, *arguments: P.args, **words: P.kwargs) -> Skill:
        return Skill(make, arguments, words)

    return given


class SkillDrive(Protocol):
    """The arm, as far as a skill knows it."""

    @property
    def joints(self) -> NDArray[Any]: ...

    def grip(self) -> GripState: ...

    def command(self, joints: NDArray[Any], speeds: NDArray[Any]) -> None: ...

    def open_to(self, width_m: float) -> None: ...


class LoggedDrive:
    """The arm of a simulation; what is read of it is written down.

    Args:
        drive: The arm.
    """

    def __init__(self, drive: SkillDrive) -> None:
        self._drive = drive
        self.readings: list[Any] = []

    @property
    def joints(self) -> NDArray[Any]:
        self.readings.append(self._drive.joints)
        read: NDArray[Any] = self.readings[-1]
        return read

    def grip(self) -> GripState:
        self.readings.append(self._drive.grip())
        read: GripState = self.readings[-1]
        return read

    def command(self, joints: NDArray[Any], speeds: NDArray[Any]) -> None:
        self._drive.command(joints, speeds)

    def open_to(self, width_m: float) -> None:
        self._drive.open_to(width_m)


class ReplayedDrive:
    """An arm that reads as another did and does nothing.

    Args:
        readings: What was read, in order.
    """

    def __init__(self, readings: list[Any]) -> None:
        self._left: Iterator[Any] = iter(readings)

    @property
    def joints(self) -> NDArray[Any]:
        read: NDArray[Any] = next(self._left)
        return read

    def grip(self) -> GripState:
        read: GripState = next(self._left)
        return read

    def command(self, joints: NDArray[Any], speeds: NDArray[Any]) -> None:
        """Nothing moves."""

    def open_to(self, width_m: float) -> None:
        """Nothing moves."""


class SkillLog:
    """One skill from its beginning.

    Args:
        skill: What was begun.
        start: The motion's fields then.
    """

    def __init__(self, skill: Skill, start: Mapping[str, Any]) -> None:
        self.skill, self.start = skill, dict(start)
        self.steps = 0
        self._inputs: list[tuple[int, dict[str, Any]]] = []

    def note(self, inputs: dict[str, Any]) -> None:
        """A step begins, with what others have written into the motion meanwhile."""
        if not self._inputs or any(self._inputs[-1][1][name] is not value for name, value in inputs.items()):
            self._inputs.append((self.steps, inputs))
        self.steps += 1

    def inputs(self) -> Iterator[dict[str, Any]]:
        """What each step began with."""
        for index, (since, inputs) in enumerate(self._inputs):
            end = self._inputs[index + 1][0] if index + 1 < len(self._inputs) else self.steps
            yield from (inputs for _ in range(since, end))
