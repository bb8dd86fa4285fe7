# SPDX-License-Identifier: Apache-2.0
"""A difference as one HTML file: both missions in one chart, and what changed next to it, what matters first.

Rule: it is the review page with a list of changes; every change leads to where it is seen in the chart.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from visualize.build import picture
from visualize.diff.as_text import headline
from visualize.diff.change import Change, heading
from visualize.diff.difference import Difference
from visualize.page.as_json import Json, plain
from visualize.page.chart_data import chart_data
from visualize.page.html import SCRIPTS, document
from visualize.page.lenses import lens, lenses

__all__ = ("difference_data", "page")

ROW = re.compile(r".*?/transitions/\d+")
OPTION = re.compile(r".*/options/[^/]+")
GONE = "was:"
"""Before the pointer of a row that only the old mission has, for the new one may have another there."""


def page(given: Difference) -> bytes:
    """The file."""
    title = f"{given.new.name}: {given.versions[0]} → {given.versions[1]}"
    return document(difference_data(given), title=title, scripts=(*SCRIPTS, "changes.js"))


def difference_data(given: Difference) -> Json:
    """All that the page shows."""
    chart = _chart(given)
    rows = {row["place"] for row in chart["rows"]}
    names = {state["name"] for state in chart["states"]}
    changes = [_change(change, rows, names) for change in given.changes]
    own = lenses(given.new, picture(given.new))
    return {
        "kind": "difference",
        "chart": chart,
        "lenses": [*_lenses(given, chart, changes), *own],
        "findings": [],
        "runs": [],
        "coverage": {"rows": {}, "states": {}},
        "images": {},
        "changes": changes,
        "headline": headline(given),
        "versions": list(given.versions),
    }


def _chart(given: Difference) -> Json:
    """Both in one; a row that is gone has a place of its own, and its definition with it."""
    both = given.picture
    kept = tuple(edge for edge in both.edges if edge.mark != "-")
    gone = tuple(edge for edge in both.edges if edge.mark == "-")
    data = chart_data(both._replace(edges=kept, notes=()), given.new, given.old)
    rows = {"": given.old.transitions} | {name: state.transitions for _, name, state in given.old.walk()}
    old = chart_data(both._replace(nodes=(), edges=gone, initials=()), given.old)["rows"]
    for edge, row in zip(gone, old, strict=True):
        written = rows[edge.source][int(edge.place.rpartition("/")[2])].written()
        data["rows"].append({**row, "place": GONE + given.written_place(edge.place), "definition": plain(written)})
    return data


def _change(change: Change, rows: set[str], names: set[str]) -> Json:
    """A change with what leads to it in the chart."""
    row = ROW.match(change.place)
    place = (row[0] if change.new_place is not None else GONE + row[0]) if row else ""
    option = OPTION.match(change.new_place or "")
    return {
        **change._asdict(),
        "heading": heading(change),
        "place": change.place,
        "row": place if place in rows else "",
        "state": change.subject if change.subject in names else "",
        "option": option[0] if option else "",
    }


def _lenses(given: Difference, chart: Json, changes: Iterable[Json]) -> list[Json]:
    """Two switches: what is for a reviewer to judge, and all that is marked."""
    unsafe = [change for change in changes if change["severity"] == "safety"]
    marked = [row for row in chart["rows"] if row.get("mark")]
    states = {state["name"] for state in chart["states"] if state.get("mark")}
    options = {
        choice["place"] for state in chart["states"] for choice in state.get("choices", ()) if choice.get("mark")
    }
    ends = {name for row in marked for name in (row.get("source"), row.get("target")) if name}
    return [
        lens("safety", "What is safety-relevant?", "s", states=_ends(unsafe, chart), rows=_named(unsafe, "row"),
             options=_named(unsafe, "option")),
        lens("changed", "What changed?", "d", states=states | ends | _named(changes, "state"),
             rows={row["place"] for row in marked}, options=options),
    ]  # fmt: skip


def _named(changes: Iterable[Json], word: str) -> set[str]:
    return {change[word] for change in changes if change[word]}


def _ends(changes: list[Json], chart: Json) -> set[str]:
    """The states of changes, and those that their rows join."""
    rows = _named(changes, "row")
    joined = (row for row in chart["rows"] if row["place"] in rows)
    return _named(changes, "state") | {
        name for row in joined for name in (row.get("source"), row.get("target")) if name
    }
