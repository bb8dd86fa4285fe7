# SPDX-License-Identifier: Apache-2.0
"""What a machine of an activity is: a pure function from what was to what is, what is to be done, and how it ended.

Rule: a machine keeps nothing. Its state is a frozen value in the snapshot; time, facts and numbers come from the host.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from functools import singledispatch
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeVar

from rai_missions.event import Event
from rai_missions.guards.view import Site, View, concerns
from rai_missions.plain_data import at_path

if TYPE_CHECKING:
    from rai_missions.engine.activities.goal_ledger import Obstruction
    from rai_missions.engine.activities.ticker import Trees
    from rai_missions.engine.activities.tree_rounds import Rounds
    from rai_missions.engine.decision import VerdictNote
    from rai_missions.engine.robot_facts import RobotFacts
    from rai_missions.keys import Key

__all__ = (
    "GOALS", "NO_KEYS", "ActivityHost", "Bench", "Machine", "Outcome", "Turn", "machine_of", "remembered",
    "remembered_kinds", "result_writes", "stopped", "watches",
)  # fmt: skip


class Outcome(NamedTuple):
    """How an activity ended."""

    name: str
    """`succeeded`, `failed`, `timed_out`, `rejected`, `canceled`, `unverified`, or an option."""
    data: Mapping[str, Any] = {}
    """`event.<field>` (for an option: `answer.<name>`) in the transitions that it fires."""
    why: str = ""


class Turn(NamedTuple):
    """What a machine makes of something that happened."""

    state: Any
    """The activity's state from now on: a frozen value."""
    effects: tuple[Any, ...] = ()
    """What the performer is to do, as values of `step.py`."""
    outcome: Outcome | None = None
    writes: tuple[tuple[str, Any], ...] = ()
    """Keys and their new values."""
    notes: tuple[str | VerdictNote, ...] = ()
    """What a reader of the journal should know: a refused proposal, a stale answer."""


class ActivityHost(Protocol):
    """What lies before a machine: what is known, fresh numbers, and the goals that no one may forget."""

    @property
    def view(self) -> View:
        """The blackboard, the configuration and the time of this moment."""

    @property
    def begins_at(self) -> float:
        """When what a machine asks for now is carried out, and its answer can arrive; deadlines count from then."""

    def next_number(self) -> int:
        """A fresh number for a start or a question."""

    def open_goal(self, owner: str, action: str, cancel_s: float) -> int:
        """The number of a goal that is sent now and is in the ledger from here on."""

    def close_goal(self, number: int) -> None:
        """A goal has ended by the profile's own guard: it leaves the ledger."""

    def write_key(self, key: str, value: Any, by: str = "") -> bool:
        """Write a key of the mission; what looks next sees it.

        Args:
            key: Its name.
            value: Its new value.
            by: The state whose machine writes it and looks at it by itself: it is not reported to that machine.

        Returns:
            Whether the key has another value now: one that was unknown, missing or stale counts as another.
        """

    def rounds(self, owner: str, loops: int) -> Rounds:
        """What the tree of a state has done in the step in hand; `loops` as `Ticker` has it."""

    def obstruction(self, action: str) -> Obstruction:
        """Why an action has to wait for another goal; empty where it has not."""


NO_KEYS: frozenset[str] = frozenset()
GOALS = "#goals"
"""What the ledger is called among the keys: a goal has ended or was given up."""


