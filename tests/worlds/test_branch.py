# SPDX-License-Identifier: Apache-2.0
"""A branch of a world is the world as it would be after the same calls from its start, to the bit."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.connectors.connector import Message, Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError
from rai_missions.worlds import open_world
from rai_missions.worlds.branching import branched
from tests.worlds.object_walk import Walk, faults

EXAMPLES = 6


class Client:
    """A client of a world: what is done at which step, and all that comes back.

    Args:
        world: The world.
        plan: Step → service or action.
    """

    def __init__(self, world: Any, plan: dict[int, str], topics: tuple[str, ...]) -> None:
        self.world, self.plan = world, plan
        self.received: list[tuple[Any, ...]] = []
        self.connector = LocalConnector(now=lambda: world.at)
        for topic in topics:
            self.connector.subscribe(topic, "", self._receive)
        world.open(self.connector)
        self.connector.start()

    def _receive(self, message: Message) -> None:
        self.received.append((self.world.at, message.topic, message.at, repr(message.data)))

    def _report(self, report: Report) -> None:
        self.received.append((self.world.at, report.goal_id, report.status, repr(report.data), report.why))

    def do(self, what: str, step: int) -> None:
        if what.startswith("/"):
            self.connector.send_goal(what, "", {}, goal_id=f"{what}@{step}", on_report=self._report)
        elif what.startswith("cancel "):
            self.connector.cancel_goal(what[7:])
        else:
            self.connector.call(f"/tractor1/{what}", "", {}, on_reply=lambda reply: self.received.append(tuple(reply)))

    def adopt(self, action: str, goal_id: str) -> None:
        self.connector.find_goal(action, "", goal_id=goal_id, on_report=self._report)

    def go(self, start: int, end: int) -> None:
        for step in range(start, end):
            if step in self.plan:
                self.do(self.plan[step], step)
            self.world.step()


def everything(world: Any) -> bytes:
    """All numbers of the physics, the solver's warm start and the contacts included."""
    data = world.data
    size = mujoco.mj_stateSize(world.model, mujoco.mjtState.mjSTATE_INTEGRATION)
    state = np.zeros(size)
    mujoco.mj_getState(world.model, data, state, mujoco.mjtState.mjSTATE_INTEGRATION)
    parts = (state, data.xpos, data.xmat, data.contact.geom, data.contact.dist, data.efc_force, data.actuator_force)
    return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)


TOPICS = tuple(
    f"/tractor1/{name}"
    for name in ("alleys_driven", "at_home", "battery", "crossing", "obstacle", "passed", "pose", "state",
                 "touched_living", "camera_image_color")
)  # fmt: skip
KINDS = st.sampled_from(["branch", "log", "crate", "person", "animal"])


def orchard(seed: int = 7, kind: str = "branch", **options: Any) -> Any:
    """One short alley; the obstacle is reached after about 90 steps."""
    near = {"kind": kind, "alley": 0, "along": 0.2, "lingers_s": 2.0}
    return open_world("orchard", seed=seed, alleys=1, length_m=12.0, obstacles=[near], camera=False, **options)


SERVICES = st.sampled_from(["continue", "replan", "stop", "flash", "go_home", "/navigate_to_pose", "/tractor1/cross"])


@st.composite
def plans(draw: Any) -> dict[int, str]:
    """Set out, reach the obstacle, and do this and that; some goals are canceled."""
    plan = {0: "continue"}
    for step in draw(st.lists(st.integers(1, 260), max_size=5, unique=True)):
        plan[step] = draw(SERVICES)
    for step, what in list(plan.items()):
        if what.startswith("/") and draw(st.booleans()):
            plan.setdefault(step + draw(st.integers(1, 40)), f"cancel {what}@{step}")
    return plan


@settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
@given(seed=st.integers(0, 99), kind=KINDS, plan=plans(), at=st.integers(0, 240), over=st.booleans())
def test_a_branch_is_a_replay_from_the_start(seed: int, kind: str, plan: dict[int, str], at: int, over: bool) -> None:
    if over:
        plan[110] = "/tractor1/cross"
    replay, origin = (Client(orchard(seed, kind), plan, TOPICS) for _ in range(2))
    replay.go(0, at)
    known = len(replay.received)
    replay.go(at, at + 90)
    origin.go(0, at)
    branch = continued(origin, plan, at)
    branch.go(at, at + 90)
    assert everything(branch.world) == everything(replay.world)
    assert later(branch.received) == later(replay.received[known:])
    assert everything(origin.world) != everything(branch.world) or at == 0, "90 steps change something"
    origin.go(at, at + 90)
    assert everything(origin.world) == everything(replay.world)
    assert origin.received == replay.received


def continued(origin: Client, plan: dict[int, str], at: int) -> Client:
    """A client of a branch, which is notified of the goals that are under way in it."""
    branch = Client(origin.world.branch(), plan, TOPICS)
    for step, what in plan.items():
        if step < at and what.startswith("/"):
            branch.adopt(what, f"{what}@{step}")
    return branch


