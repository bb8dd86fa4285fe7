# SPDX-License-Identifier: Apache-2.0
"""A whole run of the default orchard, in which every alley is driven; and twice the same, to the bit."""

from __future__ import annotations

import hashlib
import random
from contextlib import closing
from typing import Any

import mujoco
import numpy as np
import pytest

from rai_missions.worlds import open_world
from rai_missions.worlds.contract import check_world
from rai_missions.worlds.orchard.kinds import KINDS
from rai_missions.worlds.orchard.layout import Layout
from rai_missions.worlds.orchard.obstacles import Obstacle, place
from rai_missions.worlds.orchard.scene import build


def digest(orchard: Any) -> str:
    """Of everything received; of a picture its reference."""
    reported = "\n".join(f"{m.topic} {m.at!r} {m.data!r}" for m in orchard.received)
    return hashlib.sha256(reported.encode()).hexdigest()


def work(orchard: Any, alleys: int = 6) -> None:
    """A plain policy: signal to the living three times, drive over what is low, else replan."""
    orchard.call("continue")
    signals, quiet_until = 0, 0.0
    while len(orchard.world.counter.alleys) < alleys and orchard.world.at < 400:
        orchard.world.step()
        if orchard.state != "STOPPED":
            signals = 0
        elif orchard.world.at > quiet_until:
            seen = orchard.last["obstacle"].at > orchard.world.at - 0.5
            facts = orchard.facts("obstacle")
            if not seen:
                orchard.call("continue")
            elif facts["living"] and signals < 3:
                signals, quiet_until = signals + 1, orchard.world.at + 5.0
                orchard.call("flash")
            elif facts["living"] or facts["height_m"] > 0.25:
                orchard.call("replan")
            else:
                orchard.send("/tractor1/cross", {}, f"cross@{orchard.world.at}")


@pytest.mark.drill  # the shipped mission does it in each `make test`: tests/tractor
def test_the_default_orchard_can_be_done(rig: Any) -> None:
    orchard = rig()
    work(orchard)
    assert orchard.data("alleys_driven") == 6
    assert orchard.data("touched_living") is False
    assert "REVERSING" in {m.data["data"] for m in orchard.received if m.topic.endswith("state")}, (
        "one alley comes later"
    )
    assert [r.status for r in orchard.reports if r.status != "feedback"] == ["accepted", "succeeded"] * 2


@pytest.mark.drill  # tests/tractor compares two runs of a mission in it
@pytest.mark.parametrize("alleys", [2, 6])
def test_the_same_seed_gives_the_same_bits(rig: Any, alleys: int) -> None:
    first, second = rig(alleys=alleys), rig(alleys=alleys)
    for orchard in (first, second):
        work(orchard, alleys)
        assert orchard.data("alleys_driven") == alleys
    assert first.world.fingerprint() == second.world.fingerprint()
    assert digest(first) == digest(second)


def test_the_orchard_keeps_the_contract() -> None:
    topics = ("/tractor1/pose", "/tractor1/battery", "/tractor1/camera_image_color", "/tractor1/state")
    check_world(lambda: open_world("orchard", alleys=1), topics)


def test_another_seed_is_another_orchard() -> None:
    layout = Layout()
    assert len({place(seed, layout, None) for seed in range(20)}) == 20
    assert place(7, layout, None) == place(7, layout, None)


def test_the_global_random_state_plays_no_part() -> None:
    random.seed(1)
    first = place(7, Layout(), None)
    random.seed(2)
    assert place(7, Layout(), None) == first


def test_messages_carry_their_types_and_simulated_stamps(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[], camera=False)
    orchard.rest(0.3)
    pose = orchard.last["pose"]
    assert pose.at == pytest.approx(0.25)
    assert pose.data["header"] == {"stamp": {"sec": 0, "nanosec": 250_000_000}, "frame_id": "map"}
    assert pose.data["pose"]["position"]["x"] == pytest.approx(-8.75, abs=0.01)
    assert orchard.last["battery"].data["percentage"] == pytest.approx(1.0, abs=1e-3)
    assert orchard.world.at == pytest.approx(0.3)


def test_two_tractors_go_by_two_names(rig: Any) -> None:
    orchard = rig(alleys=1, obstacles=[], camera=False, robot="tractor2")
    orchard.rest(0.1)
    assert orchard.last == {}


@pytest.mark.sim
@pytest.mark.parametrize("kind", [name for name, kind in KINDS.items() if kind.moved_by == "forces"])
def test_what_lies_in_an_alley_stays_there(kind: str) -> None:
    """Also a fallen tree whose crown reaches in among the trunks of a row."""
    for turn_deg in (80.0, 107.0, 250.0):
        obstacles = [{"kind": kind, "along": along, "turn_deg": turn_deg} for along in (0.5, 0.53, 0.55, 0.6)]
        with closing(open_world("orchard", alleys=len(obstacles), obstacles=obstacles, camera=False)) as world:
            bodies = [world.model.body(f"obstacle_{number}").id for number in range(len(obstacles))]
            begun = world.data.xpos[bodies].copy()
            while world.at < 2.0:
                world.step()
            assert np.linalg.norm(world.data.xpos[bodies] - begun, axis=1).max() < 0.1


@pytest.mark.parametrize("size", [1.0, 1.25])
@pytest.mark.parametrize("kind", KINDS)
def test_every_mesh_of_a_scene_is_that_of_a_body_in_it(kind: str, size: float) -> None:
    layout = Layout(alleys=2, length_m=14.0)
    model = build(layout, [Obstacle(kind, 0, size=size)])
    is_mesh = model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    assert {*model.geom_dataid[is_mesh]} == {*range(model.nmesh)}
