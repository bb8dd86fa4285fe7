# SPDX-License-Identifier: Apache-2.0
"""What comes of an option: rolled out on a branch of the world, by the mission itself, and judged by physics.

Rule: the run and its world are left as they are. What took harm is what the world's judge measured; nothing that the
mission or a detector takes for true labels an option.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple, Protocol, runtime_checkable

from rai_missions.answerers.rules import RulesAnswerer
from rai_missions.campaign.records import BEST_FIRST, OptionVerdict
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine import Chart
from rai_missions.engine.decision import Answerer, Question
from rai_missions.engine.step import StartGoal, Step
from rai_missions.errors import UsageError, steps_of
from rai_missions.event import Event
from rai_missions.journal.in_flight import InFlight
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.replay.resume import Resumption
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner

__all__ = (
    "ROLLOUT_METHODS", "ROLLOUT_NEEDS", "Branchable", "Ending", "OpenDecision", "Rollout", "answers_of", "rollout",
    "rollouts", "rules_of",
)  # fmt: skip

Ending = Literal["mission", "harm", "question", "time"]
"""What ended a rollout: the mission's end, harm, another question that `later` does not answer, or its time."""
LONGEST_S = 180.0


@runtime_checkable
class Branchable(Protocol):
    """A world that can be copied, and whose judge measures harm."""

    period_s: float

    @property
    def at(self) -> float: ...

    def open(self, connector: Any) -> None: ...

    def step(self) -> None: ...

    def close(self) -> None: ...

    def branch(self) -> Any:
        """A copy of the world in its present state, exact to the bit."""

    def harm(self) -> str:
        """What took harm so far, in words; empty: nothing."""

    def measures(self) -> Mapping[str, Any]:
        """Forces and contacts, as plain data."""

    def work_done(self) -> float:
        """How much of its work is done, 0 to 1."""


ROLLOUT_METHODS = ("branch", "harm", "measures", "work_done")
"""The methods that a world needs for rollouts, and for nothing else."""
ROLLOUT_NEEDS = f"{', '.join(ROLLOUT_METHODS[:-1])} and {ROLLOUT_METHODS[-1]}"
"""The methods in words."""


@runtime_checkable
class MeasuresGeometry(Protocol):
    """A world whose detector can do without pictures."""

    def look_by_geometry(self) -> None:
        """Have the detector measure from the bodies from now on."""


class OpenDecision(NamedTuple):
    """A run of which a decision is open, and the world in which it is."""

    world: Branchable
    chart: Chart
    """Where the run is; the question is open."""
    robot: Robot
    run: str = ""
    """The run's identity, by which its goals are found; needed where one is under way."""
    state: str = ""
    """Which decision, where several are open; empty: the oldest."""

    @property
    def question(self) -> Question:
        """What is asked.

        Raises:
            UsageError: Nothing is, or not by this state.
        """
        found = [each for each in self.chart.questions if self.state in ("", each.state)]
        if not found:
            raise UsageError(f"no decision is open{f' in {self.state!r}' if self.state else ''}: there is no option")
        return found[0]


class Rollout(NamedTuple):
    """What came of one option."""

    option: str
    verdict: OptionVerdict
    """`completes`: the mission succeeded and no one had to decide again; `harms`: the judge of the world found harm."""
    ending: Ending
    offered: bool
    """The mission offered it; else it was tried as if its guard held."""
    outcome: str
    """How the mission ended; empty where it did not."""
    why: str
    """What harm there was, or the rule that ended the mission."""
    states: tuple[str, ...]
    """The active states at its end."""
    seconds: float
    """Simulated, from the answer on."""
    work: float
    """How much more of the work was done, 0 to 1."""
    measures: Mapping[str, Any]
    """Forces (N), angles (degrees) and ways (m), as the judge of the world has them."""

    def data(self) -> dict[str, Any]:
        """As JSON has it."""
        return {**self._asdict(), "states": list(self.states), "measures": dict(self.measures)}

    @property
    def rank(self) -> tuple[float, ...]:
        """The better, the smaller: by verdict, then by work a second, then by time."""
        return BEST_FIRST.index(self.verdict), -self.work / max(self.seconds, 1.0), self.seconds


