# SPDX-License-Identifier: Apache-2.0
"""What the doctor tries in a process of its own: `python -m rai_missions.cli.doctor.probe WHAT`.

Rule: the input is JSON. The last line of the output is the answer, as JSON; where there is none, the exit status is
not 0 and stderr holds the reason.
"""

from __future__ import annotations

import json
import sys
import time
import uuid
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from rai_missions.errors import DefinitionError, MissionError

if TYPE_CHECKING:
    from rai_missions.connectors.connector import Connector, ConnectorMode, Message

    Graph = dict[str, dict[ConnectorMode, dict[str, str]]]
    """`listed` or `offered` → mode → name → type; without `listed` where no one reports what others do."""
    Wanted = dict[ConnectorMode, list[tuple[str, str, str]]]
    """Mode → names, each with how it must be there, and its type."""

__all__ = ("main",)

LOOK_S = 0.05
DISCOVERY_S = 15.0
SECOND_S = 1.0
"""How much later than the first server of a name a second one may be found."""


def load(_: Any) -> dict[str, str]:
    """Where rclpy comes from, and which middleware it speaks through."""
    from rai_missions.connectors.ros2 import installation

    return installation()


def discovery(_: Any) -> float | None:
    """How many seconds a node takes to find another; None if it does not."""
    from rai_missions.connectors.ros2 import open_connector

    one, other = open_connector({}), open_connector({})
    topic = f"/rai_missions_doctor_{uuid.uuid4().hex[:8]}"
    other.start()
    other.serve(topic, "std_srvs/srv/Trigger", lambda _: {"success": True})
    began = time.monotonic()
    one.start()
    try:
        found = _awaited(lambda: topic in one.listed("services"), DISCOVERY_S)
        return time.monotonic() - began if found else None
    finally:
        one.stop()
        other.stop()


def types(wanted: list[list[Any]]) -> list[str]:
    """Why each type of a kind is not here; empty for one that is."""
    from rai_missions.connectors.ros2 import why_absent

    return [why_absent(name, kind) for name, kind in wanted]


def fields(wanted: list[list[Any]]) -> list[Any]:
    """What each type of a kind holds; None for one that is not here."""
    from rai_missions.connectors.ros2 import fields_of

    return [fields_of(name, kind) for name, kind in wanted]


def python_robot(file: str) -> dict[str, list[str]]:
    """What the robot in a Python file offers, by sort; nothing where the file makes one for each run.

    Raises:
        DefinitionError: It offers none, or one whose rules, or how it talks, are at fault.
    """
    from rai_missions.agents.talk.settings import conversation_faults
    from rai_missions.connectors.python_robot import PythonRobot
    from rai_missions.profile import profile_of, read_program

    program = read_program(file)
    offered = getattr(program.module, "robot", None)
    robot = offered if callable(offered) and not isinstance(offered, PythonRobot) else program.robot()
    if not isinstance(robot, PythonRobot):
        return {}
    if faults := conversation_faults(profile_of(robot, None, program)):
        raise DefinitionError(faults, file)
    sorts: Mapping[str, Mapping[str, object]] = {
        "facts": robot.fact_functions,
        "services": robot.service_functions,
        "actions": robot.action_functions,
        "topics": robot.topic_functions,
    }
    return {sort: list(functions) for sort, functions in sorts.items()}


def answerer(wanted: list[str]) -> None:
    """Whether an answerer of another package can be opened, given the fields of its offer."""
    from rai_missions.answerers.registry import open_answerer
    from rai_missions.kinds import PackageOffer

    open_answerer(PackageOffer(*wanted))


def sound_devices(_: Any) -> list[Any]:
    """The devices of sound: name, channels in, channels out."""
    from rai_missions.connectors.sound.devices import sound_devices as found

    return [list(each) for each in found()]


def microphone_level(_: Any) -> list[int]:
    """What the default microphone records: samples, the loudest, and how many are clipped."""
    from rai_missions.connectors.sound.devices import microphone_level as found

    return list(found())


