# SPDX-License-Identifier: Apache-2.0
"""What a mission keeps of a result: a field, a field within one, or an item of a list; nothing where there is none."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.trees import PyTrees
from tests.rigs.charts import mission, transition

ENDS = {"transitions": [transition("succeeded", "well"), transition(["failed", "rejected"], "ill")]}
CARRIERS: Mapping[str, Any] = {
    "action": lambda result: {"action": "act", "result": result, **ENDS},
    "call": lambda result: {"call": "act", "result": result, **ENDS},
    "action of a tree": lambda result: {"tree": {"action": "act", "result": result}, **ENDS},
    "call of a tree": lambda result: {"tree": {"call": "act", "result": result}, **ENDS},
}
NAMES = st.sampled_from(("x", "y", "x.y", "0"))
VALUES = st.recursive(
    st.one_of(st.integers(0, 9), st.none()),
    lambda inner: st.one_of(st.lists(inner, max_size=2), st.dictionaries(NAMES, inner, max_size=3)),
    max_leaves=6,
)
RESULTS = st.dictionaries(NAMES, VALUES, max_size=3)
FIELDS = st.lists(st.sampled_from(("x", "y", "0", "1")), min_size=1, max_size=3).map(".".join)
KEYS = {"number": {"type": "integer"}, "fields": {"type": "object"}, "items": {"type": "list"}}
TYPES = {"number": int, "fields": dict, "items": list}


def expected(result: Mapping[str, Any], field: str) -> Any:
    """What a field of a result is; a name that has a dot itself comes first."""
    if field in result:
        return result[field]
    value: Any = dict(result)
    for word in field.split("."):
        items = dict(enumerate(value)) if isinstance(value, list) else {}
        value = value.get(word) if isinstance(value, dict) else items.get(int(word) if word in "01" else None)
    return value


@pytest.mark.parametrize("carrier", CARRIERS)
@pytest.mark.parametrize("on_py_trees", [False, True])
@given(result=RESULTS, field=FIELDS)
def test_what_is_kept_of_a_result_is_at_its_path(
    carrier: str, on_py_trees: bool, result: dict[str, Any], field: str
) -> None:
    states = {"act": CARRIERS[carrier](dict.fromkeys(KEYS, field)), "well": {}, "ill": {}}
    made = Chart(mission(states, blackboard=KEYS), PyTrees() if on_py_trees else None)
    number = made.start(0.0).effects[0].number
    if "action" in carrier:
        made.send(Event("accepted", 0.5, {}, "accepted", number))
    step = made.send(Event("succeeded", 1.0, result, "result", number))
    found = expected(result, field)
    assert made.active == {"well"}
    assert dict(step.writes) == {key: found for key, kind in TYPES.items() if isinstance(found, kind)}
