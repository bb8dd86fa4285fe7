# SPDX-License-Identifier: Apache-2.0
"""A branch of a world is the world as it would be after the same calls from its start, to the bit."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.errors import UsageError
from rai_missions.worlds import open_world
from rai_missions.worlds.branching import branched
from tests.worlds.branch_law import Client, Deed, Plan, assert_a_replay
from tests.worlds.object_walk import Walk, faults

EXAMPLES = 6


TOPICS = tuple(
    f"/tractor1/{name}"
    for name in (
        "alleys_driven",
        "at_home",
        "battery",
        "crossing",
        "obstacle",
        "passed",
        "pose",
        "state",
        "touched_living",
        "camera_image_color",
    )
)
KINDS = st.sampled_from(["branch", "log", "crate", "person", "animal"])


def orchard(seed: int = 7, kind: str = "branch", **options: Any) -> Any:
    """One short alley; the obstacle is reached after about 90 steps."""
    near = {"kind": kind, "alley": 0, "along": 0.2, "lingers_s": 2.0}
    return open_world("orchard", seed=seed, alleys=1, length_m=12.0, obstacles=[near], camera=False, **options)


SERVICES = st.sampled_from(["continue", "replan", "stop", "flash", "go_home"]).map(lambda name: service(name))
GOALS = st.sampled_from(["/navigate_to_pose", "/tractor1/cross"]).map(lambda name: Deed("goal", name))


def service(name: str) -> Deed:
    return Deed("call", f"/tractor1/{name}")


@st.composite
def plans(draw: Any) -> Plan:
    """Set out, reach the obstacle, and do this and that; some goals are canceled."""
    plan: Plan = {0: service("continue")}
    for step in draw(st.lists(st.integers(1, 260), max_size=5, unique=True)):
        plan[step] = draw(SERVICES | GOALS)
    for step, deed in list(plan.items()):
        if deed.what == "goal" and draw(st.booleans()):
            plan.setdefault(step + draw(st.integers(1, 40)), Deed("cancel", f"{deed.name}@{step}"))
    return plan


@pytest.mark.long
@settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
@given(seed=st.integers(0, 99), kind=KINDS, plan=plans(), at=st.integers(0, 240), over=st.booleans())
def test_a_branch_is_a_replay_from_the_start(seed: int, kind: str, plan: Plan, at: int, over: bool) -> None:
    if over:
        plan[110] = Deed("goal", "/tractor1/cross")
    assert_a_replay(lambda: orchard(seed, kind), plan, TOPICS, at=at, more=90)


def test_every_object_is_copied_and_nothing_is_shared() -> None:
    origin = Client(
        orchard(kind="person"),
        {0: service("continue"), 100: service("flash"), 105: Deed("goal", "/navigate_to_pose")},
        TOPICS,
    )
    origin.go(0, 120)
    assert origin.world._home.running is not None, "a goal is under way"
    walk, branch = Walk(), origin.world.branch()
    assert list(walk.pair(origin.world, branch, "orchard")) == []
    assert {cut for cut in walk.cut if not cut.endswith("._closes")} == {
        "Outbox._connector",
        "Outbox._waiting",
        "RunningGoal.on_report",
    }
    assert len(walk.twins) > 300, "the walk reaches the whole world"


LEFT_OUT: dict[str, Callable[[Any, Any], None]] = {
    "the solver's warm start": lambda branch, fresh: branch.data.qacc_warmstart.__setitem__(slice(None), 0.0),
    "the follower's place": lambda branch, fresh: setattr(branch.autonomy._follower, "_index", 0),
    "the commanded speed": lambda branch, fresh: setattr(branch.tractor, "_speed", 0.0),
    "the judge": lambda branch, fresh: setattr(branch.judge, "crossing", None),
    "what was sent": lambda branch, fresh: branch._outbox._sent.clear(),
    "the steps": lambda branch, fresh: setattr(branch, "_steps", 0),
    "the walker": lambda branch, fresh: branch._walkers._walkers.update(fresh._walkers._walkers),
}


@pytest.mark.parametrize("field", LEFT_OUT)
def test_the_walk_notices_a_field_that_is_left_out(field: str) -> None:
    origin = Client(orchard(kind="person"), {0: service("continue"), 100: service("flash")}, TOPICS)
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
    origin = Client(open_world("orchard", camera=False), {0: service("continue")}, TOPICS)
    origin.go(0, 100)
    taken = []
    for _ in range(20):
        began = time.process_time()
        origin.world.branch()
        taken.append(time.process_time() - began)
    assert sorted(taken)[10] < 0.05


@pytest.mark.long
def test_pictures_and_detections_of_a_branch_are_those_of_the_world() -> None:
    """Pixel by pixel, rendered after more steps of both worlds."""
    near = {"kind": "crate", "alley": 0, "along": 0.2}
    world = open_world("orchard", seed=3, alleys=1, length_m=12.0, obstacles=[near], detector={"misclassify": 0.5})
    pictures: list[bytes] = []
    origin = Client(world, {0: service("continue")}, TOPICS)
    origin.go(0, 95)
    branch = Client(world.branch(), {0: service("continue")}, TOPICS)
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
