# SPDX-License-Identifier: Apache-2.0
"""What a URDF holds of a robot's build: links with masses and sizes, joints with parents and limits.

Source: the URDF XML specification (`robot`, `link`, `inertial`, `collision`, `visual`, `geometry`, `joint`, `limit`).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter
from typing import Any, NamedTuple

from rai_missions.embodiment.document import visible
from rai_missions.embodiment.xml_events import RefusedXml, read_xml
from rai_missions.errors import suggestion
from rai_missions.redaction import cut, cut_repr

__all__ = ("JOINTS", "Body", "BodyJoint", "BodyLink", "BodyShape", "read_body")

MOST = 2_000
"""Links, joints or shapes that are read."""
LONGEST_NAME = 100
MOST_VALUE = 1e100
"""No measure, mass or limit is beyond that; all that is reckoned with such numbers stays finite."""
SHOWN = 40
SHAPES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "mesh": ()}
"""Shape → its measures, as attributes; a mesh is a file, which is not opened."""
JOINTS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
LIMITS = ("lower", "upper", "velocity", "effort")


class BodyShape(NamedTuple):
    """A shape of a link."""

    kind: str
    """`box`, `cylinder`, `sphere` or `mesh`."""
    measures_m: tuple[float, ...]
    """Box: its three edges; cylinder: radius and length; sphere: radius; mesh: none."""
    use: str
    """`collision` or `visual`."""
    origin_m: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Where its middle is, in the link."""
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    """How it is turned there: roll, pitch and yaw in radians, about the fixed axes."""


class BodyLink(NamedTuple):
    """A rigid part of a robot."""

    name: str
    mass_kg: float | None = None
    """None where none is given."""
    shapes: tuple[BodyShape, ...] = ()


class BodyJoint(NamedTuple):
    """What connects two links."""

    name: str
    kind: str
    """One of `JOINTS`."""
    parent: str = ""
    child: str = ""
    axis: tuple[float, ...] = (1.0, 0.0, 0.0)
    origin_m: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Where the child begins, in the parent."""
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    """How it is turned there: roll, pitch and yaw in radians, about the fixed axes."""
    lower: float | None = None
    """In radians, or metres for `prismatic`."""
    upper: float | None = None
    velocity: float | None = None
    """At most, in radians or metres a second."""
    effort: float | None = None
    """At most, in newton metres or newtons."""


class Body(NamedTuple):
    """A robot's build: a tree of links, in which each but the root has one parent."""

    name: str
    links: tuple[BodyLink, ...]
    joints: tuple[BodyJoint, ...]

    @property
    def mass_kg(self) -> float:
        """The sum of the masses that are given."""
        return math.fsum(link.mass_kg or 0.0 for link in self.links)

    def words(self) -> str:
        """The build in a few lines; fixed joints, which do not move, are left out."""
        links = [link.name for link in self.links]
        moving = [f"{joint.name} ({joint.kind})" for joint in self.joints if joint.kind != "fixed"]
        return f"Build of '{self.name}'. Links: {_listed(links)}. Moving joints: {_listed(moving)}."


def _listed(names: list[str]) -> str:
    more = f", and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return (", ".join(names[:SHOWN]) or "none") + more


class _Listener:
    """Receives the elements of a URDF; what is not of links and joints is passed over."""

    def __init__(self) -> None:
        self.path: list[str] = []
        self.name = ""
        self.links: list[dict[str, Any]] = []
        self.joints: list[dict[str, Any]] = []
        self._shapes = 0
        self._origin: dict[str, Any] = {}
        """Of the shape that is read."""

    def begin(self, tag: str, attributes: Mapping[str, str], line: int) -> None:
        name = _name(attributes.get("name", ""))
        match self.path:
            case []:
                if tag != "robot":
                    raise RefusedXml(f"is no URDF: it begins with <{cut(tag, LONGEST_NAME)}> instead of <robot>")
                self.name = name
            case ["robot"] if tag == "link":
                self.links.append({"name": name, "shapes": []})
            case ["robot"] if tag == "joint":
                self.joints.append({"name": name, "kind": _name(attributes.get("type", ""))})
            case ["robot", "link", "inertial"] if tag == "mass":
                self.links[-1]["mass_kg"] = _mass(attributes, line)
            case ["robot", "link"] if tag in ("collision", "visual"):
                self._origin = {}
            case ["robot", "link", "collision" | "visual"] if tag == "origin":
                self._origin = _origin(attributes, line)
            case ["robot", "link", ("collision" | "visual") as use, "geometry"] if tag in SHAPES:
                self._shapes += 1
                measures = _measures(tag, attributes, line)
                self.links[-1]["shapes"].append(BodyShape(tag, measures, use, **self._origin))
            case ["robot", "joint"]:
                self.joints[-1] |= _part_of_joint(tag, attributes, line)
        self.path.append(tag)
        if max(len(self.links), len(self.joints), self._shapes) > MOST:
            raise RefusedXml(f"has more than {MOST} links or joints")

    def text(self, text: str) -> None:
        """A URDF keeps everything in attributes."""

    def end(self, _tag: str) -> None:
        self.path.pop()


