# SPDX-License-Identifier: Apache-2.0
"""Whether a robot can be reached by its profile: its types, and its topics, services and actions.

Rule: the graph is inspected and no more: no request, command or message goes to the robot.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from rai_missions.cli.doctor.finding import MachineFinding, ProbeResult, tried
from rai_missions.connectors.connector import Hindrance
from rai_missions.connectors.registry import connector_offer
from rai_missions.errors import suggestion
from rai_missions.profile import Endpoint, Robot, connector_faults, endpoints, unknown_fields, wanted
from rai_missions.profile.type_fields import TypePart

__all__ = ("loads", "reach")

WITHIN_S = 10.0


def reach(
    robot: Robot, environment: Mapping[str, str] | None = None, *, within_s: float = WITHIN_S
) -> Iterator[MachineFinding]:
    """Look for a robot.

    Args:
        robot: Its profile.
        environment: The variables that its connector reads; this process's own if left out.
        within_s: Seconds that what the profile names may take to appear.
    """
    given = os.environ if environment is None else environment
    kind = str(robot.connector["kind"])
    if connector_offer(kind) is None:
        yield _local(kind, robot)
        return
    if kind == "ros2":
        yield from _types(robot, given)
    names = list(wanted(robot))
    by_mode = {
        mode: [(each.name, each.how, each.type) for each in names if each.mode == mode]
        for mode in ("topics", "services", "actions")
    }
    wishes = {"connector": robot.connector, "wanted": by_mode, "within_s": within_s}
    found = tried("graph", wishes, given, within_s=50.0 + within_s)
    if found.fault:
        yield MachineFinding("missing", f"the robot '{robot.name}' cannot be reached over {kind}", found.fault)
        return
    there: dict[str, dict[str, dict[str, str]]] = found.value["graph"]
    full: dict[str, dict[str, str]] = found.value["full"]
    by_endpoint = {each: full.get(each.mode, {}).get(each.name, each.name) for each in names}
    visible = [each for each in names if "listed" in there or (each.mode == "topics" and not each.is_listener)]
    if visible and not any(by_endpoint[each] in there[each.how].get(each.mode, ()) for each in visible):
        same = _reach(robot, given) if kind == "ros2" else "what the connector names"
        remedy = f"start the robot or its simulation, and compare {same} of both"
        yield MachineFinding("missing", f"nothing of the robot '{robot.name}' is there over {kind}", remedy)
        return
    wrong = [Hindrance(*each) for each in found.value["hindrances"]]
    places = {each.name: each.what for each in names}
    for one in wrong:
        what = f"{places.get(one.name, f'topic {one.name}')} {one.what}"
        yield MachineFinding("missing" if one.is_fatal else "warns", what, one.remedy)
    for each in names:
        if each in visible:
            finding = _looked_for(each, by_endpoint[each], there[each.how].get(each.mode, {}))
            if finding.status != "ok" or each.name not in {one.name for one in wrong}:
                yield finding
        else:
            verb = "listens" if each.is_listener else "serves it"
            yield MachineFinding("absent", f"{each.what} cannot be looked for: {kind} keeps to itself who {verb}")


def loads(program: Path) -> MachineFinding:
    """Whether the file of a robot in Python can be executed; a robot that it makes for each run is not made."""
    found = tried("python_robot", str(program), os.environ)
    if found.fault:
        return MachineFinding("missing", f"the robot {program} does not load", found.fault)
    offers = "; ".join(f"{sort} {', '.join(names) or 'none'}" for sort, names in found.value.items())
    return MachineFinding("ok", f"the robot {program} loads: {offers or 'it is made by robot(), once a run'}")


def _reach(robot: Robot, given: Mapping[str, str]) -> str:
    """The domain and the range in which a robot was looked for, as they are set here."""
    domain = robot.connector.get("domain_id") or given.get("ROS_DOMAIN_ID") or 0
    extent = given.get("ROS_AUTOMATIC_DISCOVERY_RANGE") or "SUBNET"
    return f"the domain (ROS_DOMAIN_ID, here {domain}) and the discovery range (here {extent})"


def _local(kind: str, robot: Robot) -> MachineFinding:
    for fault in connector_faults(robot):
        return MachineFinding("missing", f"the robot '{robot.name}' cannot be reached", str(fault))
    what = f"the robot '{robot.name}' is simulated with the run" if robot.world else f"'{robot.name}' is local"
    return MachineFinding("ok", what)


def _types(robot: Robot, given: Mapping[str, str]) -> Iterator[MachineFinding]:
    asked = list(endpoints(robot))
    found = tried("types", [[each.type, each.kind] for each in asked], given)
    if found.fault:
        yield MachineFinding("missing", f"the types that '{robot.name}' names cannot be looked up", found.fault)
        return
    yield from _fields(robot, given)
    absent = [(each, why) for each, why in zip(asked, found.value, strict=True) if why]
    yield from (MachineFinding("missing", f"{each.type_place.lstrip('/')}: {each.type}", why) for each, why in absent)
    if not absent:
        yield MachineFinding("ok", f"all {len({each.type for each in asked})} types that '{robot.name}' names are here")


def _fields(robot: Robot, given: Mapping[str, str]) -> Iterator[MachineFinding]:
    """Fields of which the profile speaks, and the types have not."""
    asked: dict[tuple[str, TypePart], None] = {}
    unknown_fields(None, robot, lambda *each: asked.setdefault(each))
    found = tried("fields", list(asked), given) if asked else ProbeResult([])
    if found.fault:
        yield MachineFinding("missing", f"the fields that '{robot.name}' names cannot be looked up", found.fault)
        return
    there = dict(zip(asked, found.value, strict=True))
    for fault in unknown_fields(None, robot, lambda *each: there[each]):
        yield MachineFinding("missing", fault.place.lstrip("/"), fault.sentence)


def _looked_for(each: Endpoint, name: str, there: Mapping[str, str]) -> MachineFinding:
    """What is there of an endpoint.

    Args:
        each: The endpoint.
        name: Its name in full.
        there: Full name → type.
    """
    what = each.what if name == each.name else f"{each.what} ({name})"
    if name not in there:
        if each.is_listener:
            return MachineFinding("absent", f"{what} has no listener")
        if each.may_be_silent:
            return MachineFinding("absent", f"{what} is not published now")
        return MachineFinding("missing", f"{what} is not there", f"start what offers it{suggestion(name, there)}")
    types = there[name]
    if each.type and types and each.type not in types.split(", "):
        return MachineFinding(
            "missing", f"{what} is there as {types}", f"the profile has {each.type}; correct one of them"
        )
    return MachineFinding("ok", what)
