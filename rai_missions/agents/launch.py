# SPDX-License-Identifier: Apache-2.0
"""From a `RunConfig` to a `Runner`: reads, checks and opens what a run is made of, in one order.

Rule: what is opened enters one `ExitStack` at once, which closes it in the opposite order, whatever happens in between.
"""

from __future__ import annotations

import math
import uuid
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rai_missions.agents.python_robot import open_python_robot
from rai_missions.agents.run_config import RunConfig
from rai_missions.check import check, faults_of, load_whole
from rai_missions.connectors.connector import Connector, SupportsRawMessages
from rai_missions.connectors.local import LocalConnector
from rai_missions.connectors.python_robot import PythonRobot, PythonRobotConnector, RobotTime
from rai_missions.connectors.registry import check_connector, open_offered
from rai_missions.engine.activities.goal_ledger import may_move
from rai_missions.engine.decision import Answerer
from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.journal import Header, Journal, make_folder, make_way, versions
from rai_missions.kinds import PackageOffer
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import (
    Robot,
    dump_profile,
    identity_folder,
    is_program,
    lacking,
    load_profile,
    missing,
    unknown_fields,
)
from rai_missions.profile.python_robot import KIND
from rai_missions.redaction import Redaction, logger
from rai_missions.runtime.arguments import accepted
from rai_missions.runtime.clock import Clock, ContinuedClock, PublishedClock, SimulatedClock, WallClock
from rai_missions.runtime.robot_clock import RobotClock
from rai_missions.runtime.run_options import NewRun, RunObserver
from rai_missions.runtime.runner import Runner
from rai_missions.worlds.world import World, check_local, open_world, world_offer

if TYPE_CHECKING:
    from langchain_core.language_models import BaseChatModel

    from rai_missions.recording import Recording
    from rai_missions.replay.open_run import OpenedRun

__all__ = ("PreparedRun", "prepare", "prepare_next")

log = logger(__name__)


class CleanupStack(ExitStack):
    """What is open, and closed in the opposite order; what cannot be closed is logged and keeps nothing else open."""

    def closes(self, close: Callable[[], object]) -> None:
        """Have something closed at the end."""

        def quietly() -> None:
            try:
                close()
            except Exception:
                log.exception("something of the run could not be closed")

        self.callback(quietly)


class RunPlan(NamedTuple):
    """What a run is made of, read and checked; nothing of it is open but the journal of a run that continues."""

    config: RunConfig
    mission: Mission
    robot: Robot | None
    identity: Path | None
    """The folder of the robot's identity."""
    resumed: OpenedRun | None
    python: PythonRobot | None = None
    """The robot, where it is one in Python; `robot` is then its profile."""

    def refuse(self, faults: Iterable[Fault], *named: object) -> None:
        """Raise the faults of a file, if there are any.

        Args:
            faults: Every one.
            named: What may be named by a path; the first that is, is where they are to be mended.
        """
        if found := tuple(faults):
            paths = (each for each in (*named, self.config.resume) if isinstance(each, str | Path))
            raise DefinitionError(found, str(next(paths, "")))

    def continued(self, clock: Clock) -> Clock:
        """A clock on which a run that continues has the time that it had left."""
        return clock if self.resumed is None else ContinuedClock(clock, self.resumed.resumption.at)


class RunEnvironment(NamedTuple):
    """The world, how it is reached, and whose time counts."""

    world: World | None
    connector: Connector | None
    clock: Clock
    packages: Mapping[str, str] = {}
    """Other packages that they and the answerers come from, and their versions."""


