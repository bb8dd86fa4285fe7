# SPDX-License-Identifier: Apache-2.0
"""What a model proposes is an order exactly where one of the closed forms that it was given permits it."""

from __future__ import annotations

import random
from collections.abc import Mapping
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from rai_missions.conversation.dialogue.order_forms import order_forms, proposed
from rai_missions.conversation.view import KeyView, MissionView, StatusView
from rai_missions.engine.decision import Offer, Question
from rai_missions.profile import ORDERS

FREE = {"type": "object", "properties": {"row": {"type": "integer", "minimum": 1}}, "required": ["row"],
        "additionalProperties": False}  # fmt: skip
VIEW = StatusView(
    missions=(
        MissionView(
            "patrol",
            arguments=(
                KeyView("rounds", "integer", "argument", minimum=1, maximum=9),
                KeyView("who", "string", "argument"),
            ),
        ),
        MissionView("assist"),
    ),
    questions=(
        Question(3, "blocked", "operator", "And now?", (Offer("wait"), Offer("skip", parameters=FREE))),
        Question(4, "lost", "operator", "Where to?", (Offer("dock"),)),
    ),
)
EXAMPLES: tuple[Mapping[str, Any], ...] = (
    *({"order": name} for name in ("pause", "resume", "cancel", "stop")),
    {"order": "start", "mission": "patrol", "arguments": {"rounds": 3, "who": "Ann"}},
    {"order": "start", "mission": "assist"},
    {"order": "answer", "question": 3, "option": "skip", "parameters": {"row": 2}},
    {"order": "answer", "question": 4, "option": "dock"},
)
VALUES = (
    *ORDERS, "kill", "patrol", "assist", "wait", "skip", "dock", 0, 3, 4, 9, 10, -1, 2.5, "3", None, (), [3], {}, True,
    {"row": 2}, {"row": 0}, {"row": 1, "more": 1}, {"rounds": 1}, {"rounds": 99}, {"rounds": "2"}, {"pace": 1},
)  # fmt: skip
FIELDS = ("order", "mission", "arguments", "question", "option", "parameters", "note")


@settings(max_examples=300)
@given(st.integers(0, 2**32))
def test_a_proposal_is_an_order_where_a_form_permits_it(seed: int) -> None:
    rng = random.Random(seed)
    order = dict(rng.choice(EXAMPLES))
    for _ in range(rng.choice((0, 1, 1, 2))):
        name = rng.choice(FIELDS)
        if rng.random() < 0.3:
            order.pop(name, None)
        else:
            order[name] = rng.choice(VALUES)
    forms = order_forms(VIEW, frozenset(ORDERS))
    is_permitted = any(Draft202012Validator(form).is_valid(order) for form in forms)
    assert (proposed(order, VIEW) is not None) == is_permitted, order
