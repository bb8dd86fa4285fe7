# SPDX-License-Identifier: Apache-2.0
"""The status of a run is what its chart has now, however many steps have changed nothing in it."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.runtime.lifecycle import Lifecycle, Status
from tests.strategies import EVENTS, missions

COMMANDS = ("pause", "resume", "cancel", "kill", "stop")
events = st.one_of(
    st.sampled_from(EVENTS).map(lambda name: Event(name)),
    st.sampled_from(COMMANDS).map(lambda name: Event(name, 0.0, {"by": "operator"}, "command")),
    st.sampled_from(("operator", "autonomy", "nobody")).map(
        lambda holder: Event(holder, 0.0, {"by": "operator", "role": "operator"}, "control")
    ),
)


def content(status: Status) -> Status:
    """What a status has of the chart, however the run came there."""
    return status._replace(revision=0, outcome=None, why="")


@given(missions(), st.lists(st.tuples(events, st.integers(0, 3)), max_size=12))
def test_a_status_has_what_the_chart_has_and_comes_with_each_change(
    mission: Mission, happened: list[tuple[Event, int]]
) -> None:
    chart, life = Chart(mission), Lifecycle()
    step, last = chart.start(0.0), None
    for event, seconds in [(Event(EVENTS[0]), 0), *happened]:
        status, of_now = life.observe(step, chart), Lifecycle().observe(step, chart)
        assert of_now is not None
        assert (status is None) == (last is not None and content(of_now) == content(last))
        last = status or last
        assert last is not None and content(last) == content(of_now) and last.outcome == chart.outcome
        step = chart.send(event._replace(at=chart.at + seconds))
