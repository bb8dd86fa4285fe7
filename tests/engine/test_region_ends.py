# SPDX-License-Identifier: Apache-2.0
"""A parallel state has ended once each region has, and has succeeded only where each final's `requires` came true."""

from __future__ import annotations

from typing import Any, NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.snapshot_json import packed, unpacked
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission

LAST = 20.0


class Region(NamedTuple):
    """A region of a parallel state, all times in seconds."""

    ends_at: float
    """When its final is entered."""
    known_at: float | None
    """When the key becomes true that its final requires; None for never."""
    nested: bool
    """It is inside a parallel state of its own."""

    def end(self, settle_s: float) -> tuple[float, str]:
        """When it ends, and how."""
        if self.known_at is not None and self.known_at < self.ends_at + settle_s:
            return max(self.ends_at, self.known_at), "succeeded"
        return self.ends_at + settle_s, "unverified"


def mission(regions: list[Region], settle_s: float) -> Mission:
    """Its parallel state has these regions, and each of its outcomes a state of that name."""

    def written(number: int, region: Region) -> dict[str, Any]:
        final = {"final": "succeeded", "requires": {"key": f"k{number}", "==": True}}
        waits = {"transitions": [{"after_s": region.ends_at, "to": f"f{number}"}]}
        inner: dict[str, Any] = {"initial": f"w{number}", "states": {f"w{number}": waits, f"f{number}": final}}
        return {"parallel": {f"i{number}": inner}} if region.nested else inner

    ends = ("succeeded", "unverified")
    return Mission.model_validate({
        "name": "regions", "initial": "p", "settle_s": settle_s,
        "blackboard": {f"k{number}": {"type": "boolean", "initial": False} for number, _ in enumerate(regions)},
        "states": {
            "p": {
                "parallel": {f"r{number}": written(number, each) for number, each in enumerate(regions)},
                "transitions": [{"on": end, "to": f"was_{end}"} for end in ends],
            },
            **{f"was_{end}": {} for end in ends},
        },
    })  # fmt: skip


REGIONS = st.builds(
    Region, st.sampled_from([1.0, 2.0, 3.0]), st.none() | st.sampled_from([0.5, 1.5, 2.5, 4.5, 6.5]), st.booleans()
)


@given(st.lists(REGIONS, min_size=1, max_size=4), st.sampled_from([0.0, 1.0, 4.0]), st.booleans())
def test_regions_end_together_and_the_worst_of_them_counts(
    regions: list[Region], settle_s: float, restores: bool
) -> None:
    made = mission(regions, settle_s)
    chart = Chart(made)
    chart.start(0.0)
    known = [(each.known_at, number) for number, each in enumerate(regions) if each.known_at is not None]
    entered: dict[str, float] = {}
    for at, event in sorted(
        [(at, f"k{number}") for at, number in known] + [(instant / 2, "") for instant in range(1, int(LAST))]
    ):
        if restores:
            chart = Chart.restore(made, unpacked(packed(chart.snapshot())))
        step = chart.send(Event(event, at, {"value": True}, "write") if event else Tick(at))
        entered |= dict.fromkeys(step.entered, at)
    ends = [each.end(settle_s) for each in regions]
    outcome = "succeeded" if all(how == "succeeded" for _, how in ends) else "unverified"
    assert {name: at for name, at in entered.items() if name.startswith("was_")} == {
        f"was_{outcome}": max(at for at, _ in ends)
    }


@pytest.mark.parametrize(("known", "end"), [(True, "was_succeeded"), (False, "was_unverified")])
def test_a_region_that_is_a_final_has_its_requires(known: bool, end: str) -> None:
    states = mission([Region(1.0, None, False)], 0.0).written()["states"]
    states["p"]["parallel"] = {"r": {"final": "succeeded", "requires": {"key": "k", "==": True}}}
    made = Mission.model_validate({
        "name": "regions", "initial": "p", "blackboard": {"k": {"type": "boolean", "initial": known}}, "states": states,
    })  # fmt: skip
    chart = Chart(made)
    assert chart.start(0.0).entered[-1] == end
