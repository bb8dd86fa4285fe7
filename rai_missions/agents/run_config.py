# SPDX-License-Identifier: Apache-2.0
"""Everything that a run is made of, as a person names it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any

from rai_missions.connectors.connector import Connector
from rai_missions.connectors.python_robot import PythonRobot
from rai_missions.engine import Named
from rai_missions.engine.decision import Answerer, check_answerers
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.given import check_given, given_names, given_path
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, RobotProgram
from rai_missions.redaction import shown
from rai_missions.runtime.clock import Clock
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.run_options import RunObserver

if TYPE_CHECKING:
    from langchain_core.language_models import BaseChatModel

__all__ = ("RunConfig", "given_config")

MAPPINGS = {"arguments": "values", "answerers": "answerers", "named": "predicates", "programs": "the SHA-256 of a file"}
"""A field of `RunConfig` that maps names → to what."""


@dataclass(frozen=True)
class RunConfig:
    """Everything that a run is made of, as a person names it."""

    mission: Mission | str | Path | None
    """Left out where `resume` names a run."""
    robot: Robot | PythonRobot | RobotProgram | str | Path | None = None
    """A profile or a robot in Python, or the file of one: `.json`, or `.py`, which is executed."""
    arguments: Mapping[str, Any] = field(default_factory=dict)
    """Values for the mission's argument keys."""
    model: BaseChatModel | str | None = None
    """Who answers as `agent`: `provider:name` or `local`, asked in a process of its own, or a langchain chat model.

    A model given as an object is asked on a thread of this process: one that hangs in native code, holds the
    interpreter's lock or crashes takes the run along.
    """
    model_memory_gib: float = 2.0
    """How much memory the process of a model that is named may be resident in."""
    operator: Answerer | None = None
    """Who answers as `operator`."""
    answerers: Mapping[str, Answerer] = field(default_factory=dict)
    """Others who answer, by the name that `ask` calls them."""
    journal: str | Path | None = None
    """Where the journal goes; left out, none is written."""
    record: str | Path | None = None
    """Where an MCAP file of the run goes; its journal is written next to it where `journal` names none.

    An earlier journal or recording of its name is renamed once the run is made.
    """
    resume: str | Path | None = None
    """The journal of a run that was cut short, which continues there. Its arguments are in it."""
    named: Named | None = None
    """The predicates that `{"named": …}` guards name."""
    programs: Mapping[str, str] = field(default_factory=dict)
    """Files in Python that a person named, as `guards` or `mission` → the SHA-256 of each: a resume demands the same.
    """
    waits: bool = False
    """Whether the run waits, ready, for the command to start; arguments that are missing come with it."""
    speed: float | None = None
    """Simulated seconds to one of the wall; infinity is as fast as it goes.

    Left out, that is so in a simulated world, and a robot in Python has the time of the wall.
    """
    seed: int | None = None
    """The simulated world's, instead of the profile's."""
    connector: Connector | None = None
    """Used instead of the profile's."""
    opened: Connector | None = None
    """The profile's connector, where a node that it carries has opened it already."""
    clock: Clock | None = None
    """The run's time; left out, a simulated world's, or else the wall's."""
    on_step: Callable[[Step], None] | None = None
    """Receives each step, on the run's thread."""
    on_status: Callable[[Status], None] | None = None
    """Receives each change of mode, control or active states, on the run's thread."""

    def __post_init__(self) -> None:
        """Hold what is given to its types.

        Raises:
            UsageError: A field is of another type.
        """
        for word in ("journal", "record", "resume"):
            if getattr(self, word) is not None:
                given_path(getattr(self, word), word)
        for word, of in MAPPINGS.items():
            if word != "named" or self.named is not None:
                given_names(getattr(self, word), word, of)
        check_given(self.waits, bool, "waits", "True or False")
        check_given(self.seed, (int, NoneType), "seed", "a whole number")
        check_given(self.model_memory_gib, (int, float), "model_memory_gib", "a number of GiB")
        check_given(self.operator, (Answerer, NoneType), "operator", "an answerer")
        check_given(self.clock, (Clock, NoneType), "clock", "a clock")
        check_answerers(self.answerers)
        for word in ("on_step", "on_status"):
            check_given(getattr(self, word), (Callable, NoneType), word, "a function")  # type: ignore[arg-type]
        for word in ("connector", "opened"):
            check_given(getattr(self, word), (Connector, NoneType), word, "a connector")

    @property
    def observer(self) -> RunObserver:
        """Who follows the run."""
        return RunObserver(self.on_step, self.on_status)

    def observed_by(self, observer: RunObserver) -> RunConfig:
        """A run that one more observer follows, which is notified before the others."""
        both = observer.before(self.observer)
        return replace(self, on_step=both.on_step, on_status=both.on_status)

    @property
    def journal_path(self) -> Path | None:
        """Where the journal goes: a run that is recorded is journaled, since the recording holds the journal's rows."""
        if self.journal is not None:
            return Path(self.journal)
        return Path(self.record).with_suffix(".journal") if self.record is not None else None


def given_config(config: object) -> RunConfig:
    """What a run is prepared of.

    Raises:
        UsageError: It is no `RunConfig`.
    """
    if not isinstance(config, RunConfig):
        raise UsageError(f"a run is prepared of a RunConfig, not {shown(config)}; write RunConfig(mission, robot)")
    return config
