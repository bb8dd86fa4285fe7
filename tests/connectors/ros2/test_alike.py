# SPDX-License-Identifier: Apache-2.0
"""A run over ROS 2 or MQTT is what it is in one process: steps, states, written facts, and what the robot is asked for.

Rule: left out is what a middleware has no word for: why a goal or call failed, a cancel that no one asked for, and in
ROS the failure of a call whose response has no field for it.
"""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.connectors.local import LocalConnector
from rai_missions.connectors.mqtt.connector import MqttConnector
from rai_missions.connectors.ros2.messages import to_data, to_message
from tests.connectors.ros2.alike import COMMANDS, POSTED, REPORTS, Act, Count, Pair, Play
from tests.connectors.ros2.test_windows import UNSHRUNK
from tests.connectors.test_mqtt import Broker, needs_broker

names = itertools.count()
NUMBERS = [0.5, -2.0, math.inf, -math.inf, math.nan, -0.0]
TEXTS = ["", "grün", "日本 😀", 'a\n"b', "\u2028", '{"$bytes": "eA=="}']
LEAST, MOST = 25, 400


def typed(rng: random.Random, cls: Any) -> dict[str, Any]:
    """A message of test_msgs' BasicTypes, or a request or response of its service, with every field."""
    drawn = {
        "bool_value": rng.random() < 0.5, "byte_value": rng.randrange(256), "char_value": rng.randrange(256),
        "float32_value": rng.choice(NUMBERS), "float64_value": rng.choice([0.1, 1e300, *NUMBERS]),
        "int8_value": -128, "uint8_value": 255, "int32_value": rng.randrange(-5, 5), "uint32_value": 2**32 - 1,
        "int64_value": rng.choice([-(2**63), 2**63 - 1]), "uint64_value": rng.choice([2**64 - 1, 2**53 + 1]),
        "string_value": rng.choice(TEXTS),
    }  # fmt: skip
    known = cls.get_fields_and_field_types()
    return to_data(to_message(cls, {name: value for name, value in drawn.items() if name in known}))


def nested(rng: random.Random) -> dict[str, Any]:
    """A goal, feedback or result of test_msgs' NestedMessage."""
    from test_msgs.action import NestedMessage
    from test_msgs.msg import BasicTypes

    stamp = {"sec": rng.choice([0, -1, 2**31 - 1]), "nanosec": rng.randrange(10**9)}
    return to_data(NestedMessage.Goal()) | {"nested_field": typed(rng, BasicTypes), "nested_different_pkg": stamp}


def finite(value: Any) -> Any:
    """What a key can hold."""
    if isinstance(value, dict):
        return {name: finite(item) for name, item in value.items()}
    return value if not isinstance(value, float) or math.isfinite(value) else 1.5


def script(rng: random.Random, *, actions: bool) -> list[Act]:
    """What happens to a run, most of it about what has come to the robot last."""
    from test_msgs.msg import BasicTypes
    from test_msgs.srv import BasicTypes as Service

    answers = [*REPORTS[:5], "accepted", "accepted"] if actions else ["reply", "reply", "reply", "fail"]
    acts, came = list[Act](), 0
    for _ in range(rng.randrange(4, 14)):
        others = ["reply", "time", "refuses", "seen", "alarm", "resume", *COMMANDS]
        what = rng.choice([*POSTED[:2], *(POSTED if came else ("talk",)), *answers * 3 * bool(came), *others])
        came += what in POSTED
        which = max(rng.randrange(max(came, 1)) for _ in range(2))
        data: dict[str, Any] = {}
        if what in REPORTS[1:]:
            data = nested(rng)
        elif what in ("seen", "alarm"):
            data = typed(rng, BasicTypes)
        elif what == "reply":
            trigger = {"success": rng.random() < 0.8, "message": rng.choice(["", "failed: it is broken", "grün"])}
            data = {"typed": typed(rng, Service.Response), "trigger": trigger}
        elif what == "time":
            data = {"s": rng.choice([1.0, 4.0, 6.0, 31.0])}
        acts.append(Act(what, which, data))
    return acts


def agree(ends: Pair, seed: int, *, actions: bool) -> None:
    """Play a script in one process and then over a connector: both runs are the same."""
    from test_msgs.srv import BasicTypes as Service

    rng = random.Random(seed)
    sent = finite({"goal": nested(rng), "request": typed(rng, Service.Request)})
    acts, name = script(rng, actions=actions), f"/alike{next(names)}"
    local = LocalConnector()
    local.start()
    here, there = (Play(name, each, sent, actions=actions) for each in (Pair(local, local), ends))
    try:
        happened = [here.begin(Count(1, 0)), *(here.do(act, Count(0, 0)) for act in acts)]
        there.begin(happened[0])
        for act, least in zip(acts, happened[1:], strict=True):
            there.do(act, least)
        shown = [act[:2] for act in acts]
        for one, other in zip(here.story(), there.story(), strict=False):
            assert repr(one) == repr(other), shown
        assert len(here.story()) == len(there.story()), (shown, here.story()[-1], there.story()[-1])
        assert here.requests() == there.requests(), shown
    finally:
        here.end()
        there.end()
        local.stop()


@pytest.fixture(scope="module")
def over_ros(ros: None) -> Iterator[Pair]:
    from rai_missions.connectors.ros2 import open_connector

    ends = Pair(open_connector({"discovery_s": 30.0}), open_connector({"discovery_s": 30.0}))
    yield from _started(ends)


@pytest.fixture(scope="module")
def over_mqtt(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Pair]:
    broker = Broker(tmp_path_factory.mktemp("broker"))
    try:
        yield from _started(Pair(MqttConnector({"port": broker.port}), MqttConnector({"port": broker.port})))
    finally:
        broker.stop()


def _started(ends: Pair) -> Iterator[Pair]:
    for each in ends:
        each.start()
    yield ends
    for each in ends:
        each.stop()


seeds, tried = st.integers(0, 2**32), settings(max_examples=LEAST, phases=UNSHRUNK, report_multiple_bugs=False)
many = settings(tried, max_examples=MOST)


@given(seed=seeds, actions=st.booleans())
@tried
def test_a_run_over_ros_is_what_it_is_in_one_process(over_ros: Pair, seed: int, actions: bool) -> None:
    agree(over_ros, seed, actions=actions)


@needs_broker
@given(seed=seeds)
@tried
def test_a_run_over_mqtt_is_what_it_is_in_one_process(over_mqtt: Pair, seed: int) -> None:
    agree(over_mqtt, seed, actions=False)


@pytest.mark.drill
@given(seed=seeds, actions=st.booleans())
@many
def test_many_runs_over_ros_are_what_they_are_in_one_process(over_ros: Pair, seed: int, actions: bool) -> None:
    agree(over_ros, seed, actions=actions)


@pytest.mark.drill
@needs_broker
@given(seed=seeds)
@many
def test_many_runs_over_mqtt_are_what_they_are_in_one_process(over_mqtt: Pair, seed: int) -> None:
    agree(over_mqtt, seed, actions=False)
