# SPDX-License-Identifier: Apache-2.0
"""Wires a run: mission, profile, connector, world, who answers, clock and journal; the way from files to a `Runner`."""

from __future__ import annotations

import math
import threading
import uuid
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.check import check, faults_of
from rai_missions.connectors.connector import Connector, SupportsRawMessages
from rai_missions.connectors.local import LocalConnector
from rai_missions.connectors.registry import CONNECTORS, connector_offer
from rai_missions.embodiment import Identity
from rai_missions.engine import Named
from rai_missions.engine.decision import Answerer
from rai_missions.engine.step import Step
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.journal import Header, Journal, make_way, versions
from rai_missions.kinds import Offer
from rai_missions.mission.files import dump, load
from rai_missions.mission.mission import Mission
from rai_missions.model import suggestion
from rai_missions.profile import Robot, dump_profile, identity_folder, lacking, load_profile, misnamed, missing
from rai_missions.recording import Recording, observers, recorded
from rai_missions.redaction import Redaction, logger
from rai_missions.replay.open_run import OpenedRun, open_run
from rai_missions.replay.resume import Resumption
from rai_missions.runtime.arguments import accepted
from rai_missions.runtime.clock import Clock, ContinuedClock, HeardClock, SimulatedClock, WallClock
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.run_options import NewRun, RunObserver
from rai_missions.runtime.runner import Result, Runner
from rai_missions.worlds.world import World, open_world, world_offer

if TYPE_CHECKING:
    from langchain_core.language_models import BaseChatModel

    from rai_missions.answerers.model.process.model import ModelProcess

log = logger(__name__)

__all__ = ("MissionAgent", "RunConfig", "prepare", "run")


@dataclass(frozen=True)
class RunConfig:
    """Everything that a run is made of, as a person names it."""

    mission: Mission | str | Path | None
    """Left out where `resume` names a run."""
    robot: Robot | str | Path | None = None
    arguments: Mapping[str, Any] = field(default_factory=dict)
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
    moved_aside: str | Path | None = None
    """Where the journal is now that had this one's name; one that still has it is moved when the run is made."""
    record: str | Path | None = None
    """Where an MCAP file of the run goes; its journal is written beside it where `journal` names none."""
    resume: str | Path | None = None
    """The journal of a run that was cut short: it goes on, and is written on there. Arguments are in it."""
    named: Named | None = None
    speed: float = math.inf
    """Simulated seconds to one of the wall."""
    seed: int | None = None
    """The simulated world's, instead of the profile's."""
    connector: Connector | None = None
    """Used instead of the profile's."""
    clock: Clock | None = None
    on_step: Callable[[Step], None] | None = None
    on_status: Callable[[Status], None] | None = None


