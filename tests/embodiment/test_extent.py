# SPDX-License-Identifier: Apache-2.0
"""How large a robot is and how fast its wheels let it drive follows from its URDF, or is not known."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from rai_missions.embodiment.extent import size_m, speed_m_s
from rai_missions.embodiment.urdf import Body, read_body

ROOT = Path(__file__).parents[2]
WHEEL = '<collision><geometry><cylinder radius="0.5" length="0.2"/></geometry></collision>'


def body(*links: str, joints: str = "") -> Body:
    """A robot of these links; those between which there are no joints are fixed to the first."""
    named = "".join(f'<link name="l{number}">{link}</link>' for number, link in enumerate(links))
    joints = joints or "".join(
        f'<joint name="j{number}" type="fixed"><parent link="l0"/><child link="l{number}"/></joint>'
        for number in range(1, len(links))
    )
    return read_body("x.urdf", f'<robot name="x">{named}{joints}</robot>'.encode())


def joint(kind: str, origin: str, limit: str = "") -> str:
    return f'<joint name="j" type="{kind}"><parent link="l0"/><child link="l1"/><origin {origin}/>{limit}</joint>'


def box(size: str, origin: str = "") -> str:
    return f"<collision>{origin}<geometry><box size='{size}'/></geometry></collision>"


def test_the_shipped_robots_are_as_large_and_fast_as_their_parts() -> None:
    rosbot = read_body("x", (ROOT / "missions/rosbot/identity/rosbot_xl.urdf").read_bytes())
    tractor = read_body("x", (ROOT / "missions/tractor/identity/tractor.urdf").read_bytes())
    assert size_m(rosbot) == pytest.approx((0.165 + 0.1825, 2 * (0.126 + 0.019), 0.048 + 0.1925), abs=1e-4)
    assert size_m(tractor) == pytest.approx((3.5, 2.5, 2.9), abs=1e-4)
    assert (speed_m_s(rosbot), speed_m_s(tractor)) == (10.5 * 0.048, 2.1 * 0.78)


@pytest.mark.parametrize(
    ("folder", "build", "unit"), [("rosbot", "rosbot_xl", "cm"), ("tractor", "tractor", "m")]
)  # fmt: skip
def test_the_documents_of_the_shipped_robots_have_the_sizes_of_their_build(folder: str, build: str, unit: str) -> None:
    identity = ROOT / "missions" / folder / "identity"
    size = size_m(read_body("x", (identity / f"{build}.urdf").read_bytes()))
    assert size is not None
    words = [f"{100 * each:.0f} cm" if unit == "cm" else f"{each:.1f} m" for each in size]
    assert all(each in (identity / "description.md").read_text() for each in words), words


def test_shapes_and_joints_are_turned_and_moved() -> None:
    lying = '<origin xyz="1 0 0" rpy="1.5707963267948966 0 0"/>'
    assert size_m(body(box("1 2 4", lying))) == pytest.approx((1, 4, 2))
    turned = joint("fixed", 'xyz="0 0 3" rpy="0 0 1.5707963267948966"')
    assert size_m(body(box("1 1 1"), box("1 2 4"), joints=turned)) == pytest.approx((2, 1, 5.5))
    tilted = '<origin rpy="0 0.7853981633974483 0"/>'
    assert size_m(body(box("1 1 1", tilted))) == pytest.approx((math.sqrt(2), 1, math.sqrt(2)))
    assert size_m(body(WHEEL)) == pytest.approx((1, 1, 0.2))


def test_what_does_not_follow_is_not_known() -> None:
    assert size_m(body("")) is None
    assert size_m(body(box("1 1 1"), "<collision><geometry><mesh filename='x.stl'/></geometry></collision>")) is None
    assert speed_m_s(body(box("1 1 1"), WHEEL, joints=joint("continuous", ""))) is None
    assert speed_m_s(body("", WHEEL, joints=joint("continuous", "", '<limit velocity="2" effort="1"/>'))) == 1.0