@dataclass(frozen=True)
class PreparedRun:
    """A run that is ready to begin, and what must be closed after it. A context manager."""

    plan: RunPlan
    environment: RunEnvironment
    runner: Runner
    answerers: Mapping[str, Answerer]
    recording: Recording | None
    journal: Journal | None
    moved_aside: str | None
    """Where the journal is now that had this one's name."""
    closing: CleanupStack
    connector: Connector | None = None
    """How the robot is reached; the run starts and stops it unless it is running already."""

    @property
    def world(self) -> World | None:
        """The simulated one, if it is one."""
        return self.environment.world

    @property
    def clock(self) -> Clock:
        """Whose time counts."""
        return self.environment.clock

    @property
    def mission(self) -> Mission:
        return self.plan.mission

    @property
    def robot(self) -> Robot | None:
        return self.plan.robot

    @property
    def resumption_notice(self) -> str:
        """From where a run continues, for people; empty for one that begins."""
        if self.plan.resumed is None:
            return ""
        chart, cut = self.plan.resumed.resumption.chart, self.plan.resumed.record.cut
        where = ", ".join(sorted(chart.active)) or "before its start"
        notice = f"the run continues at {chart.at:.2f} s in: {where}"
        if chart.mode == "paused":
            notice += "; it is paused: resume it by talk (--talk), on the page (--watch) or through its node (--node)"
        if self.world is not None:
            notice += "; the simulated world starts again, and what was under way in it is begun again"
        if self.plan.config.model is not None and self.robot and self.robot.identity and self.plan.identity is None:
            notice += "; the model lacks the robot's identity, whose folder is next to its profile: --robot PROFILE"
        if cut:
            notice += f"; {cut} bytes at the journal's end, after its last whole row, count as not written"
        return notice

    @property
    def why_last(self) -> str:
        """Why no other run may follow this one here, which is over; empty where one may."""
        view = self.runner.view
        if view.holder == "nobody":
            return "the robot was stopped at once, and no one has control since"
        return may_move(view.loose_goals)

    def hold_connector(self) -> None:
        """Have the connector run until everything is closed, not until the end of the run; before the run."""
        connector = self.environment.connector
        if connector is not None and not connector.running:
            connector.start()
            self.closing.closes(connector.stop)

    def close_files(self) -> None:
        """The run is over, and another continues in its environment: what it is written to is whole."""
        if self.journal is not None:
            self.journal.close()
        if self.recording is not None:
            self.recording.close(self.plan.config.journal_path)

    def close(self) -> None:
        """Close everything; doing so twice changes nothing."""
        self.closing.close()

    def __enter__(self) -> PreparedRun:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def prepare(config: RunConfig) -> PreparedRun:
    """Read, check and connect everything; nothing moves yet.

    Raises:
        DefinitionError: The mission or the profile is at fault, every fault at once.
        UsageError: Something named is not there.
    """
    with CleanupStack() as closing:
        plan = _read(config, closing)
        environment = _open_environment(plan, closing)
        answerers, packages = _open_answerers(plan, environment.connector, environment.clock, closing)
        environment = environment._replace(packages={**environment.packages, **packages})
        return _made(plan, environment, answerers, closing)


def prepare_next(before: PreparedRun, config: RunConfig) -> PreparedRun:
    """Another run of a mission in the environment of one that is over: its world, connector, clock and answerers.

    Args:
        before: What it follows. It is closed after this one; its connector runs (`PreparedRun.hold_connector`).
        config: What is different: arguments, journal, recording, observers.

    Raises:
        DefinitionError: The arguments do not fit.
        UsageError: The run before had the robot stopped at once, or left goals that may still move it.
    """
    view = before.runner.view
    if view.outcome is None:
        raise UsageError("the run before is not over; one run after the other has a robot")
    if why := before.why_last:
        raise UsageError(why)
    with CleanupStack() as closing:
        accepted(before.mission, config.arguments, whole=not config.waits)
        plan = before.plan._replace(config=config, resumed=None)
        return _made(plan, before.environment, before.answerers, closing)


def _made(
    plan: RunPlan, environment: RunEnvironment, answerers: Mapping[str, Answerer], closing: CleanupStack
) -> PreparedRun:
    """The run itself, with what it is written to; `closing` is the run's from here."""
    config, resumed = plan.config, plan.resumed
    header = _header(plan, environment.packages)
    with ExitStack() as undo:
        recording = _open_recording(plan, environment.connector, environment.clock, header, closing)
        if recording is not None:
            undo.callback(recording.withdraw)
        journal, moved_aside = _open_journal(plan, header, recording, closing)
        undo.pop_all()
    reached, observer = environment.connector, RunObserver(config.on_step, config.on_status)
    if recording is not None:
        from rai_missions.recording import observers, recorded

        reached, observer = recorded(reached, recording), observers(recording, observer)
    new = NewRun(header.arguments, config.named, run=header.run, moved_aside=moved_aside, waits=config.waits)
    continued = resumed and resumed.resumption._replace(fresh=environment.world is not None, waits=config.waits)
    runner = Runner(
        plan.mission, robot=plan.robot, connector=reached, clock=environment.clock, answerers=answerers,
        journal=journal, begin=continued or new, observer=observer,
    )  # fmt: skip
    return PreparedRun(
        plan, environment, runner, answerers, recording, journal, moved_aside, closing.pop_all(), reached
    )