def later(received: list[tuple[Any, ...]]) -> list[tuple[Any, ...]]:
    """Without what a client that comes later receives at once: that a goal runs, or is not known."""
    return [each for each in received if each[2:3] not in (("accepted",), ("lost",))]


def test_every_object_is_copied_and_nothing_is_shared() -> None:
    origin = Client(orchard(kind="person"), {0: "continue", 100: "flash", 105: "/navigate_to_pose"}, TOPICS)
    origin.go(0, 120)
    assert origin.world._home.running is not None, "a goal is under way"
    walk, branch = Walk(), origin.world.branch()
    assert list(walk.pair(origin.world, branch, "orchard")) == []
    assert {cut for cut in walk.cut if not cut.endswith("._closes")} == {
        "Outbox._connector", "Outbox._waiting", "RunningGoal.on_report",
    }  # fmt: skip
    assert len(walk.twins) > 300, "the walk reaches the whole world"


LEFT_OUT: dict[str, Callable[[Any, Any], None]] = {
    "the solver's warm start": lambda branch, fresh: branch.data.qacc_warmstart.__setitem__(slice(None), 0.0),
    "the follower's place": lambda branch, fresh: setattr(branch.autonomy._follower, "_index", 0),
    "the commanded speed": lambda branch, fresh: setattr(branch.tractor, "_speed", 0.0),
    "the judge": lambda branch, fresh: setattr(branch.judge, "crossing", None),
    "what was sent": lambda branch, fresh: branch._outbox._sent.clear(),
    "the steps": lambda branch, fresh: setattr(branch, "_steps", 0),
    "the walker": lambda branch, fresh: branch._walkers.update(fresh._walkers),
}


@pytest.mark.parametrize("field", LEFT_OUT)
def test_the_walk_notices_a_field_that_is_left_out(field: str) -> None:
    origin = Client(orchard(kind="person"), {0: "continue", 100: "flash"}, TOPICS)
    origin.go(0, 110)
    branch = origin.world.branch()
    assert faults(origin.world, branch) == []
    LEFT_OUT[field](branch, orchard(kind="person"))
    assert faults(origin.world, branch) != []


@pytest.mark.parametrize("path", ["counter._driven", "judge._is_tyre", "_outbox", "data", "model", "autonomy"])
def test_the_walk_notices_what_is_shared(path: str) -> None:
    world = orchard()
    branch = world.branch()
    *owner, name = path.split(".")
    mine, theirs = (getattr(each, owner[0]) if owner else each for each in (world, branch))
    setattr(theirs, name, getattr(mine, name))
    assert any("shared" in fault for fault in faults(world, branch))


def test_a_world_with_a_thread_is_refused_with_its_path() -> None:
    world = orchard()
    world.autonomy.helper = threading.Thread(target=print)
    with pytest.raises(UsageError, match=r"cannot be branched: orchard\.autonomy\.helper is a threading\.Thread"):
        world.branch()


def test_an_array_that_shows_the_physics_is_refused() -> None:
    world = orchard()
    world.autonomy.places = world.data.qpos[:3]
    with pytest.raises(UsageError, match=r"places is a view of memory that is not its own"):
        world.branch()


def test_a_function_that_refers_to_itself_is_copied() -> None:
    log: list[int] = []

    def count(left: int) -> None:
        log.append(left)
        if left:
            count(left - 1)

    copied = branched(count)
    copied(2)
    assert log == [], "the copy has a list of its own"
    assert copied.__closure__[1].cell_contents == [2, 1, 0]


def test_a_copy_takes_at_most_50_ms() -> None:
    """Twenty on this machine, the median; it takes about 3."""
    origin = Client(open_world("orchard", camera=False), {0: "continue"}, TOPICS)
    origin.go(0, 100)
    taken = []
    for _ in range(20):
        began = time.process_time()
        origin.world.branch()
        taken.append(time.process_time() - began)
    assert sorted(taken)[10] < 0.05


def test_pictures_and_detections_of_a_branch_are_those_of_the_world() -> None:
    """Pixel by pixel, rendered after more steps of both worlds."""
    near = {"kind": "crate", "alley": 0, "along": 0.2}
    world = open_world("orchard", seed=3, alleys=1, length_m=12.0, obstacles=[near], detector={"misclassify": 0.5})
    pictures: list[bytes] = []
    origin = Client(world, {0: "continue"}, TOPICS)
    origin.go(0, 95)
    branch = Client(world.branch(), {0: "continue"}, TOPICS)
    for client in (branch, origin):
        client.connector.subscribe(
            "/tractor1/camera_image_color", "", lambda message: pictures.append(message.data["data"].data)
        )
        known = len(client.received)
        client.go(95, 100)
        client.received = client.received[known:]
    assert branch.received == origin.received
    assert any("obstacle" in each[1] for each in branch.received), "the detector reports something"
    assert len(pictures) == 2 and pictures[0] == pictures[1]
    for client in (branch, origin):
        client.world.close()
