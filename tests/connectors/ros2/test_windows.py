# SPDX-License-Identifier: Apache-2.0
"""The action contract in every window, on a real server in another process and under a real run.

No goal runs that no state owns; no result reaches a state that did not start it; the old goal's end is confirmed
before a conflicting new one starts.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

from tests.connectors.ros2.scene import WINDOWS, Scene, ServerOnCall
from tests.connectors.ros2.scripted_server import ACCEPTS, CANCELS, ENDS, Script

scripts = st.builds(
    Script,
    accept=st.sampled_from(ACCEPTS),
    cancel=st.sampled_from(CANCELS),
    end=st.sampled_from(ENDS),
    is_repeated=st.booleans(),
)
goes = st.tuples(st.sampled_from(("left", "right", "left", "right", "halt")), scripts, st.sampled_from(WINDOWS))
UNSHRUNK = (Phase.explicit, Phase.reuse, Phase.generate)
"""A failure may be one of waiting: to make it smaller would take an hour."""


@pytest.fixture(scope="module")
def server(ros: None) -> Iterator[ServerOnCall]:
    made = ServerOnCall()
    yield made
    made.close()


def play(scene: Scene, moves: list[Any]) -> None:
    for state, script, window in moves:
        if state == "halt":
            scene.post("halt")
        else:
            scene.go(state, script, window)


def hold(connector: Any, server: ServerOnCall, moves: list[Any]) -> None:
    scene = Scene(connector, server)
    try:
        play(scene, moves)
    finally:
        scene.end()


@pytest.mark.long
@given(moves=st.lists(goes, min_size=1, max_size=6))
@example(moves=[("left", Script(cancel="late"), "runs"), ("right", Script(), "asked"), ("left", Script(), "over")])
@example(moves=[("left", Script(accept="late"), "asked"), ("right", Script(cancel="refused"), "runs")])
@settings(max_examples=15, phases=UNSHRUNK, report_multiple_bugs=False)
def test_whenever_a_state_is_left_its_goal_ends_before_the_next_begins(
    ours: Any, server: ServerOnCall, moves: list[Any]
) -> None:
    hold(ours, server, moves)


def check_a_disaster(connector: Any, disaster: str, script: Script, window: str) -> None:
    """A server is killed, or frozen for longer than it is waited for; the next goal goes to the one that comes back."""
    server = ServerOnCall()
    scene = Scene(connector, server)
    try:
        scene.go("left", script, window)
        server.kill() if disaster == "killed" else server.freeze()
        scene.wait_for_rest()
        server.restart() if disaster == "killed" else server.thaw()
        scene.go("right", Script(), "runs")
    finally:
        server.thaw()
        scene.end()
        server.close()


@pytest.mark.parametrize(
    ("disaster", "accept", "window"),
    [
        ("killed", "at once", "runs"),
        pytest.param("killed", "late", "asked", marks=pytest.mark.drill),
        pytest.param("frozen", "at once", "runs", marks=pytest.mark.drill),
        pytest.param("frozen", "late", "asked", marks=pytest.mark.drill),
    ],
)
def test_the_goal_of_a_server_that_was_away_is_over_before_the_next_one_begins(
    ours: Any, disaster: str, accept: str, window: str
) -> None:
    check_a_disaster(ours, disaster, Script(accept=accept), window)


@pytest.mark.drill
@given(moves=st.lists(goes, min_size=1, max_size=10))
@settings(max_examples=400, phases=UNSHRUNK, report_multiple_bugs=False)
def test_hundreds_of_runs_leave_states_in_every_window(ours: Any, server: ServerOnCall, moves: list[Any]) -> None:
    hold(ours, server, moves)


@pytest.mark.drill
@given(disaster=st.sampled_from(("killed", "frozen")), script=scripts, window=st.sampled_from(WINDOWS))
@settings(max_examples=30, phases=UNSHRUNK, report_multiple_bugs=False)
def test_servers_that_die_in_every_window_leave_nothing_running(
    ours: Any, disaster: str, script: Script, window: str
) -> None:
    check_a_disaster(ours, disaster, script, window)
