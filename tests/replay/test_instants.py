# SPDX-License-Identifier: Apache-2.0
"""Each instant at which a drill kills a process is still one of the code."""

from __future__ import annotations

import importlib
from operator import attrgetter

import pytest

from tests.replay.instants import INSTANTS


@pytest.mark.parametrize("name", INSTANTS)
def test_an_instant_is_a_call_of_the_code(name: str) -> None:
    module, _, path = INSTANTS[name].place.partition(":")
    if "ros2" in module:
        pytest.importorskip("rclpy")
    assert callable(attrgetter(path)(importlib.import_module(module)))
