# SPDX-License-Identifier: Apache-2.0
"""Whatever comes in as an order is one, or learns why it is none; names of nodes are those that ROS takes."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.errors import UsageError
from rai_missions.node.names import node_name
from rai_missions.node.order import LONGEST, WORDS, ClientOrder, OrderReply, mapping_in, read_order, who

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=10,
)
NEAR_ORDERS = st.dictionaries(
    st.sampled_from(
        ["id", "by", "command", "to", "question", "run", "option", "parameters", "event", "data", "arguments"]
    ),
    JSON | st.sampled_from(list(WORDS)),
) | st.fixed_dictionaries(
    {"command": st.sampled_from(list(WORDS)), "by": st.text(max_size=99) | JSON}, optional={"id": st.text() | JSON}
)


@given(text=st.text() | st.binary() | JSON | NEAR_ORDERS.map(json.dumps))
def test_whatever_comes_in_is_an_order_or_learns_why_not(text: Any) -> None:
    order = read_order(text)
    if isinstance(order, OrderReply):
        assert not order.success and order.why and len(order.why) < 500
    else:
        assert order.command in WORDS and order.by.isprintable() and len(order.by) <= 64


@given(
    command=st.sampled_from(list(WORDS)), name=st.text(max_size=60), by=st.text(min_size=1), number=st.integers(0, 9),
    data=st.dictionaries(
        st.text(st.characters(codec="utf-8")), st.integers(-(2**63), 2**63 - 1) | st.booleans(), max_size=3
    ),
)  # fmt: skip
def test_an_order_reports_what_was_written(command: str, name: str, by: str, number: int, data: dict[str, Any]) -> None:
    given_words = {"arguments": data, "to": "agent", "question": number, "run": "r", "option": "a", "parameters": data}
    given_words |= {"event": "go", "data": data}
    words = {word: given_words[word] for word in WORDS[command]}
    text = json.dumps({"id": name, "by": by, "command": command, **words})
    assert read_order(text) == ClientOrder(command, who(by), name.encode("utf-8", "replace").decode(), **words)


@given(depth=st.integers(100, 20_000))
def test_what_is_nested_without_end_is_refused(depth: int) -> None:
    assert isinstance(mapping_in('{"a":' + "[" * depth, "data"), str)


def test_what_is_too_long_is_not_read() -> None:
    assert isinstance(mapping_in(" " * (LONGEST + 1), "data"), str)
    assert mapping_in(" " * LONGEST, "data") == {}


@pytest.mark.parametrize(
    ("given_name", "namespace", "arguments", "path"),
    [
        ("tractor", "", [], "/tractor"),
        ("/fields/north/tractor", "", [], "/fields/north/tractor"),
        ("tractor", "/fields", [], "/fields/tractor"),
        ("tractor", "", ["-r", "__node:=other"], "/other"),
        ("tractor", "/fields", ["-r", "__ns:=/farm", "--remap", "__name:=other"], "/farm/other"),
        ("tractor", "", ["-r", "__ns:=/", "-r", "/a:=/b", "--params-file", "x.yaml"], "/tractor"),
    ],
)
def test_what_a_launch_file_remaps_comes_first(
    given_name: str, namespace: str, arguments: list[str], path: str
) -> None:
    assert node_name(given_name, namespace=namespace, ros_arguments=arguments).path == path


@pytest.mark.parametrize("name", ["", "1st", "a-b", "a b", "fields//a", "a/", "ä"])
def test_a_name_that_no_node_can_have_is_refused(name: str) -> None:
    with pytest.raises(UsageError, match="--node"):
        node_name(name)


@given(st.from_regex(r"(/?[A-Za-z_][A-Za-z0-9_]*)+", fullmatch=True))
def test_whatever_name_is_taken_is_one_path(name: str) -> None:
    assert node_name(name).below("status") == f"/{name.strip('/')}/status"