def _read(config: RunConfig, closing: CleanupStack) -> RunPlan:
    mission = load_whole(config.mission) if isinstance(config.mission, str | Path) else config.mission
    given, identity = config.robot, None
    if isinstance(given, str | Path) and not is_program(given):
        robot: Robot | None = load_profile(given)
        identity = identity_folder(robot, given) if robot is not None else None
    else:
        robot = given if isinstance(given, Robot) else None
    resumed = None
    if config.resume is not None:
        from rai_missions.replay.open_run import open_run

        resumed = open_run(config.resume, mission=mission, robot=robot, named=config.named, programs=config.programs)
        closing.closes(resumed.record.close)
        mission, robot = resumed.mission, robot or resumed.robot
    if robot is not None and "world" in robot.connector and config.seed is not None:  # the journal has it with the rest
        robot = robot.model_copy(update={"connector": {**robot.connector, "seed": config.seed}})
    if mission is None:
        raise UsageError("no mission was named, and no run to resume")
    plan = RunPlan(config, mission, robot, identity, resumed)
    plan.refuse(faults_of(check(mission)), config.mission)
    if resumed is None:
        accepted(mission, config.arguments, whole=not config.waits)
    if (chosen := open_python_robot(given, mission, resumed.robot if resumed is not None else None)) is not None:
        plan = plan._replace(python=chosen.robot, robot=chosen.profile)
    needed = mission.needed_facts() if resumed is None and config.connector is None else ()
    if plan.robot is None and needed:
        raise UsageError(f"the mission must receive {', '.join(needed)} from a robot, and none was given")
    plan.refuse(missing(mission, plan.robot) if plan.robot is not None else (), config.robot)
    return plan


def _open_environment(plan: RunPlan, closing: CleanupStack) -> RunEnvironment:
    config = plan.config
    if plan.python is not None and config.connector is None:
        return _open_python(plan, plan.python)
    if config.connector is not None or plan.robot is None:
        return RunEnvironment(None, config.connector, plan.continued(config.clock or WallClock()))
    options = dict(plan.robot.connector)
    kind, world = str(options.pop("kind")), options.pop("world", None)
    if (offer := check_connector(kind)) is not None:
        return _open_connector(plan, plan.robot, offer, options, closing)
    if kind == KIND:
        raise UsageError("a profile cannot name a robot in Python; a person does: --robot FILE.py")
    if world is None:
        check_local(options)
        clock = plan.continued(config.clock or WallClock())
        return RunEnvironment(None, LocalConnector(now=clock.now), clock)
    return _open_world(plan, str(world), options, closing)


def _open_python(plan: RunPlan, robot: PythonRobot) -> RunEnvironment:
    """A robot whose functions execute in this process: by the wall, or as fast as they wait."""
    given, speed = plan.config.clock, plan.config.speed
    robot_time = RobotTime(steered=given is None and speed not in (None, 1.0))
    steered = RobotClock(robot_time, speed or math.inf) if robot_time.is_steered else WallClock()
    clock = plan.continued(given or steered)
    keys = [name for name, key in plan.mission.blackboard.items() if key.source == "robot"]
    connector = PythonRobotConnector(robot, now=clock.now, robot_time=robot_time, events=plan.mission.events, keys=keys)
    return RunEnvironment(None, connector, clock)


def _open_connector(
    plan: RunPlan, robot: Robot, offer: PackageOffer, options: Mapping[str, Any], closing: CleanupStack
) -> RunEnvironment:
    """A robot that is reached by a middleware."""
    given = plan.config.clock
    published = PublishedClock() if given is None and options.get("sim_time") is True else None
    clock, package = plan.continued(published or given or WallClock()), offer.load()
    connector = open_offered(offer, options, now=clock.now)
    if hasattr(package, "why_absent"):
        absent = lacking(plan.mission, robot, package.why_absent)
        plan.refuse((*absent, *unknown_fields(plan.mission, robot, package.fields_of)), plan.config.robot)
    if published is not None:
        connector.start()
        closing.closes(connector.stop)
        published.follow(connector)
    return RunEnvironment(None, connector, clock, _packages(offer))


def _open_world(plan: RunPlan, name: str, options: dict[str, Any], closing: CleanupStack) -> RunEnvironment:
    """A simulated world."""
    config = plan.config
    if plan.resumed is not None:  # its clock continues, and all else in it begins again
        options["start_s"] = plan.resumed.resumption.at
    world = open_world(name, **options)
    closing.closes(world.close)
    connector = LocalConnector(now=lambda: world.at)
    world.open(connector)
    return RunEnvironment(
        world,
        connector,
        config.clock or SimulatedClock(world, math.inf if config.speed is None else config.speed),
        _packages(world_offer(name)),
    )


def _packages(offer: PackageOffer | None) -> Mapping[str, str]:
    return {offer.package: offer.version} if offer is not None and offer.version else {}


