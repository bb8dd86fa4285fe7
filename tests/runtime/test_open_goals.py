# SPDX-License-Identifier: Apache-2.0
"""When a run has ended none of its goals is executing, or the result names it: over servers of every kind.

Rule: what is executing is read from the servers alone, what is named from the result alone.
"""

from __future__ import annotations

import heapq
import io
import itertools
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.cli.progress import Lines
from rai_missions.connectors.connector import Reply
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine import Chart
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.result import Result
from tests.rigs.runs import Plan, PlannedServer, Rig, ScriptedWorld, mission

LASTS_S = 40
ENDS = ["succeeded", "failed", "rejected", "canceled", "timed_out", "unverified"]


PLANS = st.builds(
    Plan,
    accepts=st.sampled_from([0.0, 0.0, 0.3, 1.5, 4.0, 9.0, None]),
    rejects=st.sampled_from([False, False, False, True]),
    ends=st.sampled_from([None, None, 0.2, 1.0, 6.0]),
    end=st.sampled_from(["succeeded", "failed"]),
    cancels=st.sampled_from([0.0, 0.0, 0.4, 3.0, None]),
    refuses=st.sampled_from([False, False, True]),
    raises=st.sampled_from([False, False, False, True]),
    twice=st.booleans(),
    vanishes=st.sampled_from([False, False, True]),
)


class Agenda(ScriptedWorld):
    """A stage whose scenes may be arranged while it is played."""

    def __init__(self) -> None:
        super().__init__()
        self._numbers = itertools.count()
        self._due: list[tuple[float, int, Callable[[], object]]] = []

    def call_later(self, seconds: float, do: Callable[[], object]) -> None:
        if seconds == 0.0:
            do()
        else:
            heapq.heappush(self._due, (self.at + seconds, next(self._numbers), do))

    def step(self) -> None:
        super().step()
        while self._due and self._due[0][0] <= self.at:
            heapq.heappop(self._due)[2]()


class SlowServices(LocalConnector):
    """A connector whose services for composed actions take effect and reply late, as their plan has it."""

    def __init__(self, agenda: Agenda, plan: Plan) -> None:
        super().__init__(now=lambda: agenda.at)
        self.agenda, self._plan = agenda, plan
        self.is_driving = False

    @property
    def obeys(self) -> bool:
        """Whether what is driving stops once it is called to."""
        return self._plan.cancels is not None and not self._plan.refuses

    def call(
        self,
        service: str,
        type_name: str,
        request: Any,
        *,
        on_reply: Callable[[Reply], None],
        timeout_s: float | None = None,
    ) -> None:
        plan = self._plan
        after = {"/drive": plan.accepts, "/halt": plan.cancels}.get(service, 0.0)
        is_fine = not (plan.rejects if service == "/drive" else plan.refuses)

        def take_effect() -> None:
            if is_fine and service in ("/drive", "/halt"):
                self.is_driving = service == "/drive"
            is_gone = plan.vanishes and service == "/drive"
            reply = Reply("succeeded", {"success": is_fine, "message": "" if is_fine else "no"})
            on_reply(Reply("unavailable", {}, "it vanished", may_have_arrived=True) if is_gone else reply)

        if after is not None:
            self.agenda.call_later(after, take_effect)


class Act(NamedTuple):
    """Something that is done to the run."""

    tenth: int
    what: str


