# SPDX-License-Identifier: Apache-2.0
"""A run that was killed continues over ROS 2 or MQTT as it does in one process, whatever has become of its robot.

Rule: what is compared, and what is left out, is as in `test_alike.py`; all lives of a run are one story.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.connectors.connector import Connector
from rai_missions.connectors.local import LocalConnector
from rai_missions.connectors.mqtt.connector import MqttConnector
from tests.connectors.ros2.alike import COMMANDS, POSTED, REPORTS, Act, Count
from tests.connectors.ros2.mortal_alike import Death, MortalPlay, Ways
from tests.connectors.ros2.test_alike import finite, many, names, nested, seeds, tried, typed
from tests.connectors.test_mqtt import Broker, needs_broker

FOUND_S, FEW = 5.0, 6
FATES = ("write", "send_goal", "call", "publish", "cancel_goal")


def script(rng: random.Random, *, actions: bool) -> list[Act]:
    """What happens to a run and its robot; it dies, and continues, about twice."""
    from test_msgs.srv import BasicTypes as Service

    answers = [*REPORTS[:5], "accepted", "accepted"] if actions else ["reply", "reply", "reply", "fail"]
    acts, came = [Act(f"go_{rng.choice(['left', 'right'])}")], 1
    for _ in range(rng.randrange(4, 12)):
        others = ["time", "refuses", "resume", *COMMANDS, "dies", "dies", "dies", "continues", "continues", "continues"]
        robot = ["robot_dies", "robot_restarts", "robot_restarts"] if rng.random() < 0.3 else []
        what = rng.choice([*POSTED[:2], *POSTED, *answers * 2, *others, *robot])
        came += what in POSTED
        which = max(rng.randrange(max(came, 1)) for _ in range(2))
        data: dict[str, Any] = {}
        if what in REPORTS[1:]:
            data = nested(rng)
        elif what == "reply":
            trigger = {"success": rng.random() < 0.8, "message": rng.choice(["", "failed: it is broken", "grün"])}
            data = {"typed": typed(rng, Service.Response), "trigger": trigger}
        elif what == "time":
            data = {"s": rng.choice([1.0, 4.0, 6.0, 31.0])}
        acts.append(Act(what, which, data))
    return [*acts, Act("continues")]


def deaths(rng: random.Random) -> list[Death]:
    """How each process dies, if not by an act."""
    return [
        Death(rng.choice(FATES), rng.randrange(6), is_done=rng.random() < 0.5) if rng.random() < 0.6 else Death()
        for _ in range(3)
    ]


def agree(ways: Ways, seed: int, folder: Path, *, actions: bool) -> None:
    """Play a script, deaths included, in one process and then over a connector: both runs are the same."""
    from test_msgs.srv import BasicTypes as Service

    rng = random.Random(seed)
    sent = finite({"goal": nested(rng), "request": typed(rng, Service.Request)})
    acts, ends, name = script(rng, actions=actions), deaths(rng), f"/resumed{next(names)}"
    here, there = (
        MortalPlay(name, each, sent, folder / f"{number}{name[1:]}.journal", ends, actions=actions)
        for number, each in enumerate((in_one_process(), ways))
    )
    shown = [tuple(act[:2]) for act in acts], ends
    try:
        happened = [here.begin(Count(1, 0)), *(here.do(act, Count(0, 0)) for act in acts)]
        there.begin(happened[0])
        for act, least in zip(acts, happened[1:], strict=True):
            there.do(act, least)
        for one, other in zip(here.story(), there.story(), strict=False):
            assert repr(one) == repr(other), (shown, one, other)
        assert len(here.story()) == len(there.story()), (shown, here.story()[-1], there.story()[-1])
        assert here.requests() == there.requests(), (shown, here.requests(), there.requests())
    finally:
        here.end()
        there.end()


def in_one_process() -> Ways:
    shared: list[Connector] = []

    def robot() -> Connector:
        shared[:] = [LocalConnector()]
        return shared[0]

    return Ways(robot, lambda: shared[0], lambda connector: None)


@pytest.fixture(scope="module")
def over_ros(ros: None) -> Ways:
    from rai_missions.connectors.ros2 import open_connector

    def crash(connector: Any) -> None:
        connector._session.runtime.close()  # as a process that is killed

    def open_one() -> Connector:
        return open_connector({"discovery_s": FOUND_S})

    return Ways(open_one, open_one, crash)


@pytest.fixture(scope="module")
def over_mqtt(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ways]:
    broker = Broker(tmp_path_factory.mktemp("broker"))

    def open_one() -> Connector:
        return MqttConnector({"port": broker.port})

    try:
        yield Ways(open_one, open_one, lambda connector: connector.stop())
    finally:
        broker.stop()


few = settings(tried, max_examples=FEW)


@given(seed=seeds, actions=st.booleans())
@few
def test_a_killed_run_continues_over_ros_as_in_one_process(
    over_ros: Ways, tmp_path_factory: pytest.TempPathFactory, seed: int, actions: bool
) -> None:
    agree(over_ros, seed, tmp_path_factory.mktemp("ros"), actions=actions)


@needs_broker
@given(seed=seeds)
@few
def test_a_killed_run_continues_over_mqtt_as_in_one_process(
    over_mqtt: Ways, tmp_path_factory: pytest.TempPathFactory, seed: int
) -> None:
    agree(over_mqtt, seed, tmp_path_factory.mktemp("mqtt"), actions=False)


@pytest.mark.drill
@pytest.mark.timeout(7200)
@given(seed=seeds, actions=st.booleans())
@many
def test_many_killed_runs_continue_over_ros_as_in_one_process(
    over_ros: Ways, tmp_path_factory: pytest.TempPathFactory, seed: int, actions: bool
) -> None:
    agree(over_ros, seed, tmp_path_factory.mktemp("ros"), actions=actions)


@pytest.mark.drill
@pytest.mark.timeout(7200)
@needs_broker
@given(seed=seeds)
@many
def test_many_killed_runs_continue_over_mqtt_as_in_one_process(
    over_mqtt: Ways, tmp_path_factory: pytest.TempPathFactory, seed: int
) -> None:
    agree(over_mqtt, seed, tmp_path_factory.mktemp("mqtt"), actions=False)