def _header(plan: RunPlan, packages: Mapping[str, str]) -> Header:
    """What is needed to run it all again, where it is written down."""
    if plan.resumed is not None:
        return plan.resumed.record.header
    profile = dump_profile(plan.robot) if plan.robot is not None else ""
    found = {**packages, **plan.mission.packages()}
    header = Header("", profile, dict(plan.config.arguments), versions=found, programs=dict(plan.config.programs))
    if plan.config.journal_path is None:
        return header
    if not plan.mission.behaviours():  # one with behaviours in Python has no JSON; a replay needs its file
        header = header._replace(mission=dump(plan.mission))
    return header._replace(run=uuid.uuid4().hex[:12])


def _open_answerers(
    plan: RunPlan, connector: Connector | None, clock: Clock, closing: CleanupStack
) -> tuple[Mapping[str, Answerer], Mapping[str, str]]:
    """Who answers, by the names in `ask`; and the other packages that some come from, with their versions."""
    config, found = plan.config, dict(plan.config.answerers)
    if config.model is not None:
        found["agent"] = _open_model(plan, config.model, connector, clock, closing)
    if config.operator is not None:
        found["operator"] = config.operator
    if plan.robot is not None and plan.robot.rules:
        from rai_missions.answerers.rules import RulesAnswerer

        rules = {state: [(rule.when, rule.answer) for rule in rules] for state, rules in plan.robot.rules.items()}
        found["rules"] = RulesAnswerer(rules, keys=plan.mission.blackboard)
    offers = {name: offer for name, offer in plan.mission.answerers().items() if name not in found}
    for name, offer in offers.items():
        found[name] = _open_foreign(offer, closing)
    return found, {offer.package: offer.version for offer in offers.values()}


def _open_foreign(offer: PackageOffer, closing: CleanupStack) -> Answerer:
    """An answerer of another package; its `stop`, if it has one, is called at the end."""
    from rai_missions.answerers.registry import open_answerer

    answerer = open_answerer(offer)
    if callable(stop := getattr(answerer, "stop", None)):
        closing.closes(stop)
    return answerer


def _open_model(
    plan: RunPlan, model: BaseChatModel | str, connector: Connector | None, clock: Clock, closing: CleanupStack
) -> Answerer:
    """A model; one that is named opens in a process of its own while the run begins."""
    from rai_missions.answerers.model.agent import DecisionAgent
    from rai_missions.answerers.model.process.model import ModelProcess
    from rai_missions.answerers.model.providers import check_model
    from rai_missions.answerers.model.tools import open_recall, open_toolbox
    from rai_missions.embodiment import Identity

    identity = Identity.read(plan.identity) if plan.identity is not None else None
    toolbox = open_toolbox(plan.mission, plan.robot, connector, clock.now)
    if toolbox is not None:
        closing.closes(toolbox.close)
    memory_gib = plan.config.model_memory_gib
    if isinstance(model, str):
        check_model(model, memory_gib=memory_gib)
    chat = ModelProcess(model, memory_gib=memory_gib) if isinstance(model, str) else model
    looking = (*(toolbox.read_only if toolbox is not None else ()), *open_recall(plan.mission, identity))
    agent = DecisionAgent(chat, identity, looking)
    closing.closes(agent.stop)
    agent.run()
    return agent


def _open_recording(
    plan: RunPlan, connector: Connector | None, clock: Clock, header: Header, closing: CleanupStack
) -> Recording | None:
    """Closed after the journal, whose last rows it still takes, and before the world, whose pictures it renders."""
    path, resumed = plan.config.record, plan.resumed
    if path is None:
        return None
    from rai_missions.recording import Recording

    about = {
        "robot": plan.robot.name if plan.robot is not None else "", "run": header.run,
        "versions": versions() | dict(header.versions),
    }  # fmt: skip
    of_ros = isinstance(connector, SupportsRawMessages)  # its messages are kept as they are, with their definitions
    recording = Recording.create(
        path,
        mission=plan.mission,
        about=about,
        now=clock.now,
        clean=Redaction().known,
        profile="ros2" if of_ros else "",
    )
    closing.closes(lambda: recording.close(resumed.record.path if resumed is not None else plan.config.journal_path))
    for raw in resumed.record.raw() if resumed is not None else ():
        recording.row(raw, ())
    return recording


def _open_journal(
    plan: RunPlan, header: Header, recording: Recording | None, closing: CleanupStack
) -> tuple[Journal | None, str | None]:
    """The journal, and where one is now that had its name."""
    witness = recording.row if recording is not None else None
    moved = None
    if plan.resumed is not None:
        record = plan.resumed.record
        journal = Journal.open(record.path, witness=witness, seal=record.seal)
    elif (path := plan.config.journal_path) is None:
        return None, None
    else:
        make_folder(path)
        moved = make_way(path)
        try:
            journal = Journal.create(path, header, witness=witness)
        except BaseException:
            if moved is not None:
                moved.rename(path)
            raise
    closing.closes(journal.close)
    return journal, str(moved) if moved is not None else None