@dataclass
class Scene:
    """A run over scripted servers, and what became of its goals."""

    actions: list[str]
    plans: list[Plan]
    acts: list[Act]
    is_ours: bool
    """The connector is started and stopped by the run."""

    def play(self) -> None:
        agenda = Agenda()
        self.connector = SlowServices(agenda, self.plans[-1])
        self.statuses: list[Status] = []
        rig = _SceneRig(mission(_states(self.actions)), agenda, self.connector, self.statuses.append)
        self.servers = {
            name: PlannedServer(agenda.call_later, lambda: agenda.at, *self.plans) for name in ("/move", "/turn")
        }
        for name, server in self.servers.items():
            rig.closes[name] = self.connector.offer(name, f"x/action/{name[1:].title()}", server)
        if not self.is_ours:
            self.connector.start()
        for act in self.acts:
            agenda.play({act.tenth / 10: lambda act=act: rig.do(act.what)})
        agenda.play({LASTS_S: rig.runner.kill})
        self.run_id = rig.runner.run_id
        self.result = rig.run()
        self.check()
        for _ in range(300):
            agenda.step()
        self.check(is_late=True)

    def check(self, *, is_late: bool = False) -> None:
        """Hold the servers against the result."""
        result, story = self.result, (self, self.result)
        named = {goal_id(self.run_id, goal) for goal in result.open_goals}
        executing = {each for server in self.servers.values() for each in server.executing}
        assert executing <= named, story
        if self.connector.is_driving:
            assert "drive" in {goal.action for goal in result.open_goals}, story
        assert bool(result.warning) is bool(result.open_goals)
        if is_late:
            closed = {act.what for act in self.acts}
            reached = [server for name, server in self.servers.items() if name not in closed]
            obedient = {each for server in reached for each in server.executing if server.obeys(each)}
            assert not obedient, ("what is accepted after the end is canceled", obedient, story)
            assert not (self.connector.is_driving and self.connector.obeys), ("what begins late is stopped", story)
            return
        before = self.connector.agenda.at - ScriptedWorld.period_s / 2  # at the same instant either may come first
        over = {each for server in self.servers.values() for each, at in server.over.items() if at < before}
        assert not named & over, ("what has ended is not named", story)
        assert self.statuses[-1].open_goals == result.open_goals, story


class _SceneRig(Rig):
    def __init__(self, given: Any, agenda: Agenda, connector: Any, on_status: Callable[[Status], None]) -> None:
        self.agenda, self.closes = agenda, dict[str, Callable[[], None]]()
        super().__init__(given, connector=connector, clock=_clock(agenda), on_status=on_status)
        self.stage = agenda

    def serve(self) -> None:
        """The scene's servers come later; services are played by its connector."""

    def do(self, what: str) -> None:
        if what.startswith("/"):
            self.closes[what]()  # the server is gone; the robot continues with what it was asked to do
        elif what in ("go", "again"):
            self.post(what)
        else:
            getattr(self.runner, what)()


def _clock(agenda: Agenda) -> Any:
    from rai_missions.runtime.clock import SimulatedClock

    return SimulatedClock(agenda)


def goal_id(run: str, goal: Any) -> str:
    return uuid.uuid5(uuid.NAMESPACE_URL, f"{run}/{goal.owner}/{goal.number}").hex


def _states(actions: list[str]) -> dict[str, Any]:
    """One after the other, each left by its outcome, by `go`, or for good by `again`."""
    names = [f"s{number}" for number in range(len(actions))]
    following = [*names[1:], "done"]
    states: dict[str, Any] = {
        name: {
            "action": action,
            "timeout_s": 2,
            "cancel_s": 1,
            "transitions": [{"on": [*ENDS, "go"], "to": after}, {"on": "again", "to": "done"}],
        }
        for name, action, after in zip(names, actions, following, strict=True)
    }
    return {**states, "done": {"final": "failed"}}


SCENES = st.builds(
    Scene,
    actions=st.lists(st.sampled_from(["move", "turn", "drive"]), min_size=1, max_size=4),
    plans=st.lists(PLANS, min_size=1, max_size=4),
    acts=st.lists(
        st.builds(
            Act,
            st.integers(1, 80),
            st.sampled_from(["go", "go", "again", "kill", "kill", "cancel", "pause", "resume", "/move", "/turn"]),
        ),
        max_size=5,
    ),
    is_ours=st.booleans(),
)
quick = settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow])


@quick
@given(SCENES)
def test_what_is_executing_when_a_run_has_ended_is_named_by_its_result(scene: Scene) -> None:
    scene.play()


