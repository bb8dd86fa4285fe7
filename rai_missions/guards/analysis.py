# SPDX-License-Identifier: Apache-2.0
"""What checks and proofs ask guards, and states, about the values that they read."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from rai_missions.guards.view import Truth

__all__ = ("Distinctions", "OpenObject", "Sources", "TypeFault", "Types")


class Types(Protocol):
    """What is declared at a guard's place."""

    def kind(self, path: str) -> str | None:
        """The type of what a path reads; None where it is not known."""

    def frame(self, path: str) -> str | None:
        """The frame of a pose's key; None where there is none."""

    def listed(self, path: str) -> Sequence[str] | None:
        """The values that an argument lists; None where it takes any."""


class Sources(Protocol):
    """Where the values of keys come from."""

    def is_robots(self, path: str) -> bool:
        """Whether all values there come from the robot."""

    def constants(self, path: str) -> list[Any] | None:
        """The author's own constants among the robot's values there; None where others write it, or the robot never."""

    def known(self, path: str) -> list[Any]:
        """The constants that a key is known to hold, the initial value of an argument among them."""


class Distinctions(Protocol):
    """What a guard reports to a proof: the values that it distinguishes."""

    def compare(self, path: str, op: str, operand: Any) -> None:
        """The value there is compared with a constant."""

    def join(self, path: str, other: str, op: str = "") -> None:
        """The values of two paths are compared with each other."""

    def measure(self, path: str, other: str, within_m: float) -> None:
        """The distance of two poses is compared with a constant."""

    def ask(self, path: str) -> None:
        """Whether there is a value is asked for."""

    def judge(self, path: str, by: str, aspect: str) -> None:
        """A goal is judged by what is seen, or by a request; what is asked of it is the `aspect`."""

    def sample(self, path: str) -> None:
        """More is distinguished than a few values can represent: nothing that rests on it counts as proved."""


class OpenObject(ABC):
    """An object that is left open, as in a proof: it answers for itself what guards ask of it as a whole."""

    @abstractmethod
    def find(self, question: str, test: Callable[[Mapping[str, Any]], Truth]) -> Truth:
        """What a test of its fields finds; the same question has the same test."""

    @abstractmethod
    def judge(self, aspect: str, wanted: Any, request: Any) -> Truth:
        """What `guards.goal.judged` finds of a goal by it."""


class TypeFault(NamedTuple):
    """Why a guard can never be true or false, by the types of what it reads."""

    place: str
    """JSON pointer from the guard on."""
    sentence: str
