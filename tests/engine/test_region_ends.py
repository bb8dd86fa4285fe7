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
    return Mission.model_validate(
        {
            "name": "regions",
            "initial": "p",
            "settle_s": settle_s,
            "blackboard": {f"k{number}": {"type": "boolean", "initial": False} for number, _ in enumerate(regions)},
            "states": {
                "p": {
                    "parallel": {f"r{number}": written(number, each) for number, each in enumerate(regions)},
                    "transitions": [{"on": end, "to": f"was_{end}"} for end in ends],
                },
                **{f"was_{end}": {} for end in ends},
            },
        }
    )


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


@given(st.lists(st.tuples(st.none() | st.integers(0, 3), st.booleans()), min_size=1, max_size=4), st.booleans())
def test_a_region_that_goes_over_a_list_ends_with_its_last_item(
    regions: list[tuple[int | None, bool]], restores: bool
) -> None:
    """One event ends a round in every region at once; a region without a list, None, has one."""

    def written(number: int, items: int | None) -> dict[str, Any]:
        waits = {"transitions": [{"on": "go", "to": f"f{number}"}]}
        inner = {"initial": f"w{number}", "states": {f"w{number}": waits, f"f{number}": {"final": "succeeded"}}}
        return inner if items is None else {"each": f"l{number}", "as": f"i{number}", **inner}

    lists = {f"l{number}": {"type": "list", "initial": [1] * (items or 0)} for number, (items, _) in enumerate(regions)}
    parallel = {
        f"r{number}": {"parallel": {f"n{number}": written(number, items)}} if nested else written(number, items)
        for number, (items, nested) in enumerate(regions)
    }
    made = Mission.model_validate(
        {
            "name": "lists",
            "initial": "p",
            "events": ["go"],
            "blackboard": lists | {f"i{number}": {"type": "integer"} for number, _ in enumerate(regions)},
            "states": {"p": {"parallel": parallel, "transitions": [{"on": "succeeded", "to": "over"}]}, "over": {}},
        }
    )
    chart = Chart(made)
    ended = ["over" in chart.start(0.0).entered]
    while not ended[-1] and len(ended) < 6:
        if restores:
            chart = Chart.restore(made, unpacked(packed(chart.snapshot())))
        ended.append("over" in chart.send(Event("go", float(len(ended)))).entered)
    assert ended.index(True) == max(1 if items is None else items for items, _ in regions)


@pytest.mark.parametrize(("known", "end"), [(True, "was_succeeded"), (False, "was_unverified")])
def test_a_region_that_is_a_final_has_its_requires(known: bool, end: str) -> None:
    states = mission([Region(1.0, None, False)], 0.0).written()["states"]
    states["p"]["parallel"] = {"r": {"final": "succeeded", "requires": {"key": "k", "==": True}}}
    made = Mission.model_validate({
        "name": "regions", "initial": "p", "blackboard": {"k": {"type": "boolean", "initial": known}}, "states": states,
    })  # fmt: skip
    chart = Chart(made)
    assert chart.start(0.0).entered[-1] == end
