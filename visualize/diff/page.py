# SPDX-License-Identifier: Apache-2.0
"""A difference as one HTML file: both missions in one chart, and what changed next to it, what matters first.

Rule: it is the review page with a list of changes; every change leads to where it is seen in the chart.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from rai_missions.plain_data import plain
from visualize.build import picture
from visualize.diff.change import Change, heading
from visualize.diff.difference import Difference
from visualize.page.as_json import Json
from visualize.page.chart_data import chart_data
from visualize.page.html import document
from visualize.page.lenses import lens, lenses

__all__ = ("difference_data", "page")

TRANSITION = re.compile(r".*?/transitions/\d+")
OPTION = re.compile(r".*/options/[^/]+")
GONE = "was:"
"""Before the pointer of a transition that only the old mission has, for the new one may have another there."""


def page(given: Difference) -> bytes:
    """The file."""
    title = f"{given.new.name}: {given.versions[0]} → {given.versions[1]}"
    return document(difference_data(given), title=title)


def difference_data(given: Difference) -> Json:
    """All that the page shows."""
    chart = _chart(given)
    transitions = {transition["place"] for transition in chart["transitions"]}
    names = {state["name"] for state in chart["states"]}
    changes = [_change(change, transitions, names) for change in given.changes]
    own = lenses(given.new, picture(given.new))
    return {
        "chart": chart,
        "lenses": [*_lenses(chart, changes), *own],
        "findings": [],
        "runs": [],
        "coverage": {"transitions": {}, "states": {}},
        "images": {},
        "changes": changes,
        "headline": given.headline,
    }


def _chart(given: Difference) -> Json:
    """Both in one; a transition that is gone has a place of its own, and its definition with it."""
    both = given.picture
    kept = tuple(edge for edge in both.edges if edge.mark != "-")
    gone = tuple(edge for edge in both.edges if edge.mark == "-")
    data = chart_data(replace(both, edges=kept, notes=()), given.new, given.old)
    transitions = {"": given.old.transitions} | {name: state.transitions for _, name, state in given.old.walk()}
    old = chart_data(replace(both, nodes=(), edges=gone, initials=()), given.old)["transitions"]
    for edge, transition in zip(gone, old, strict=True):
        written = transitions[edge.source][int(edge.place.rpartition("/")[2])].written()
        data["transitions"].append(
            {**transition, "place": GONE + given.originals.place(edge.place), "definition": plain(written)}
        )
    return data


def _change(change: Change, transitions: set[str], names: set[str]) -> Json:
    """A change with what leads to it in the chart."""
    transition = TRANSITION.match(change.place)
    place = (transition[0] if change.new_place is not None else GONE + transition[0]) if transition else ""
    option = OPTION.match(change.new_place or "")
    return {
        **change._asdict(),
        "heading": heading(change),
        "place": change.place,
        "transition": place if place in transitions else "",
        "state": change.subject if change.subject in names else "",
        "option": option[0] if option else "",
    }


def _lenses(chart: Json, changes: Iterable[Json]) -> list[Json]:
    """Two switches: what is for a reviewer to judge, and all that is marked."""
    unsafe = [change for change in changes if change["severity"] == "safety"]
    marked = [transition for transition in chart["transitions"] if transition.get("mark")]
    states = {state["name"] for state in chart["states"] if state.get("mark")} | _joined(marked)
    options = {
        choice["place"] for state in chart["states"] for choice in state.get("choices", ()) if choice.get("mark")
    }
    return [
        lens(
            "safety",
            "What is safety-relevant?",
            "s",
            label="Safety",
            states=_ends(unsafe, chart),
            focus=_first(unsafe, _ends(unsafe, chart)),
            transitions=_named(unsafe, "transition"),
            options=_named(unsafe, "option"),
        ),
        lens(
            "changed",
            "What changed?",
            "d",
            label="Changes",
            states=states | _named(changes, "state"),
            focus=_first(changes, states),
            transitions={transition["place"] for transition in marked},
            options=options,
        ),
    ]


def _first(changes: Iterable[Json], more: Iterable[str]) -> list[str]:
    """The states of changes in their order, what matters most first, and then what else is shown."""
    return list(dict.fromkeys([*(change["state"] for change in changes if change["state"]), *sorted(more)]))


def _named(changes: Iterable[Json], word: str) -> set[str]:
    return {change[word] for change in changes if change[word]}


def _ends(changes: list[Json], chart: Json) -> set[str]:
    """The states of changes, and those that their transitions join."""
    transitions = _named(changes, "transition")
    theirs = (transition for transition in chart["transitions"] if transition["place"] in transitions)
    return _named(changes, "state") | _joined(theirs)


def _joined(transitions: Iterable[Json]) -> set[str]:
    """The states that transitions lead from and to."""
    return {name for each in transitions for name in (each.get("source"), each.get("target")) if name}