def rollouts(
    decision: OpenDecision,
    options: tuple[str, ...] = (),
    *,
    later: Mapping[str, Answerer] | None = None,
    parameters: Mapping[str, Mapping[str, Any]] | None = None,
    longest_s: float = LONGEST_S,
) -> dict[str, Rollout]:
    """What comes of each option.

    Args:
        decision: Where they are open; it stays as it is.
        options: Their names, offered or not; by default those that are offered.
        later: Who answers later questions, by the names in `ask`; a question that none answers ends the rollout.
        parameters: Option → the parameters with which it is tried.
        longest_s: Simulated seconds of each.
    """
    names, given = options or tuple(offer.name for offer in decision.question.options), parameters or {}
    return {
        name: rollout(decision, name, later=later, parameters=given.get(name, {}), longest_s=longest_s)
        for name in names
    }


def rollout(
    decision: OpenDecision,
    option: str,
    *,
    later: Mapping[str, Answerer] | None = None,
    parameters: Mapping[str, Any] | None = None,
    longest_s: float = LONGEST_S,
    renders: bool = False,
) -> Rollout:
    """What comes of one option, on a branch of the world, until the mission ends, harm is done, or someone is asked.

    Args:
        decision: Where it is open; it stays as it is.
        option: Its name, offered or not. One that is not is tried as if its guard held.
        later: As for `rollouts`.
        parameters: With which it is tried.
        longest_s: Simulated seconds that it may take.
        renders: The detector of the branch measures in rendered pictures, as the world's does; else from the bodies,
            which is many times faster.

    Raises:
        UsageError: There is no such option, the mission refuses it with these parameters, or the world cannot be
            branched.
    """
    offered = option in {offer.name for offer in decision.question.options}
    chart, question = _ready(decision, option, offered=offered)
    world = decision.world.branch()
    if not renders and isinstance(world, MeasuresGeometry):
        world.look_by_geometry()
    branch = WatchedBranch(world, option, longest_s, offered=offered, answers_more=bool(later))
    try:
        runner = Runner(
            chart.mission,
            robot=decision.robot,
            connector=branch.connector,
            answerers=later,
            clock=SimulatedClock(branch),
            begin=_continued(chart, decision.run),
            observer=RunObserver(on_step=branch.follow),
        )
        branch.end_run = lambda: runner.kill("the rollout is over")
        runner.answer(question.number, option, parameters, by=question.asked)
        result = runner.run()
        if branch.refusal:
            raise UsageError(f"'{option}' cannot be tried in '{question.state}': {branch.refusal}")
        return branch.rollout(outcome=result.outcome, why=result.why, states=result.state)
    finally:
        branch.world.close()


class WatchedBranch:
    """The branch of a rollout, as its clock steps it: it ends the run when there is something to report.

    Args:
        world: The branch.
        option: What is tried.
        longest_s: Simulated seconds that the rollout may take.
        offered: The mission offers the option.
        answers_more: Later questions are answered.
    """

    def __init__(self, world: Branchable, option: str, longest_s: float, *, offered: bool, answers_more: bool) -> None:
        self.world, self.period_s = world, world.period_s
        self._option, self._offered = option, offered
        self.connector = LocalConnector(now=lambda: world.at)
        world.open(self.connector)
        self.connector.start()
        self.end_run: Callable[[], None] = lambda: None
        self._began, self._until, self._answers_more = world.at, world.at + longest_s, answers_more
        self._known, self._work = world.harm(), world.work_done()
        self._ending: Ending = "mission"
        self._over: Rollout | None = None
        self._judged = False
        self.refusal = ""
        """Why the mission refused the option; empty where it took it."""

    @property
    def at(self) -> float:
        return self.world.at

    def step(self) -> None:
        """Go one period on, and look for harm."""
        self.world.step()
        if self._over is None and self._new_harm():
            self._end("harm")
        elif self._over is None and self.world.at >= self._until:
            self._end("time")

    def follow(self, step: Step) -> None:
        """Take note of a step of the run."""
        if step.verdict is not None and not self._judged:
            self._judged, self.refusal = True, "" if step.verdict.accepted else step.verdict.why
            if self.refusal:
                self.end_run()
                return
        if step.question is not None and not self._answers_more and self._over is None:
            self._end("question")

    def _new_harm(self) -> str:
        harm = self.world.harm()
        return harm if harm != self._known else ""

    def _end(self, ending: Ending) -> None:
        self._ending = ending
        self._over = self._found(outcome="", why=self._new_harm())
        self.end_run()

    def _found(self, *, outcome: str, why: str) -> Rollout:
        harm = self._new_harm()
        verdict: OptionVerdict = "harms" if harm else "completes" if outcome == "succeeded" else "harmless"
        return Rollout(
            self._option,
            verdict,
            self._ending,
            self._offered,
            outcome,
            harm or why,
            (),
            round(self.world.at - self._began, 3),
            round(self.world.work_done() - self._work, 6),
            dict(self.world.measures()),
        )

    def rollout(self, *, outcome: str, why: str, states: tuple[str, ...]) -> Rollout:
        """What came of it, once the run has ended.

        Args:
            outcome: How the mission ended; empty where it did not.
            why: The rule that ended it.
            states: The active states at its end.
        """
        found = self._over if self._over is not None else self._found(outcome=outcome, why=why)
        return found._replace(states=states)