class PreparedRun:
    """A run that is ready to begin, and what must be closed after it. A context manager."""

    def __init__(self, setting: RunConfig) -> None:
        self.setting = setting
        self._closes: list[Callable[[], None]] = []
        self._packages: dict[str, str] = {}
        """Other packages that the run is made with, and their versions."""
        given = load(setting.mission) if isinstance(setting.mission, str | Path) else setting.mission
        self.robot, self._folder = _profile(setting.robot)
        self._taken: OpenedRun | None = None
        if setting.resume is not None:
            self._taken = open_run(setting.resume, mission=given, robot=self.robot, named=setting.named)
            self._closes.append(self._taken.record.close)
            given = self._taken.mission
        if given is None:
            raise UsageError("no mission was named, and no run to go on with")
        self.mission = given
        if faults := faults_of(check(self.mission)):
            raise DefinitionError(faults, _file(setting.mission, setting.resume))
        if self._taken is not None:
            self.robot = self.robot or self._taken.robot
        else:
            accepted(self.mission, setting.arguments)
        if self.robot is not None and (lacks := missing(self.mission, self.robot)):
            raise DefinitionError(lacks, _file(setting.robot, setting.resume))
        self._runner: Runner | None = None
        self.journal: Journal | None = None
        self.moved_aside = str(setting.moved_aside) if setting.moved_aside is not None else None
        try:
            self.world, connector, clock = self._surroundings()
            self._header = self._head()
            self.answerers = self._answerers(connector, clock)
            self.recording = self._record(connector, clock)
            self.journal = self._journal()
            self._runner = Runner(
                self.mission, robot=self.robot, connector=recorded(connector, self.recording), clock=clock,
                answerers=self.answerers, journal=self.journal, begin=self._begin(),
                observer=observers(self.recording, RunObserver(setting.on_step, setting.on_status)),
            )  # fmt: skip
        except BaseException:
            self.close()
            raise

    @property
    def runner(self) -> Runner:
        assert self._runner is not None
        return self._runner

    def _begin(self) -> NewRun | Resumption:
        """What the run begins with, or where it stood; a simulated world knows nothing of it."""
        if self._taken is not None:
            return self._taken.resumption._replace(fresh=self.world is not None)
        head = self._header
        return NewRun(head.arguments, self.setting.named, run=head.run, moved_aside=self.moved_aside)

    @property
    def goes_on(self) -> str:
        """From where a run goes on, for whoever watches it; empty for one that begins."""
        if self._taken is None:
            return ""
        chart = self._taken.resumption.chart
        where = ", ".join(sorted(chart.active)) or "before its start"
        world = "; the simulated world starts again, and what was under way in it is begun again" if self.world else ""
        cut = self._taken.record.cut
        lost = f"; {cut} bytes at the journal's end, behind its last whole row, count as not written"
        paused = "; it is paused: resume it on the live page (--watch) or through its node (--node)"
        return (
            f"the run goes on at {chart.at:.2f} s in: {where}{paused if chart.mode == 'paused' else ''}"
            f"{world}{lost if cut else ''}"
        )

    def _surroundings(self) -> tuple[World | None, Connector | None, Clock]:
        """The world, how it is reached, and whose time counts."""
        setting = self.setting
        if setting.connector is not None or self.robot is None:
            return None, setting.connector, self._continued(setting.clock or WallClock())
        options = dict(self.robot.connector)
        kind, world_name = options.pop("kind"), options.pop("world", None)
        offer = connector_offer(str(kind))
        if offer is not None:
            self._made_with(offer)
            heard = HeardClock() if setting.clock is None and options.get("sim_time") is True else None
            clock = self._continued(heard or setting.clock or WallClock())
            room = offer.load()
            opened: Connector = room.open_connector(options, now=clock.now)
            if hasattr(room, "why_absent"):
                faults = (
                    *lacking(self.mission, self.robot, room.why_absent),
                    *misnamed(self.mission, self.robot, room.fields_of),
                )
                if faults:
                    raise DefinitionError(faults, _file(setting.robot, setting.resume))
            if heard is not None:
                self._follow(heard, opened)
            return None, opened, clock
        if kind != "local":
            raise UsageError(f"no connector of kind '{kind}'{suggestion(str(kind), ('local', *CONNECTORS))}")
        if world_name is None:
            clock = self._continued(setting.clock or WallClock())
            return None, LocalConnector(now=clock.now), clock
        if setting.seed is not None:
            options["seed"] = setting.seed
        if self._taken is not None:  # its clock goes on, and all else in it starts anew
            options["start_s"] = self._taken.resumption.at
        if (found := world_offer(str(world_name))) is not None:
            self._made_with(found)
        world = open_world(str(world_name), **options)
        self._closes.append(world.close)
        connector = LocalConnector(now=lambda: world.at)
        world.open(connector)
        return world, connector, setting.clock or SimulatedClock(world, setting.speed)

    def _made_with(self, offer: Offer) -> None:
        if offer.version:
            self._packages[offer.package] = offer.version

    def _continued(self, clock: Clock) -> Clock:
        """A run that goes on has the time that it had left."""
        return clock if self._taken is None else ContinuedClock(clock, self._taken.resumption.at)

    def _follow(self, clock: HeardClock, connector: Connector) -> None:
        """Live by the time that a simulation tells, from now on."""
        connector.start()
        self._closes.append(connector.stop)
        connector.subscribe("/clock", "rosgraph_msgs/msg/Clock", lambda said: clock.hear(_seconds(said.data["clock"])))

    def _answerers(self, connector: Connector | None, clock: Clock) -> dict[str, Answerer]:
        """Who answers, in the words of `ask`."""
        setting, who = self.setting, dict(self.setting.answerers)
        if setting.model is not None:
            who["agent"] = self._model(setting.model, connector, clock)
        if setting.operator is not None:
            who["operator"] = setting.operator
        if self.robot is not None and self.robot.rules:
            from rai_missions.answerers.rules import RulesAnswerer

            rules = {state: [(rule.when, rule.answer) for rule in rows] for state, rows in self.robot.rules.items()}
            who["rules"] = RulesAnswerer(rules, keys=self.mission.blackboard)
        return who

    def _model(self, model: BaseChatModel | str, connector: Connector | None, clock: Clock) -> Answerer:
        from rai_missions.answerers.model.agent import DecisionAgent
        from rai_missions.answerers.model.tools import open_toolbox

        identity = Identity.read(self._folder) if self._folder is not None else None
        box = open_toolbox(self.mission, self.robot, connector, clock.now)
        if box is not None:
            self._closes.append(box.close)
        chat = self._process_of(model) if isinstance(model, str) else model
        agent = DecisionAgent(chat, identity, box.read_only if box is not None else ())
        self._closes.append(agent.stop)
        agent.run()
        return agent

    def _process_of(self, model: str) -> ModelProcess:
        """A model that is named: a process of its own, which opens it while the run begins."""
        from rai_missions.answerers.model.process.model import ModelProcess
        from rai_missions.answerers.model.providers import check_model

        memory_gib = self.setting.model_memory_gib
        check_model(model, memory_gib=memory_gib)
        return ModelProcess(model, memory_gib=memory_gib)

    def _head(self) -> Header:
        """What is needed to run it all again, where it is written down."""
        if self._taken is not None:
            return self._taken.record.header
        header = Header("", dump_profile(self.robot) if self.robot is not None else "", dict(self.setting.arguments))
        header = header._replace(versions=self._packages | dict(self.mission.packages()))
        if self.setting.journal is None and self.setting.record is None:
            return header
        if not self.mission.behaviours():  # one with behaviours in Python has no JSON; a replay is given its file
            header = header._replace(mission=dump(self.mission))
        return header._replace(run=uuid.uuid4().hex[:12])

    def _record(self, connector: Connector | None, clock: Clock) -> Recording | None:
        """Closed after the journal, whose last rows it still takes, and before the world, whose pictures it renders."""
        if self.setting.record is None:
            return None
        about = {
            "robot": self.robot.name if self.robot else "",
            "run": self._header.run,
            "versions": versions() | dict(self._header.versions),
        }
        words = {"mission": self.mission, "about": about, "now": clock.now, "clean": Redaction().known}
        of_ros = isinstance(
            connector, SupportsRawMessages
        )  # its messages are kept in CDR, with their ros2msg definitions
        recording = Recording.create(self.setting.record, profile="ros2" if of_ros else "", **words)
        self._closes.append(lambda: recording.end(self.journal))
        for raw in self._taken.record.raw() if self._taken is not None else ():
            recording.row(raw, ())
        return recording

    def _journal(self) -> Journal | None:
        witness = self.recording.row if self.recording is not None else None
        if self._taken is not None:
            journal = Journal.open(self._taken.record.path, witness=witness, seal=self._taken.record.seal)
        elif (path := self._journal_path()) is None:
            return None
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            if (moved := make_way(path)) is not None:
                self.moved_aside = str(moved)
                log.info("the journal that was at %s is now at %s", path, moved)
            journal = Journal.create(path, self._header, witness=witness)
        self._closes.append(journal.close)
        return journal

    def _journal_path(self) -> Path | None:
        """A run that is recorded is journaled: the recording holds the journal's rows."""
        journal, record = self.setting.journal, self.setting.record
        if journal is not None:
            return Path(journal)
        return None if record is None else Path(record).with_suffix(".journal")

    def close(self) -> None:
        while self._closes:
            try:
                self._closes.pop()()
            except Exception:
                log.exception("something of the run could not be closed")

    def __enter__(self) -> PreparedRun:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _seconds(stamp: Mapping[str, int]) -> float:
    """A builtin_interfaces/msg/Time."""
    return stamp["sec"] + stamp["nanosec"] / 1e9


