# SPDX-License-Identifier: Apache-2.0
"""What a URDF holds is what another reader of the format finds in it, and each value is in the sentences."""

from __future__ import annotations

import math
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.embodiment.body_text import read_urdf_text
from rai_missions.embodiment.extent import size_m
from rai_missions.embodiment.urdf import JOINTS, Body, BodyJoint, read_body

ROOT = Path(__file__).parents[2]
SHIPPED = ("missions/tractor/identity/tractor.urdf", "missions/rosbot/identity/rosbot_xl.urdf")
FORMS = """<robot name="forms"><link name="a"><inertial><mass value="2.5e-1"/></inertial>
<collision><geometry><sphere radius="0.1"/></geometry></collision>
<visual><geometry><mesh filename="package://x/y.stl"/></geometry></visual></link><link name="b"/>
<joint name="j" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 -1"/>
<limit lower="-0.1" upper="0.25" effort="30" velocity="0.4"/></joint></robot>"""


@pytest.fixture(scope="module")
def urchin() -> Any:
    return pytest.importorskip("urchin", reason="urchin is not installed: the extra `urdf-test`")


def text_of(data: bytes) -> str:
    return "\n".join(section.text for section in read_urdf_text("x.urdf", data).sections)


@pytest.mark.parametrize("path", SHIPPED)
def test_links_joints_masses_sizes_and_limits_are_those_that_urchin_reads(urchin: Any, path: str) -> None:
    body, other = read_body(path, (ROOT / path).read_bytes()), urchin.URDF.load(str(ROOT / path), lazy_load_meshes=True)
    assert body.name == other.name
    assert [link.name for link in body.links] == [link.name for link in other.links]
    for link, theirs in zip(body.links, other.links, strict=True):
        assert link.mass_kg == theirs.inertial.mass
        shapes = [(each, use) for use in ("visual", "collision") for each in getattr(theirs, f"{use}s")]
        found = sorted((shape.use, shape.kind, shape.measures_m) for shape in link.shapes)
        assert found == sorted((use, *measures(each.geometry)) for each, use in shapes)
    for joint, theirs in zip(body.joints, other.joints, strict=True):
        same_joint(joint, theirs)


def measures(geometry: Any) -> tuple[str, tuple[float, ...]]:
    if geometry.box is not None:
        return "box", tuple(map(float, geometry.box.size))
    return "cylinder", (geometry.cylinder.radius, geometry.cylinder.length)


def same_joint(joint: BodyJoint, theirs: Any) -> None:
    assert (joint.name, joint.kind, joint.parent, joint.child) == (
        theirs.name,
        theirs.joint_type,
        theirs.parent,
        theirs.child,
    )
    assert joint.origin_m == tuple(map(float, theirs.origin[:3, 3]))
    if joint.kind != "fixed":
        assert joint.axis == tuple(map(float, theirs.axis))
    if theirs.limit is not None:
        assert (joint.velocity, joint.effort) == (theirs.limit.velocity, theirs.limit.effort)
        assert (joint.lower, joint.upper) == (theirs.limit.lower, theirs.limit.upper)


@pytest.mark.parametrize("path", SHIPPED)
def test_each_value_is_in_the_sentences_as_it_was_written(path: str) -> None:
    data = (ROOT / path).read_bytes()
    body, text = read_body(path, data), text_of(data)
    for link in body.links:
        assert f"The link {link.name} weighs {number(link.mass_kg or 0)} kg (mass)." in text
        assert all(number(each) in text for shape in link.shapes for each in shape.measures_m)
    for joint in body.joints:
        assert f"The joint {joint.name} ({joint.kind}) connects its parent {joint.parent} to its child" in text
        for value in (joint.lower, joint.upper, joint.velocity, joint.effort):
            assert value is None or joint.kind == "fixed" or number(value) in text


def number(value: float) -> str:
    return str(int(value)) if value == int(value) else str(value)


def test_the_masses_of_the_shipped_robots_are_those_of_their_descriptions() -> None:
    tractor, rosbot = (read_body(path, (ROOT / path).read_bytes()) for path in SHIPPED)
    assert tractor.mass_kg == 3200 and math.isclose(rosbot.mass_kg, 6)


def test_other_forms_are_read_and_put_in_words() -> None:
    text = text_of(FORMS.encode())
    assert "The link a weighs 0.25 kg (mass)." in text and "The link b has no mass given." in text
    assert "Its collision shape is a sphere of 0.1 m radius. Its visual shape is a mesh." in text
    assert "It moves along the axis 0, 0, -1. Its limits are -0.1 m and 0.25 m." in text
    assert "Its highest velocity is 0.4 m/s. Its highest effort is 30 N (force)." in text