def graph(given: Mapping[str, Any]) -> dict[str, Any]:
    """What is there by mode, waited for as long as something wanted is not: `listed`, and of that what is `offered`.

    What is listed and not offered has only subscribers or clients. Where the middleware does not report what others do,
    a topic is there once a message of it was received, and nothing else is known to be.
    """
    from rai_missions.connectors.connector import ListsItself
    from rai_missions.connectors.registry import connector_offer, open_offered

    options = dict(given["connector"])
    offer = connector_offer(options.pop("kind"))
    assert offer is not None
    connector = open_offered(offer, options)
    wanted: Wanted = {mode: names for mode, names in given["wanted"].items() if mode in connector.modes}
    connector.start()
    try:
        if isinstance(connector, ListsItself):
            wanted = {"topics": [each for each in wanted.get("topics", ()) if each[1] == "offered"]}
            look = _received(connector, wanted)
        else:
            look = _listed(connector, wanted)

        full = _resolved(connector, wanted)

        def is_there() -> bool:
            now = look()
            return all(full[mode][name] in now[how][mode] for mode, names in wanted.items() for name, how, _ in names)

        _awaited(is_there, float(given["within_s"]))
        return {"graph": look(), "full": full, "hindrances": _hindrances(connector, given["wanted"])}
    finally:
        connector.stop()


def _listed(connector: Connector, wanted: Wanted) -> Callable[[], Graph]:
    from rai_missions.connectors.connector import SupportsDiscoveryCount

    def look() -> Graph:
        listed = {mode: dict(connector.listed(mode)) for mode in wanted}
        if not isinstance(connector, SupportsDiscoveryCount):
            return {"listed": listed, "offered": listed}
        offered = {
            mode: {name: types[name] for name in connector.offered(mode) if name in types}
            for mode, types in listed.items()
        }
        return {"listed": listed, "offered": offered}

    return look


def _resolved(connector: Connector, wanted: Wanted) -> dict[ConnectorMode, dict[str, str]]:
    """Mode → the profile's name → the name in full, by which it is listed."""
    from rai_missions.connectors.connector import ResolvesNames

    def full(mode: ConnectorMode, name: str) -> str:
        return connector.resolved(mode, name) if isinstance(connector, ResolvesNames) else name

    return {mode: {name: full(mode, name) for name, _, _ in names} for mode, names in wanted.items()}


def _hindrances(connector: Connector, wanted: Wanted) -> list[Any]:
    """What is wrong with what is wanted, where the connector knows."""
    from rai_missions.connectors.connector import SupportsInspection

    if not isinstance(connector, SupportsInspection):
        return []
    time.sleep(SECOND_S)
    asked = [(mode, name, how == "listed") for mode, names in wanted.items() for name, how, _ in names]
    return [list(each) for each in connector.hindrances(asked)]


def _received(connector: Connector, wanted: Wanted) -> Callable[[], Graph]:
    there: dict[str, str] = {}

    def receive(message: Message) -> None:
        there[message.topic] = ""

    for name, _, type_name in wanted["topics"]:
        connector.subscribe(name, type_name, receive)
    return lambda: {"offered": {"topics": dict(there)}}


def _awaited(is_so: Callable[[], bool], within_s: float) -> bool:
    until = time.monotonic() + within_s
    while not is_so():
        if time.monotonic() > until:
            return False
        time.sleep(LOOK_S)
    return True


PROBES: Mapping[str, Callable[[Any], Any]] = {
    "load": load,
    "discovery": discovery,
    "types": types,
    "fields": fields,
    "graph": graph,
    "python_robot": python_robot,
    "answerer": answerer,
    "sound_devices": sound_devices,
    "microphone_level": microphone_level,
}


def main() -> int:
    """Try what the command line names; returns the exit status."""
    try:
        answer = PROBES[sys.argv[1]](json.loads(sys.stdin.read()))
    except (MissionError, ImportError, OSError) as fault:
        sys.stderr.write(f"{fault}\n")
        return 1
    sys.stdout.write(f"\n{json.dumps(answer)}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