@pytest.mark.drill
@settings(parent=quick, max_examples=5_000)
@given(SCENES)
def test_what_is_executing_when_a_run_has_ended_is_named_by_its_result_in_many_scenes(scene: Scene) -> None:
    scene.play()


def played(plan: Plan, *acts: Act, actions: tuple[str, ...] = ("move",), is_ours: bool = False) -> Result:
    scene = Scene(list(actions), [plan], list(acts), is_ours)
    scene.play()
    return scene.result


def test_a_refused_cancel_is_named_and_the_robot_may_still_move() -> None:
    result = played(Plan(refuses=True))
    assert [(goal.action, goal.owner, goal.reason) for goal in result.open_goals] == [("move", "s0", "refused")]
    assert result.warning == "the robot may still move: goal 1 of 'move' (its server refuses to cancel it)"


def test_the_journal_and_the_lines_name_what_may_still_move_the_robot() -> None:
    out, given = io.StringIO(), mission(_states(["move"]))
    lines = Lines(given, out)
    rig = Rig(given, on_status=lines.status)
    rig.move.on_cancel = ("cancel_rejected",)
    lines.end(rig.run())
    sentence = "the robot may still move: goal 1 of 'move' (its server refuses to cancel it)"
    assert sentence in rig.book.notes
    assert out.getvalue().count(sentence) == 1


def test_goals_that_may_still_move_the_robot_are_named_again_at_the_end_where_lines_came_between() -> None:
    out, given = io.StringIO(), mission(_states(["move"]))
    lines = Lines(given, out)
    rig = Rig(given, on_status=lines.status)
    rig.move.on_cancel = ("cancel_rejected",)
    result = rig.run()
    lines.step(Chart(mission(_states(["move"]))).start(at=0.0))
    lines.end(result)
    assert out.getvalue().count("the robot may still move") == 2


@pytest.mark.parametrize("cancels", [0.0, 3.0, None])
def test_a_composed_action_that_may_have_begun_is_ended_or_named(cancels: float | None) -> None:
    scene = Scene(["drive", "drive"], [Plan(vanishes=True, cancels=cancels)], [], is_ours=True)
    scene.play()
    named = [(goal.action, goal.reason) for goal in scene.result.open_goals]
    assert scene.connector.is_driving is (cancels is None)
    assert set(named) == ({("drive", "lost" if cancels is not None else "orphaned")} if named else set())
    assert bool(named) or cancels == 0.0


def test_a_cancel_that_is_never_confirmed_is_named() -> None:
    assert [goal.reason for goal in played(Plan(cancels=None)).open_goals] == ["orphaned"]


def test_a_server_that_is_gone_is_named() -> None:
    assert [goal.reason for goal in played(Plan(), Act(5, "/move")).open_goals] == ["lost"]


def test_an_acceptance_after_the_end_is_canceled() -> None:
    assert [goal.reason for goal in played(Plan(accepts=9.0)).open_goals] == ["orphaned"]


def test_a_start_that_takes_effect_after_the_end_is_stopped_again() -> None:
    late = Plan(accepts=9.0)
    assert [goal.reason for goal in played(late, actions=("drive",)).open_goals] == ["orphaned"]
    assert [goal.reason for goal in played(late, Act(5, "kill"), actions=("drive",)).open_goals] == ["orphaned"]


def test_a_run_whose_goals_have_ended_names_none() -> None:
    result = played(Plan(), Act(3, "go"), actions=("move", "turn"))
    assert (result.open_goals, result.warning) == ((), "")


def test_a_goal_that_was_not_confirmed_is_asked_to_end_once_more_as_the_run_is_over() -> None:
    asked: list[int] = []
    rig = Rig(mission(_states(["move"])), on_step=lambda step: asked.append(len(rig.move.canceled)))
    rig.move.on_cancel = ("cancel_rejected",)
    rig.connector.start()  # one of the run's own would end its goals as it stops
    result = rig.run()
    assert [goal.reason for goal in result.open_goals] == ["refused"]
    assert len(rig.move.canceled) == asked[-1] + 1
