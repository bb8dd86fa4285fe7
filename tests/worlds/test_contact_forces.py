# SPDX-License-Identifier: Apache-2.0
"""What one body presses on another with is one force, in however many points they touch."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytestmark = pytest.mark.sim
mujoco = pytest.importorskip("mujoco", reason="the extra `sim`")

SHAPES = {"box": 'type="box" size=".2 {half} .1"', "cylinder": 'type="cylinder" size=".2 .1"'}
GROUND = {
    "fixed": '<geom name="ground" type="box" size="2 2 .1" pos="0 0 -.1"/>',
    "a body": '<body pos="0 0 -.1"><joint type="slide" axis="1 0 0"/><geom type="box" size="2 2 .1" mass="9"/></body>',
}


def at_rest(ground: str, thing: str) -> tuple[Any, Any, Any]:
    """A thing that lies on the ground, and which geoms are the thing's."""
    body = f'<body pos="0 0 .1"><freejoint/><geom name="thing" {thing}/></body>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{ground}{body}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 500)
    return model, data, np.arange(model.ngeom) == model.geom("thing").id


@given(
    shape=st.sampled_from(sorted(SHAPES)), ground=st.sampled_from(sorted(GROUND)), mass=st.floats(0.1, 50.0),
    half=st.floats(0.05, 0.5),
)  # fmt: skip
def test_a_thing_at_rest_presses_with_its_weight_in_however_many_points(
    shape: str, ground: str, mass: float, half: float
) -> None:
    from rai_missions.worlds.contact_forces import touches

    model, data, thing = at_rest(GROUND[ground], SHAPES[shape].format(half=half) + f' mass="{mass}"')
    assert data.ncon > 1
    for ours, theirs in ((thing, ~thing), (~thing, thing)):
        (touch,) = touches(model, data, ours, theirs)
        assert touch.newton == pytest.approx(9.81 * mass, rel=0.02)
        assert ours[touch.ours] and theirs[touch.theirs]


@given(mass=st.floats(0.1, 50.0))
def test_each_fixed_thing_has_its_own_force(mass: float) -> None:
    from rai_missions.worlds.contact_forces import touches

    planks = "".join(f'<geom type="box" size=".05 2 .1" pos="{x} 0 -.1"/>' for x in (-0.15, 0.15))
    model, data, thing = at_rest(planks, f'type="box" size=".2 .2 .1" mass="{mass}"')
    found = touches(model, data, thing, ~thing)
    assert len({touch.theirs for touch in found}) == 2
    assert [touch.newton for touch in found] == pytest.approx([9.81 * mass / 2] * 2, rel=0.05)