def test_a_name_is_one_line_of_what_a_person_sees() -> None:
    unseen = "".join(chr(0xE0100 + ord(each)) for each in "obey")
    body = read_body("a.urdf", f"<robot name='r&#10;s'><link name='a&#10;b\u202e\u200b{unseen}'/></robot>".encode())
    assert body.words() == "Build of 'r s'. Links: a b. Moving joints: none."


def test_a_joint_of_a_turn_is_in_radians_and_degrees() -> None:
    text = text_of(FORMS.replace("prismatic", "revolute").encode())
    assert "Its limits are -0.1 rad (-5.7 degrees) and 0.25 rad (14.3 degrees)." in text
    assert "It turns without end" in text_of(FORMS.replace("prismatic", "continuous").encode())


def test_a_body_without_masses_has_none_in_its_overview() -> None:
    assert Body("x", (), ()).mass_kg == 0
    assert "total mass" not in text_of(b"<robot name='x'><link name='a'/></robot>")


# ── Which files are one body ────────────────────────────────────────────────────────────────────────────────────

LINKS = ("a", "b", "c", "d", "e")


def drawn(joints: Sequence[tuple[str, str, str]]) -> bytes:
    links = "".join(f'<link name="{name}"/>' for name in LINKS)
    between = "".join(
        f'<joint name="j{number}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        '<limit lower="0" upper="1" effort="1" velocity="1"/></joint>'
        for number, (parent, child, kind) in enumerate(joints)
    )
    return f'<robot name="drawn">{links}{between}</robot>'.encode()


@st.composite
def trees(draw: st.DrawFn) -> list[tuple[str, str, str]]:
    """Joints that make the links a tree, in any order."""
    names = draw(st.permutations(LINKS))
    parents = [draw(st.sampled_from(names[:place])) for place in range(1, len(names))]
    return draw(
        st.permutations(
            [(each, child, draw(st.sampled_from(JOINTS))) for each, child in zip(parents, names[1:], strict=True)]
        )
    )


def is_read(read: Callable[[], object]) -> bool:
    try:
        read()
    except ValueError:
        return False
    return True


@settings(max_examples=50)
@given(
    trees(), st.lists(st.tuples(st.sampled_from((*LINKS, "f")), st.sampled_from(LINKS), st.just("fixed"))), st.data()
)
def test_links_and_joints_are_a_body_where_urchin_reads_one_with_a_parent_each(
    joints: list[tuple[str, str, str]], others: list[tuple[str, str, str]], data: st.DataObject
) -> None:
    urchin = pytest.importorskip("urchin", reason="urchin is not installed: the extra `urdf-test`")
    joints = joints[data.draw(st.integers(0, len(others))) :] + others
    is_one = all(times == 1 for times in Counter(child for _, child, _ in joints).values())
    with tempfile.NamedTemporaryFile(suffix=".urdf") as file:
        file.write(drawn(joints))
        file.flush()
        expected = is_one and is_read(lambda: urchin.URDF.load(file.name))
    assert is_read(lambda: read_body("x", drawn(joints))) == expected


@given(trees())
def test_a_tree_of_links_is_a_body_in_whatever_order_it_is_written(joints: list[tuple[str, str, str]]) -> None:
    assert [(joint.parent, joint.child, joint.kind) for joint in read_body("x", drawn(joints)).joints] == joints


def test_the_size_of_a_long_chain_is_reckoned_link_by_link() -> None:
    count = 2_000
    box = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    links = "".join(f'<link name="l{number}">{box}</link>' for number in range(count))
    joints = "".join(
        f'<joint name="j{number}" type="fixed"><parent link="l{number}"/><child link="l{number + 1}"/>'
        '<origin xyz="0 0 0.5"/></joint>'
        for number in range(count - 1)
    )
    body = read_body("x", f'<robot name="x">{links}{joints}</robot>'.encode())
    calls = 0

    def called(_frame: object, event: str, _of: object) -> None:
        nonlocal calls
        calls += event == "call"

    sys.setprofile(called)
    try:
        size = size_m(body)
    finally:
        sys.setprofile(None)
    assert size == pytest.approx((1, 1, 1 + 0.5 * (count - 1)))
    assert calls < 400 * count
