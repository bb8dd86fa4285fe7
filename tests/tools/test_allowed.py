# SPDX-License-Identifier: Apache-2.0
"""What tools may touch: never before write before read, whole names alone, deny where nothing allows."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.connector import Close, ConnectorMode, Data, Message, Reply, Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError
from rai_missions.tools import Allowlist, Toolbox
from rai_missions.tools.access import AllowedConnector

NAMES = ("/a", "/a/b", "/a/b/e_stop", "/cmd_vel", "/cmd_vel/request", "/tf", "/tf_static", "/x")
PATTERNS = ("*", "/a", "/a/*", "*/e_stop", "/cmd_vel", "/tf*", "/?")
patterns = st.lists(st.sampled_from(PATTERNS), max_size=2).map(tuple)
allowed = st.builds(Allowlist, read=patterns, write=patterns, never=patterns)


class Noting(LocalConnector):
    """The connector in process, noting every name that reaches it, and for what."""

    def __init__(self) -> None:
        super().__init__()
        self.touched: set[tuple[str, str]] = set()

    def subscribe(self, topic: str, type_name: str, on_message: Callable[[Message], None]) -> Close:
        self.touched.add((topic, "read"))
        return super().subscribe(topic, type_name, on_message)

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        self.touched.add((topic, "write"))
        super().publish(topic, type_name, message)

    def call(
        self,
        service: str,
        type_name: str,
        request: Data,
        *,
        on_reply: Callable[[Reply], None],
        timeout_s: float | None = None,
    ) -> None:
        self.touched.add((service, "write"))
        super().call(service, type_name, request, on_reply=on_reply, timeout_s=timeout_s)

    def send_goal(
        self, action: str, type_name: str, goal: Data, *, goal_id: str, on_report: Callable[[Report], None]
    ) -> None:
        self.touched.add((action, "write"))
        super().send_goal(action, type_name, goal, goal_id=goal_id, on_report=on_report)


def expected(rules: Allowlist, name: str, deed: str) -> bool:
    """The law, reported again in another way: by the plain strings."""
    parents = [name[:end] for end in range(1, len(name) + 1) if end == len(name) or name[end] == "/"]
    if any(matches(pattern, parent) for pattern in rules.never for parent in parents):
        return False
    may = rules.write if deed == "write" else rules.read + rules.write
    return any(matches(pattern, name) for pattern in may)


def matches(pattern: str, name: str) -> bool:
    """For the patterns above: at most one star, at an end."""
    if pattern.startswith("*"):
        return name.endswith(pattern[1:])
    if pattern.endswith("*"):
        return name.startswith(pattern[:-1])
    return len(name) == 2 if pattern == "/?" else name == pattern


@given(allowed, st.sampled_from(NAMES), st.sampled_from(["read", "write"]))
def test_never_goes_before_write_and_write_before_read(rules: Allowlist, name: str, deed: Any) -> None:
    assert rules.allows(name, deed) == expected(rules, name, deed)


def calls(name: str) -> list[tuple[str, dict[str, Any]]]:
    """Every tool that takes a name, with this one."""
    return [
        ("receive_message", {"topic": name, "timeout_s": 0}),
        ("get_image", {"topic": name, "timeout_s": 0}),
        ("publish_message", {"topic": name, "message": {}, "timeout_s": 0}),
        ("call_service", {"service": name, "timeout_s": 0}),
        ("start_action", {"action": name, "timeout_s": 0}),
        ("get_transform", {"target": "a", "source": "b", "timeout_s": 0}),
        ("get_distance_to_objects", {"detections_topic": name, "cloud_topic": "/x", "timeout_s": 0}),
        ("get_distance_to_objects", {"detections_topic": "/x", "cloud_topic": name, "timeout_s": 0}),
        ("get_robot_pose", {"topic": name, "timeout_s": 0}),
        ("get_robot_pose", {"timeout_s": 0}),
        ("get_occupancy_grid", {"topic": name, "timeout_s": 0}),
        ("navigate_to_pose", {"x": 1, "y": 2, "action": name, "timeout_s": 0}),
        ("list_goals", {}),
        ("cancel_action", {"goal_id": name}),
        ("list_topics", {}),
        ("list_actions", {"containing": name}),
    ]


some_calls = st.lists(st.sampled_from(NAMES).flatmap(lambda name: st.sampled_from(calls(name))), max_size=8)


@given(allowed, some_calls)
def test_no_tool_touches_a_name_that_is_not_allowed_whatever_is_asked(
    rules: Allowlist, asked: list[tuple[str, dict[str, Any]]]
) -> None:
    connector = Noting()
    connector.start()
    for topic in NAMES:
        LocalConnector.subscribe(connector, topic, "", lambda _: None)
    box = Toolbox(connector, rules, now=time.monotonic)
    tools = {tool.name: tool for tool in box.tools}
    listed = [str(tools[name].invoke(arguments)) for name, arguments in asked]
    box.stop(0.0)
    connector.stop()
    refused = {each for each in connector.touched if not expected(rules, *each)}
    assert not refused, f"{refused} under {rules}"
    for (name, _), reported in zip(asked, listed, strict=True):
        if name.startswith("list_"):
            assert all(f'"{hidden}"' not in reported for hidden in NAMES if not expected(rules, hidden, "read"))


def test_what_is_allowed_is_touched() -> None:
    connector = Noting()
    connector.start()
    box = Toolbox(connector, Allowlist(write=("/a",)), now=time.monotonic)
    box.acting.publish_message("/a", {}, type_name="t")
    box.looking.receive_message("/x", timeout_s=0)
    assert connector.touched == {("/a", "write"), ("/x", "read")}


def test_the_way_to_the_robot_judges_each_name_itself() -> None:
    connector = Noting()
    connector.start()
    reach = AllowedConnector(connector, Allowlist(read=("/x",)), time.monotonic)
    attempts: list[Callable[[], object]] = [
        lambda: reach.publish("/x", "t", {}),
        lambda: reach.call("/x", "t", {}, 0.0),
        lambda: reach.send_goal("/x", "t", {}, "g", print),
        lambda: reach.subscribe("/y", "t", print, 0.0),
        lambda: reach.receive({"/y": "t"}, 0.0, bool),
        lambda: reach.type_of("topics", "/y", "t", 0.0),
    ]
    for attempt in attempts:
        with pytest.raises(UsageError, match="may not be"):
            attempt()
    assert connector.touched == set()


def test_nothing_may_be_written_where_no_one_states_it() -> None:
    box = Toolbox(LocalConnector(), now=time.monotonic)
    with pytest.raises(UsageError, match="'/a' may not be written; what may be written: nothing"):
        box.acting.call_service("/a")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("cmd_vel", "'cmd_vel' is no whole name; one begins with a slash"),
        ("~/cmd_vel", "is no whole name"),
        ("/cmd_vel/", "is no whole name"),
        ("//cmd_vel", "is no whole name"),
        ("/a/../cmd_vel", "is no whole name"),
        ("/cmd_vel\n", "is no whole name"),
        ("/" + "a" * 300, "is no whole name"),
        ("#", "is no whole name"),
        ("/cmd_vel", "'/cmd_vel' must never be touched; what may be written: *, but never /cmd_vel"),
        ("/cmd_vel/_action/send_goal", "must never be touched"),
    ],
)
def test_a_name_in_disguise_is_refused(name: str, message: str) -> None:
    why = Allowlist(write=("*",), never=("/cmd_vel",)).refusal(name, "write")
    assert why.startswith("refused: ")
    assert message in why


def test_a_refusal_reports_what_is_allowed() -> None:
    rules = Allowlist(read=("/tractor1/*",), write=("/tractor1/flash",))
    assert (
        rules.refusal("/x", "read") == "refused: '/x' may not be read; what may be read: /tractor1/*, /tractor1/flash"
    )
    assert rules.refusal("/x", "write") == "refused: '/x' may not be written; what may be written: /tractor1/flash"


@pytest.mark.parametrize("given_", ["/a", (3,), ("",)])
def test_patterns_are_a_list_of_texts(given_: Any) -> None:
    with pytest.raises(UsageError, match="'never' is a list of patterns"):
        Allowlist(never=given_)
    with pytest.raises(UsageError, match="'never': 'cmd_vel' fits no name; each begins with a slash, as in '/cmd_vel'"):
        Allowlist(never=("*/e_stop", "cmd_vel"))


def test_the_mode_of_a_connector_that_has_none_is_reported() -> None:
    class TopicsOnly(LocalConnector):
        modes: frozenset[ConnectorMode] = frozenset({"topics"})

    box = Toolbox(TopicsOnly(), Allowlist(write=("*",)), now=time.monotonic)
    with pytest.raises(UsageError, match="this robot's connector carries no actions; it carries topics"):
        box.looking.list_actions()
    with pytest.raises(UsageError, match="carries no actions"):
        box.acting.start_action("/a", type_name="t")
    with pytest.raises(UsageError, match="carries no services"):
        box.acting.call_service("/a", type_name="t")