def _file(*given: object) -> str:
    """The first that is named by a path: where a fault is to be mended."""
    return str(next((each for each in given if isinstance(each, str | Path)), ""))


def _profile(given: Robot | str | Path | None) -> tuple[Robot | None, Path | None]:
    """The profile, and the folder of its identity."""
    if given is None or isinstance(given, Robot):
        return given, None
    robot = load_profile(given)
    return robot, identity_folder(robot, given)


def prepare(setting: RunConfig) -> PreparedRun:
    """Read, check and connect everything; nothing moves yet.

    Raises:
        DefinitionError: The mission or the profile is at fault, every fault at once.
        UsageError: Something named is not there.
    """
    return PreparedRun(setting)


def run(mission: Mission | str | Path, robot: Robot | str | Path | None = None, **words: Any) -> Result:
    """Run a mission to its end.

    Args:
        mission: A `Mission`, or the file of one.
        robot: A profile, or the file of one.
        words: The other fields of `RunConfig`: `model="openai:gpt-4o"`, `journal="out/run.journal"`, …

    Raises:
        DefinitionError: The mission or the profile is at fault.
        UsageError: Something named is not there.
    """
    with prepare(RunConfig(mission, robot, **words)) as prepared:
        return prepared.runner.run()


class MissionAgent:
    """The paper's Agent around a run: `run()` begins it on a thread of its own, `stop()` cancels it and waits."""

    def __init__(self, setting: RunConfig) -> None:
        self._prepared = prepare(setting)
        self._thread: threading.Thread | None = None
        self.result: Result | None = None
        """How it ended; None until then, and where it broke off."""
        self.error: Exception | None = None
        """Why it broke off, if it did."""

    def run(self) -> None:
        """Begin; returns at once. A run that has begun is not begun again."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name="mission")
            self._thread.start()

    def stop(self) -> None:
        """Cancel, and wait until everything has ended."""
        if self._thread is not None and self._thread.is_alive():
            self._prepared.runner.cancel("stop")
            self._thread.join()
        self._prepared.close()

    def _work(self) -> None:
        try:
            self.result = self._prepared.runner.run()
        except Exception as error:
            log.exception("the run broke off")
            self.error = error