def rules_of(robot: Robot, mission: Mission) -> dict[str, Answerer]:
    """The rules of a profile, as who answers later questions."""
    return {"rules": RulesAnswerer.of(robot, keys=mission.blackboard)} if robot.rules else {}


def _ready(decision: OpenDecision, option: str, *, offered: bool) -> tuple[Chart, Question]:
    """A chart of its own whose open question offers the option."""
    question = decision.question
    if offered:
        return decision.chart.branch(), question
    chart = _unguarded(decision.chart, question.owner, option)
    chart.send(
        Event(question.asked, chart.at, {"failed": "asked again, with every option"}, "proposal", question.number)
    )
    again = [each for each in chart.questions if each.owner == question.owner]
    if not again or option not in {offer.name for offer in again[0].options}:
        raise UsageError(f"'{option}' cannot be tried in '{question.state}'")
    return chart, again[0]


def _unguarded(chart: Chart, owner: str, option: str) -> Chart:
    """The run in the same mission without the guards of a decision's options, and with an attempt more."""
    written = json.loads(dump(chart.mission))
    spec = _spec_of(chart.mission, written, owner)
    if option not in spec["options"]:
        raise UsageError(f"'{owner}' has no option '{option}'; there are: {', '.join(spec['options'])}")
    for each in spec["options"].values():
        each.pop("when", None)
    spec["attempts"] = 100
    mission = Mission.model_validate(written)
    return Chart.restore(mission, chart.snapshot(), robot_facts=chart.robot_facts, named=chart.program.named)


def _spec_of(mission: Mission, written: Any, owner: str) -> dict[str, Any]:
    """What a state, or a leaf of its tree, asks, in its mission as JSON.

    Raises:
        UsageError: It is made by a package, and so is nowhere in the JSON.
    """
    name, sign, leaf = owner.partition("#")
    place, state = next((place, state) for place, each, state in mission.walk() if each == name)
    here = written
    for step in steps_of(f"{place}{state.within(sign + leaf)}"):
        here = here[int(step)] if isinstance(here, list) else here[step]
    if "decision" not in here:
        raise UsageError(f"'{owner}' is asked by a package; an option whose guard is false cannot be tried there")
    found: dict[str, Any] = here["decision"]
    return found


def _continued(chart: Chart, run: str) -> Resumption:
    """The run as it is, with the goals that it has under way."""
    under = InFlight()
    for goal in chart.state.goals.values():
        under.open[goal.number] = StartGoal(goal.number, goal.owner, goal.action, {})
        if goal.phase != "sent":
            under.accepted.add(goal.number)
        if goal.phase == "canceling":
            under.canceled.add(goal.number)
    return Resumption(chart, under, None, chart.at, 0, run, exact=True)


def answers_of(options: Mapping[str, Mapping[str, str]], mission: Mission) -> dict[str, Answerer]:
    """Who answers later questions with fixed options.

    Args:
        options: Name in `ask` → the state that asks → the option.
        mission: Whose questions they are.
    """
    return {
        name: RulesAnswerer({state: [(None, option)] for state, option in each.items()}, keys=mission.blackboard)
        for name, each in options.items()
    }
