# SPDX-License-Identifier: Apache-2.0
"""Whether the servers of a goal are gone, or others are there instead."""

from __future__ import annotations

import pytest

ONE, OTHER = b"1", b"2"


@pytest.mark.parametrize(
    ("then", "now", "gone", "replaced"),
    [
        ({}, {}, False, False),
        ({ONE: "/a"}, {ONE: "/a"}, False, False),
        ({ONE: "/a"}, {ONE: "/a", OTHER: "/b"}, False, False),
        ({ONE: "/a"}, {}, True, False),
        ({ONE: "/a"}, {OTHER: "/a"}, True, True),
        ({ONE: "/a"}, {OTHER: "/b"}, True, True),
        ({ONE: "/a"}, {ONE: "/a", OTHER: "/a"}, True, True),
        ({ONE: ""}, {ONE: "", OTHER: ""}, False, False),
    ],
)
def test_a_server_is_replaced_only_by_one_that_is_there(
    then: dict[bytes, str], now: dict[bytes, str], gone: bool, replaced: bool
) -> None:
    from rai_missions.connectors.ros2.endpoints import are_gone, are_replaced

    assert (are_gone(then, now), are_replaced(then, now)) == (gone, replaced)
