# SPDX-License-Identifier: Apache-2.0
"""From a `RunConfig` to a `Runner`: reads, checks and opens what a run is made of, in one order.

Rule: what is opened enters one `ExitStack` at once, which closes it in the opposite order, whatever happens in between.
"""

from __future__ import annotations

import uuid
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rai_missions.agents.run_config import RunConfig, given_config
from rai_missions.agents.run_environment import RunEnvironment, open_environment
from rai_missions.agents.run_plan import CleanupStack, RunPlan, read_plan
from rai_missions.connectors.connector import Connector, SupportsRawMessages
from rai_missions.engine.activities.goal_ledger import may_move
from rai_missions.engine.decision import Answerer
from rai_missions.errors import UsageError
from rai_missions.journal import Header, Journal, make_way, versions
from rai_missions.kinds import PackageOffer
from rai_missions.mission.files import journal_text
from rai_missions.mission.garbage import few_collections
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, dump_profile
from rai_missions.redaction import Redaction, logger
from rai_missions.runtime.arguments import accepted
from rai_missions.runtime.clock import Clock
from rai_missions.runtime.recovery import ResyncWindow
from rai_missions.runtime.run_options import NewRun, RunObserver
from rai_missions.runtime.runner import Runner
from rai_missions.worlds.world import World

if TYPE_CHECKING:
    from langchain_core.language_models import BaseChatModel

    from rai_missions.recording import Recording

__all__ = ("PreparedRun", "prepare", "prepare_next")

log = logger(__name__)


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
        notice, window = f"the run continues at {chart.at:.2f} s in: {where}", ResyncWindow(chart, chart.at)
        if window.missing:
            notice += f"; it waits for the robot, {window.until - chart.at:g} s at most: {', '.join(window.missing)}"
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


@few_collections()
def prepare(config: RunConfig) -> PreparedRun:
    """Read, check and connect everything; nothing moves yet.

    Raises:
        DefinitionError: The mission or the profile is at fault, every fault at once.
        UsageError: Something named is not there, or it is no `RunConfig`.
    """
    with CleanupStack() as closing:
        plan = read_plan(given_config(config), closing)
        environment = open_environment(plan, closing)
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
    reached, observer = environment.connector, config.observer
    if recording is not None:
        from rai_missions.recording import recorded

        reached = recorded(reached, recording)
        observer = RunObserver(recording.step, recording.status).before(observer)
    new = NewRun(header.arguments, config.named, run=header.run, moved_aside=moved_aside, waits=config.waits)
    continued = resumed and resumed.resumption._replace(fresh=environment.world is not None, waits=config.waits)
    runner = Runner(
        plan.mission,
        robot=plan.robot,
        connector=reached,
        clock=environment.clock,
        answerers=answerers,
        journal=journal,
        begin=continued or new,
        observer=observer,
    )
    return PreparedRun(
        plan, environment, runner, answerers, recording, journal, moved_aside, closing.pop_all(), reached
    )


def _header(plan: RunPlan, packages: Mapping[str, str]) -> Header:
    """What is needed to run it all again, where it is written down."""
    if plan.resumed is not None:
        return plan.resumed.record.header
    profile = dump_profile(plan.robot) if plan.robot is not None else ""
    found = {**packages, **plan.mission.packages()}
    header = Header("", profile, dict(plan.config.arguments), versions=found, programs=dict(plan.config.programs))
    if plan.config.journal_path is None:
        return header
    return header._replace(mission=journal_text(plan.mission), run=uuid.uuid4().hex[:12])


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

        found["rules"] = RulesAnswerer.of(plan.robot, keys=plan.mission.blackboard)
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
        "robot": plan.robot.name if plan.robot is not None else "",
        "run": header.run,
        "versions": versions() | dict(header.versions),
    }
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
        recording.rows((raw,))
    return recording


def _open_journal(
    plan: RunPlan, header: Header, recording: Recording | None, closing: CleanupStack
) -> tuple[Journal | None, str | None]:
    """The journal, and where one is now that had its name."""
    witness = recording.rows if recording is not None else None
    moved = None
    if plan.resumed is not None:
        record = plan.resumed.record
        journal = Journal.open(record.path, witness=witness, seal=record.seal)
    elif (path := plan.config.journal_path) is None:
        return None, None
    else:
        moved = make_way(path)
        try:
            journal = Journal.create(path, header, witness=witness)
        except BaseException:
            if moved is not None:
                moved.rename(path)
            raise
    closing.closes(journal.close)
    return journal, str(moved) if moved is not None else None