def read_body(_name: str, data: bytes) -> Body:
    """The build that a URDF describes.

    Raises:
        ValueError: It is no well-formed XML, no URDF, has a number that is none, links and joints that are no tree, or
            brings a document type, by which XML can read other files.
    """
    found = _Listener()
    read_xml(data, found)
    links = tuple(BodyLink(**{**link, "shapes": tuple(link["shapes"])}) for link in found.links)
    joints = tuple(BodyJoint(**joint) for joint in found.joints)
    if why := next(_contradictions([link.name for link in links], joints), ""):
        raise ValueError(why)
    return Body(found.name, links, joints)


def _contradictions(links: Sequence[str], joints: Sequence[BodyJoint]) -> Iterator[str]:
    """Where links and joints do not fit together; of such a file each sentence about the build may be wrong."""
    for sort, names in (("links", links), ("joints", [joint.name for joint in joints])):
        yield from (
            f"has two {sort} called '{name}'; rename one" for name, count in Counter(names).items() if count > 1
        )
    known = frozenset(links)
    for joint in joints:
        for end, link in (("parent", joint.parent), ("child", joint.child)):
            if not link:
                yield f"the joint '{joint.name}' lacks its {end}; write <{end} link=…/>"
            elif link not in known:
                yield f"the {end} of the joint '{joint.name}' is '{link}', which is no link{suggestion(link, links)}"
        if joint.lower is not None and joint.upper is not None and joint.lower > joint.upper:
            yield f"the limits of the joint '{joint.name}' are {joint.lower:g} to {joint.upper:g}; exchange them"
        if joint.kind not in JOINTS:
            yield f"the joint '{joint.name}' is of the type '{joint.kind}'{suggestion(joint.kind, JOINTS)}"
    yield from _tree_faults(links, joints)


def _tree_faults(links: Sequence[str], joints: Sequence[BodyJoint]) -> Iterator[str]:
    """Where joints between links that are there leave them no tree."""
    parents = Counter(joint.child for joint in joints)
    yield from (
        f"the link '{link}' is the child of {count} joints; leave it one"
        for link, count in parents.items()
        if count > 1
    )
    try:
        TopologicalSorter({joint.child: (joint.parent,) for joint in joints}).prepare()
    except CycleError as error:
        yield f"its joints are a circle: {_listed(error.args[1])}; remove one of them"
    roots = [link for link in links if link not in parents]
    if not links:
        yield "has no link; a xacro file is expanded first: xacro FILE -o robot.urdf"
    elif len(roots) > 1:
        yield f"has {len(roots)} links without a parent: {_listed(roots)}; connect them by joints"


def _name(written: str) -> str:
    """A name in one line, as a person sees it: it comes into prompts, too."""
    return cut(visible(written), LONGEST_NAME)


def _part_of_joint(tag: str, attributes: Mapping[str, str], line: int) -> dict[str, Any]:
    if tag in ("parent", "child"):
        return {tag: _name(attributes.get("link", ""))}
    if tag == "axis":
        return {"axis": _numbers(attributes.get("xyz", "1 0 0"), 3, "the axis", line)}
    if tag == "origin":
        return _origin(attributes, line)
    if tag == "limit":
        return {name: _number(attributes[name], f"the limit '{name}'", line) for name in LIMITS if name in attributes}
    return {}


def _origin(attributes: Mapping[str, str], line: int) -> dict[str, Any]:
    return {
        "origin_m": _numbers(attributes.get("xyz", "0 0 0"), 3, "the origin", line),
        "rpy": _numbers(attributes.get("rpy", "0 0 0"), 3, "the turn of the origin", line),
    }


def _mass(attributes: Mapping[str, str], line: int) -> float:
    mass = _number(attributes.get("value", ""), "the mass", line)
    if mass < 0:
        raise RefusedXml(f"has a negative mass in line {line}: {mass}")
    return mass


def _measures(tag: str, attributes: Mapping[str, str], line: int) -> tuple[float, ...]:
    if tag == "box":
        measures = _numbers(attributes.get("size", ""), 3, "the size of the box", line)
    else:
        measures = tuple(_number(attributes.get(name, ""), f"the {name} of the {tag}", line) for name in SHAPES[tag])
    if any(measure < 0 for measure in measures):
        raise RefusedXml(f"has a {tag} of negative size in line {line}: {', '.join(map(str, measures))}")
    return measures


def _numbers(text: str, count: int, what: str, line: int) -> tuple[float, ...]:
    parts = text.split(maxsplit=count)
    if len(parts) != count:
        raise RefusedXml(f"{what} in line {line} is {cut_repr(text, 40)}; it is {count} numbers")
    return tuple(_number(part, what, line) for part in parts)


def _number(text: str, what: str, line: int) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RefusedXml(f"{what} in line {line} is {cut_repr(text, 40)}, which is no number")
    if abs(value) > MOST_VALUE:
        raise RefusedXml(f"{what} in line {line} is {cut_repr(text, 40)}; at most {MOST_VALUE:g} is read")
    return value
