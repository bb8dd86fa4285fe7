# SPDX-License-Identifier: Apache-2.0
"""What a dialogue knows of a run: a plain value, made again for each moment at which it is asked.

Rule: every answer about the robot rests on this value alone, and on no sentence of a person or a model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

from rai_missions.engine.decision import Offer, Question
from rai_missions.engine.modes import ALIVE
from rai_missions.keys import Source, TypeName

__all__ = ("BuildView", "EndKind", "HappeningKind", "KeyView", "MissionView", "ProgressView", "RunEvent", "StatusView")

EndKind = Literal["", "reached", "canceled", "killed", "invariant", "cycle", "failed"]
"""How a run ended: a final was reached, a person canceled it or gave the e-stop, an invariant was false, its rules went
in a circle, what a state came to was handled by none. Empty: its author states why, or it is not known."""
HappeningKind = Literal["entered", "event", "command", "answered", "control", "continued", "ended"]


class KeyView(NamedTuple):
    """One key of the blackboard at this moment."""

    name: str
    type: TypeName
    source: Source = "robot"
    about: str = ""
    """The mission's sentence about it."""
    value: Any = None
    age_s: float | None = None
    """Seconds since it was so; None where it was never received."""
    is_fresh: bool = True
    """False: it is older than its `max_age_s`, and so unknown now."""
    frame: str = ""
    fields: Mapping[str, TypeName] = {}
    minimum: float | None = None
    """Of an argument: the least value that it may have."""
    maximum: float | None = None
    enum: Sequence[str] | None = None
    """Of an argument that is a string: the values that it may have; None is any."""


class MissionView(NamedTuple):
    """A mission that can be started, as it is named and what it takes."""

    name: str
    about: str = ""
    arguments: tuple[KeyView, ...] = ()
    """Its argument keys; the value is the initial one."""

    @property
    def keys(self) -> Mapping[str, KeyView]:
        """The mission's arguments by their names."""
        return {key.name: key for key in self.arguments}


class ProgressView(NamedTuple):
    """How far something is: `2 of 6`."""

    of: str
    """The key that is counted, by name, or the list that is worked through."""
    done: float | None
    """None: the count was never received, or is stale."""
    total: float
    about: str = ""
    """The mission's sentence about that key."""


class RunEvent(NamedTuple):
    """One thing that happened in the run."""

    kind: HappeningKind
    name: str
    """The state, event, command, option, holder or outcome."""
    at: float
    about: str = ""
    """The mission's sentence about it, where it has one."""
    by: str = ""
    """Who commanded or answered."""


class BuildView(NamedTuple):
    """What is known of a robot's build; None: that is not known."""

    name: str
    """Of the description that it is from."""
    mass_kg: float | None = None
    size_m: tuple[float, float, float] | None = None
    """Length, width and height."""
    speed_m_s: float | None = None
    """How fast it can drive at most."""


class StatusView(NamedTuple):
    """The run at one moment."""

    at: float = 0.0
    """Seconds on the run's clock."""
    run: str = ""
    """The run's id; empty while there is none. Reports are counted by it."""
    is_resumed: bool = False
    """Another process began it, and may have spoken its reports."""
    revision: int = 0
    """`Status.revision`."""
    mode: str = ""
    """One of `MODES`; empty while there is no run."""
    control: str = "autonomy"
    """Who holds control."""
    active: tuple[str, ...] = ()
    """The active states, outer before inner, as in `Status.active`."""
    state: str = ""
    """The active state that is named for all of them; empty: the last of `active`."""
    awaits_start: bool = False
    """It waits for the order to start, or is paused before its start; of one that is over: it never began."""
    outcome: str | None = None
    why: str = ""
    """Why it ended so, in words: its author's sentence, else the engine's, which is English."""
    end: EndKind = ""
    """The kind of its end, where `why` is the engine's sentence; each language has a text for each kind."""
    end_name: str = ""
    """Of the final or the invariant, of the state that was active, or of who ended it."""
    wanted: tuple[str, ...] = ()
    """Who must have control before what waits can begin; empty where nothing waits for control."""
    held_by: str = ""
    held_since: float | None = None
    open_goals: tuple[str, ...] = ()
    """The actions that may still be executing although nothing waits for them."""
    questions: tuple[Question, ...] = ()
    """The questions that are open to a person now, the oldest first: regions may ask at the same time."""
    confirm: frozenset[tuple[int, str]] = frozenset()
    """Their options that have `"confirm": true`, each with the number of its question."""
    keys: Mapping[str, KeyView] = {}
    states: Mapping[str, str] = {}
    """State → its `about`, or that of the nearest state around it that has one."""
    events: Mapping[str, str] = {}
    """Event → its `about`."""
    mission: str = ""
    """The mission's name."""
    about: str = ""
    """The mission's `about`."""
    robot: str = ""
    """The robot's name."""
    identity: str = ""
    """A sentence on who the robot is; of its description."""
    build: BuildView | None = None
    """Its build; None where no description has it."""
    missions: tuple[MissionView, ...] = ()
    """What can be started, this one included."""
    progress: tuple[ProgressView, ...] = ()
    happened: tuple[RunEvent, ...] = ()
    """The last things that happened, oldest first; the run keeps a bounded number."""
    began: float | None = None
    """When it was started, on the run's clock; None before that, and where another process started it."""
    since: float | None = None
    """Since when the state that is named is active, on the run's clock."""
    mode_by: str = ""
    """Who brought it into this mode: of a pause, cancel or e-stop."""
    mode_since: float | None = None

    @property
    def is_alive(self) -> bool:
        """Whether there is a run that has not ended."""
        return self.mode in ALIVE

    @property
    def has_ended(self) -> bool:
        """Whether there is a run that is over."""
        return bool(self.mode) and not self.is_alive

    @property
    def is_before_start(self) -> bool:
        """Whether there is no run, or one that has not begun."""
        return not self.mode or (self.is_alive and (self.mode == "ready" or self.awaits_start))

    @property
    def named_state(self) -> str:
        """The active state that is named for all of them; empty where none is active."""
        return self.state or (self.active[-1] if self.active else "")

    def mission_named(self, name: object) -> MissionView | None:
        """The mission of this name that can be started; None where there is none."""
        return next((each for each in self.missions if each.name == name), None)

    def question(self, number: int) -> Question | None:
        """The open question of this number; None where it is closed."""
        return next((each for each in self.questions if each.number == number), None)

    def offer(self, number: int, option: str) -> Offer | None:
        """An option of the open question of this number; None where it is closed, or has no such option."""
        question = self.question(number)
        options = question.options if question is not None else ()
        return next((offer for offer in options if offer.name == option), None)
