# SPDX-License-Identifier: Apache-2.0
"""A generated chart does what XState makes of the same chart.

Needs node and the npm package `xstate`; `make oracles` installs it next to this file.
Where XState 5 leaves the recommendation, the charts that are drawn keep away:
a transition is compared only where the least common ancestor of its ends is no parallel state, for XState then leaves
the one region and not the whole; a transition into a history of a state around it, for XState then enters states that
it has not left; and charts with regions have no transition without a target above them, for XState asks the states
above only when no region has a transition of its own.
"""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings

from tests.oracles.appendix_d import Endless, many
from tests.oracles.documents import Taste, charts, lineage, scripts, without_transitions
from tests.oracles.ours import Trace, of_appendix_d, of_ours

Json = dict[str, Any]
Runs = Callable[[Json, list[tuple[Any, ...]]], list[Trace]]
HERE = Path(__file__).parent
NODE = shutil.which("node")

pytestmark = [
    pytest.mark.skipif(NODE is None, reason="node is not installed"),
    pytest.mark.skipif(not (HERE / "node_modules" / "xstate").is_dir(), reason="xstate is not installed: make oracles"),
]


@pytest.fixture(scope="module")
def of_xstate() -> Iterator[Runs]:
    """One node process for all charts."""
    command = [str(NODE), "xstate.mjs"]
    with subprocess.Popen(command, cwd=HERE, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as node:
        assert node.stdin is not None and node.stdout is not None
        reported, received = node.stdin, node.stdout

        def runs(document: Json, script: list[tuple[Any, ...]]) -> list[Trace]:
            reported.write(json.dumps({"document": document, "script": [name for _, name, _ in script]}) + "\n")
            reported.flush()
            answer = json.loads(received.readline())
            assert isinstance(answer, list), answer
            return [Trace(frozenset(active), tuple(logs), ended) for active, logs, ended in answer]

        yield runs
        node.stdin.close()


def tamed(document: Json) -> Json:
    """The chart without the transitions that XState takes in its own way."""
    states, above = lineage(document)
    regions = any("parallel" in state for state in states.values())

    def unwanted(source: str, transition: Json) -> bool:
        if "to" not in transition:
            return regions
        if any("history" in states[target] and above[target][0] in above[source] for target in many(transition["to"])):
            return True
        shared = [up for up in above[source] if all(up in above[target] for target in many(transition["to"]))]
        return bool(shared) and "parallel" in states[shared[0]] and not transition.get("internal")

    return without_transitions(document, unwanted)


@settings(suppress_health_check=list(HealthCheck))
@given(charts(Taste(several=False)).map(tamed), scripts())
def test_a_chart_does_what_xstate_does(of_xstate: Runs, document: Json, script: list[tuple[Any, ...]]) -> None:
    try:
        of_appendix_d(document, script)
    except Endless:
        assume(False)
    assert of_ours(document, script) == of_xstate(document, script)
