# SPDX-License-Identifier: Apache-2.0
"""A robot's build in sentences, as a document that can be searched: masses, sizes, parents, limits."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rai_missions.embodiment.document import Outline, TextDocument
from rai_missions.embodiment.urdf import Body, BodyJoint, BodyLink, BodyShape, read_body
from rai_missions.errors import counted

__all__ = ("read_urdf_text",)

TURNS = ("revolute", "continuous")


def read_urdf_text(name: str, data: bytes) -> TextDocument:
    """A URDF as text: one section for the whole, one for each link, one for each joint.

    Raises:
        ValueError: As `read_body`.
    """
    body, outline = read_body(name, data), Outline()
    outline.title = f"Build of {body.name}"
    for heading, text in sentences_of(body):
        outline.heading(1, outline.title)
        outline.heading(2, heading)
        outline.paragraph(text)
    return outline.document()


def sentences_of(body: Body) -> Iterator[tuple[str, str]]:
    """The build in sentences, each part with its heading."""
    yield "Overview", _overview(body)
    by_child = {joint.child: joint for joint in body.joints}
    for link in body.links:
        yield f"Link {link.name}", " ".join(_of_link(link, by_child.get(link.name)))
    for joint in body.joints:
        yield f"Joint {joint.name}", " ".join(_of_joint(joint))


def _overview(body: Body) -> str:
    moving = [joint.name for joint in body.joints if joint.kind != "fixed"]
    mass = f" Together its links weigh {_shown(body.mass_kg)} kg (total mass)." if body.mass_kg else ""
    return (
        f"The robot {body.name} is built of {counted(len(body.links), 'link')} (rigid parts) and "
        f"{counted(len(body.joints), 'joint')}."
        f"{mass} Joints that move: {', '.join(moving) or 'none'}."
    )


def _of_link(link: BodyLink, joint: BodyJoint | None) -> Iterator[str]:
    mass = "has no mass given" if link.mass_kg is None else f"weighs {_shown(link.mass_kg)} kg (mass)"
    yield f"The link {link.name} {mass}."
    if joint is not None:
        yield (
            f"It is mounted on {joint.parent} by the {joint.kind} joint {joint.name}, at x {_shown(joint.origin_m[0])},"
            f" y {_shown(joint.origin_m[1])}, z {_shown(joint.origin_m[2])} m."
        )
    yield from dict.fromkeys(f"Its {shape.use} shape is {_of_shape(shape)}." for shape in link.shapes)


def _of_shape(shape: BodyShape) -> str:
    measures = [_shown(each) for each in shape.measures_m]
    if shape.kind == "box":
        return f"a box, {measures[0]} m long, {measures[1]} m wide and {measures[2]} m high"
    if shape.kind == "cylinder":
        return (
            f"a cylinder of {measures[0]} m radius ({_shown(2 * shape.measures_m[0])} m diameter)"
            f" and {measures[1]} m length"
        )
    return f"a sphere of {measures[0]} m radius" if shape.kind == "sphere" else "a mesh"


def _of_joint(joint: BodyJoint) -> Iterator[str]:
    yield f"The joint {joint.name} ({joint.kind}) connects its parent {joint.parent} to its child {joint.child}."
    if joint.kind in ("fixed", "floating"):
        return
    yield f"It moves {'about' if joint.kind in TURNS else 'along'} the axis {', '.join(map(_shown, joint.axis))}."
    if joint.kind == "continuous":
        yield "It turns without end, so it has no limit of angle."
    elif joint.lower is not None or joint.upper is not None:
        yield f"Its limits are {_at(joint, joint.lower or 0.0)} and {_at(joint, joint.upper or 0.0)}."
    turns = joint.kind in TURNS
    if joint.velocity is not None:
        yield f"Its highest velocity is {_shown(joint.velocity)} {'rad/s' if turns else 'm/s'}."
    if joint.effort is not None:
        yield f"Its highest effort is {_shown(joint.effort)} {'Nm (torque)' if turns else 'N (force)'}."


def _at(joint: BodyJoint, value: float) -> str:
    if joint.kind in TURNS:
        return f"{_shown(value)} rad ({_shown(round(math.degrees(value), 1))} degrees)"
    return f"{_shown(value)} m"


def _shown(value: float) -> str:
    """A number as it was written: no digit is lost, and no zero is added."""
    return f"{value:.0f}" if value == int(value) and abs(value) < 1e15 else repr(value)
