# SPDX-License-Identifier: Apache-2.0
"""A generated chart does what python-statemachine makes of the same chart, read as SCXML.

Where python-statemachine 3.2 leaves the recommendation, the charts that are drawn keep away: it takes the states of
regions level by level, not in document order (so charts with regions have nothing that depends on that order, and what
an event did is compared as a set), it does what a transition into a history does twice, it takes no list for the first
`initial`, and does not exit the last final.
"""

from __future__ import annotations

import contextlib
import io
import warnings
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings

from tests.oracles.appendix_d import Endless, many
from tests.oracles.documents import Taste, charts, lineage, scripts, without_transitions
from tests.oracles.ours import Trace, of_appendix_d, of_ours
from tests.oracles.scxml_text import scxml_text

processor = pytest.importorskip("statemachine.io.scxml.processor", reason="python-statemachine is not installed")

Json = dict[str, Any]
ONE_BY_ONE = Taste(parallel=False, history=False, several=False, end=False)
SIDE_BY_SIDE = Taste(raising=False, guards=False, eventless=False, finals=False, several=False, end=False)


def at_home(document: Json) -> Json:
    """The chart without transitions that lead out of a region: which of two is taken goes by the regions' order."""
    states, above = lineage(document)

    def unwanted(source: str, transition: Json) -> bool:
        regions = [name for name in (source, *above[source]) if above[name] and "parallel" in states[above[name][0]]]
        leaves = "to" in transition and source in regions and not transition.get("internal")
        return leaves or any(region not in above[target] for target in many(transition.get("to")) for region in regions)

    return without_transitions(document, unwanted)


def unordered(reported: Trace) -> tuple[frozenset[str], list[str], str]:
    return reported.active, sorted(set(reported.logs)), reported.ended


def of_python_statemachine(document: Json, script: list[tuple[Any, ...]]) -> list[Trace]:
    ends = {name: state["final"] for name, state in document["states"].items() if "final" in state}
    reported = io.StringIO()

    def on_message() -> Trace:
        logs = tuple(line.strip("'") for line in reported.getvalue().splitlines())
        reported.seek(0)
        reported.truncate()
        active = frozenset(state.id for state in machine.configuration)
        return Trace(active, logs, next((end for name, end in ends.items() if name in active), ""))

    with contextlib.redirect_stdout(reported), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        reader = processor.SCXMLProcessor()
        reader.parse_scxml("generated", scxml_text(document))
        machine = reader.start()
        trace = [on_message()]
        for _, name, _ in script:
            if not trace[-1].ended:
                machine.send(name)
            trace.append(on_message() if not trace[-1].ended else trace[-1]._replace(logs=()))
    return trace


def expected(document: Json, script: list[tuple[Any, ...]]) -> list[Trace]:
    try:
        return of_appendix_d(document, script)
    except Endless:
        assume(False)
        raise


lenient = settings(suppress_health_check=list(HealthCheck))


@lenient
@given(charts(ONE_BY_ONE), scripts())
def test_a_chart_does_what_python_statemachine_does(document: Json, script: list[tuple[Any, ...]]) -> None:
    expected(document, script)
    assert of_ours(document, script) == of_python_statemachine(document, script)


@lenient
@given(charts(SIDE_BY_SIDE).map(at_home), scripts())
def test_regions_do_what_those_of_python_statemachine_do(document: Json, script: list[tuple[Any, ...]]) -> None:
    expected(document, script)
    theirs = of_python_statemachine(document, script)
    assert list(map(unordered, of_ours(document, script))) == list(map(unordered, theirs))
