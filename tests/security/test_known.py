# SPDX-License-Identifier: Apache-2.0
"""What was known for a secret at a run's begin is in none of its data, at whatever place, and nothing else changes."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.redaction import HIDDEN, Redaction

SECRETS = ("hidden-1", "a rather longer one")
PIECES = st.sampled_from(["", "x", "hidden-", "1", "hidden-1", "a rather longer one", "hid"])
TEXTS = st.lists(PIECES, max_size=4).map("".join)
VALUES = st.recursive(
    TEXTS | st.integers() | st.booleans() | st.none(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXTS, inner, max_size=4) | st.tuples(inner, inner),
    max_leaves=12,
)


def without(value: Any) -> Any:
    """By definition: each text, and each name, without the secrets."""
    if isinstance(value, str):
        for secret in sorted(SECRETS, key=len, reverse=True):
            value = value.replace(secret, HIDDEN)
        return value
    if isinstance(value, dict):
        return {without(name): without(item) for name, item in value.items()}
    return type(value)(map(without, value)) if isinstance(value, list | tuple) else value


@given(VALUES)
def test_every_text_is_without_the_secrets_and_all_else_is_as_it_was(value: Any) -> None:
    with pytest.MonkeyPatch.context() as patch:
        for name in ("FIRST_TOKEN", "SECOND_TOKEN"):
            patch.setenv(name, SECRETS[name == "SECOND_TOKEN"])
        cleaned = Redaction().known(value)
    assert cleaned == without(value)
    assert type(cleaned) is type(value) and not any(secret in json.dumps(cleaned) for secret in SECRETS)