class Machine(ABC):
    """One kind of activity, compiled for one owner."""

    owner: str
    """The state, or `state#path` for a leaf of a tree."""

    @abstractmethod
    def begin(self, host: ActivityHost) -> Turn:
        """The state is active and control is where it belongs: start."""

    @abstractmethod
    def receive(self, state: Any, event: Event, host: ActivityHost) -> Turn | None:
        """Something happened; None where it does not concern this.

        A `tick`: an instant has come for which `wake_at` asked, or the `keys` in its data were written;
        those of them that have another value now are its `news`. Among both are `GOALS`, and states that have become
        active or inactive, each by its `presence`. With `unseen`, more may have changed since it looked last.
        """

    def leave(self, state: Any, host: ActivityHost) -> Turn:
        """The state is left or out of time: end what runs."""
        return Turn(None)

    def stop(self, state: Any, host: ActivityHost) -> Turn:
        """The mission is paused, or control is elsewhere: end what runs; it begins again later.

        Where the turn has a state, that is what is remembered until then, and `is_stopped`.
        """
        return self.leave(state, host)

    def is_stopped(self, state: Any) -> bool:
        """Whether this is what `stop` left: it receives reports, and looks at nothing."""
        return False

    def begin_again(self, state: Any, host: ActivityHost) -> Turn:
        """Start once more, from the state that `stop` left; one that remembers nothing begins by `begin`."""
        return Turn(state)

    def wake_at(self, state: Any, view: View) -> float:
        """The next instant at which a `tick` may change something; infinity for none."""
        return math.inf

    def reads(self, state: Any) -> frozenset[str]:
        """What it wants to be notified of: changes of keys, of states (`presence`), of goals (`GOALS`)."""
        return NO_KEYS

    def watches(self, state: Any, names: Collection[str]) -> bool:
        """Whether it wants to be notified of one of these."""
        return concerns(self.reads(state), names)

    @abstractmethod
    def awaits(self, state: Any) -> frozenset[int]:
        """The numbers of the starts and questions whose answer it waits for."""

    def shift(self, state: Any, by_s: float) -> Any:
        """The state with its deadlines moved: the mission was paused for so long."""
        return state


class Bench(NamedTuple):
    """What a machine is made with, and for whom."""

    owner: str
    """The state, or `state#path` for a leaf of a tree."""
    state: str
    """The state itself."""
    place: str
    """The JSON pointer of what the machine runs."""
    keys: Mapping[str, Key]
    robot: RobotFacts
    trees: Trees
    made_at: Callable[[str, Mapping[str, Key], str], Site] = Site
    """Makes the place of a guard."""

    def site(self, word: str = "") -> Site:
        """Where a guard below the machine's place is compiled."""
        return self.made_at(f"{self.place}/{word}" if word else self.place, self.keys, self.state)


def watches(machine: Any, state: Any, names: Collection[str]) -> bool:
    """Whether a machine wants to be notified of one of these; one of another package need only have `reads`."""
    return machine.watches(state, names) if isinstance(machine, Machine) else concerns(machine.reads(state), names)


def stopped(machine: Any, state: Any, host: ActivityHost) -> Turn:
    """What a machine makes of a pause; one of another package need only have `leave`."""
    return machine.stop(state, host) if isinstance(machine, Machine) else machine.leave(state, host)


@singledispatch
def machine_of(definition: Any, bench: Bench) -> Machine | None:
    """The machine of a state or of a tree's leaf; each kind of the format registers its own. None: it runs nothing.

    A state of another package makes its own, by its method `machine`, or runs the tree that its method `made` gives.
    """
    return None


Remembered = TypeVar("Remembered", bound=type[Any])
_remembered: dict[str, type[Any]] = {}


def remembered(word: str) -> Callable[[Remembered], Remembered]:
    """Marks what a machine remembers (a `NamedTuple`), with its word in a journal, which stays when a class is renamed.

    Raises:
        TypeError: Another class has the word.
    """

    def mark(kind: Remembered) -> Remembered:
        known = _remembered.setdefault(word, kind)
        if known.__qualname__ != kind.__qualname__ or known.__module__ != kind.__module__:
            raise TypeError(f"'{word}' names {known.__module__}.{known.__qualname__} in a journal; choose another word")
        _remembered[word] = kind
        return kind

    return mark


def remembered_kinds() -> Mapping[str, type[Any]]:
    """The word in a journal → what a machine remembers under it."""
    return _remembered


def result_writes(fields: Mapping[str, str], result: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    """What is kept of a result: mission key → its field, or one within it, `pose.x`; nothing where there is none.

    A profile may give a field a name with a dot: it is found first.
    """
    found = ((key, result[field] if field in result else at_path(result, field)) for key, field in fields.items())
    return tuple((key, value) for key, value in found if value is not None)
