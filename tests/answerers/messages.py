# SPDX-License-Identifier: Apache-2.0
"""What models may state, for hypothesis: texts, JSON and calls, near to what is asked for and far from it."""

from __future__ import annotations

import json

from hypothesis import strategies as st

from rai_missions.testing import QUESTION, call

OFFERED = [offer.name for offer in QUESTION.options]
ANY_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=9), inner, max_size=3),
    max_leaves=8,
)
ANY_NAME = st.sampled_from([*OFFERED, "fly", "succeeded", "look"]) | st.text(max_size=20)
ANY_ARGUMENTS = st.dictionaries(st.text(max_size=9), ANY_JSON, max_size=3)
ANY_CALL = st.builds(lambda name, arguments: {**call(name), "args": arguments}, ANY_NAME, ANY_ARGUMENTS)
OBJECTS = st.dictionaries(st.sampled_from(["option", "parameters", "why", "x"]), ANY_JSON | ANY_NAME)
TEXTS = (
    st.text()
    | ANY_NAME
    | OBJECTS.map(json.dumps)
    | st.tuples(st.text(), OBJECTS.map(json.dumps), st.text()).map("".join)
)
