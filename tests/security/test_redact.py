# SPDX-License-Identifier: Apache-2.0
"""No key, by shape, by variable or by name, is left in what goes out; other words stay as they are."""

from __future__ import annotations

import gc
import json
import logging
import os
import re
import string
import sys
from types import FrameType

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.redaction import Redaction, cut, logger

letters = st.text("abcdefghijklmnopqrstuvwxyzABCDEFXYZ0123456789", min_size=12, max_size=40)
KEYS = st.one_of(
    letters.map("sk-".__add__),
    letters.map("sk-ant-api03-".__add__),
    letters.map("gsk_".__add__),
    letters.map("hf_".__add__),
    letters.map("ghp_".__add__),
    letters.map("AIza".__add__),
)


@given(KEYS, st.sampled_from(["{}", "key {}.", '"{}"', "({})", "https://x/?key={}&a=1", "{}, {}"]))
def test_a_key_by_its_shape_is_hidden_wherever_it_is(key: str, frame: str) -> None:
    reported = Redaction().text(frame.replace("{}", key))
    assert key not in reported
    assert "[hidden]" in reported


@given(letters)
def test_a_known_secret_is_hidden_in_every_part_of_a_value(secret: str) -> None:
    value = {"a": [secret, {"b" + secret: f"x{secret}y"}], "n": 1, "t": True, "none": None}
    reported = Redaction([secret]).json(value)
    assert secret not in json.dumps(reported)
    assert (reported["n"], reported["t"], reported["none"]) == (1, True, None)


def variables_read(value: object) -> int:
    """How many variables of the environment are read while a value is made one without secrets."""
    found, read = 0, type(os.environ).__getitem__.__code__

    def count(frame: FrameType, event: str, _: object) -> None:
        nonlocal found
        found += event == "call" and frame.f_code is read

    redaction = Redaction(["geheimes-wort"])
    sys.setprofile(count)
    try:
        redaction.json(value)
    finally:
        sys.setprofile(None)
    return found


def test_a_value_of_many_texts_has_the_variables_read_once() -> None:
    assert variables_read({f"name {each}": ["text"] * 3 for each in range(100)}) == variables_read("text") > 0


@pytest.mark.parametrize("header", ["Authorization: Bearer ", "basic ", "api_key=", "API-Key: "])
def test_what_is_behind_the_word_for_a_key_is_hidden(header: str) -> None:
    assert Redaction().text(f"{header}abc.def-123") == f"{header}[hidden]"


@pytest.mark.parametrize("token", ["dXNlcjpwYXNzd29yZA==", "QWxhZGRpbjpvcGVu", "abcdef123"])
def test_a_header_s_token_is_known_by_what_no_word_has(token: str) -> None:
    assert Redaction().text(f"Basic {token}") == "Basic [hidden]"


def test_a_variables_value_is_hidden_from_the_moment_it_is_set(monkeypatch: pytest.MonkeyPatch) -> None:
    redaction = Redaction()
    assert redaction.text("open sesame") == "open sesame"
    monkeypatch.setenv("CAVE_API_KEY", "open sesame")
    assert redaction.text("open sesame") == "[hidden]"


@pytest.mark.parametrize("name", ["HF_TOKEN", "PGPASSWORD", "BROKER_PASSWORD", "AWS_SECRET_ACCESS_KEY", "my_secret"])
def test_a_secret_is_known_by_how_its_variable_is_called(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(name, "open sesame")
    assert Redaction().text("they wrote: open sesame!") == "they wrote: [hidden]!"


def test_a_password_in_an_address_is_hidden_and_the_address_stays() -> None:
    reported = Redaction().text("no way to http://robot:pa55-word@proxy:3128/ from http://127.0.0.1:80/a:b@c")
    assert reported == "no way to http://[hidden]@proxy:3128/ from http://127.0.0.1:80/a:b@c"


@pytest.mark.parametrize(
    "text",
    [
        "the task-oriented tractor took the risk-free alley",
        "replan: obstacle.height_m 0.21 is not below 0.2",
        "a short key, and no token at all; bearer of news",
        "basic navigation; Basic Planner; the bearer, bearer operator",
        "2026-11-21T11:00:00Z /tractor1/current_state",
    ],
)
def test_words_that_are_no_keys_stay(text: str) -> None:
    assert Redaction(["", "abc"]).text(text) == text


def test_a_run_s_keys_are_secrets_while_it_lives_and_the_next_run_does_not_share_them() -> None:
    first = Redaction(["open sesame"])
    assert Redaction().text("open sesame") == "[hidden]", "whatever prints it may know no model"
    del first
    gc.collect()
    second = Redaction()
    assert second.text("open sesame") == "open sesame" and second.known(["open sesame"]) == ["open sesame"]


def test_no_run_replaces_what_makes_the_records_of_the_log() -> None:
    before = logging.getLogRecordFactory()
    logger("rai_missions.tried")
    assert logging.getLogRecordFactory() is before


BACKSLASH = "\\"


MARKED = st.text("abXY12_*-.+/\\[]`~#é \"'", min_size=8, max_size=60).map(lambda middle: f"k{middle}k")


@given(MARKED, st.data())
def test_a_secret_is_hidden_however_many_of_its_marks_are_escaped_as_in_markdown(
    secret: str, data: st.DataObject
) -> None:
    marks = [place for place, letter in enumerate(secret) if letter in string.punctuation]
    chosen = set(data.draw(st.lists(st.sampled_from(marks)))) if marks else set()
    written = "".join(f"{(place in chosen) * BACKSLASH}{letter}" for place, letter in enumerate(secret))
    read = re.sub(r"\\([!-/:-@\[-`{-~])", r"\1", secret)
    redaction = Redaction([secret])
    for text in (written, read):
        assert redaction.text(f"it is {text} here") == "it is [hidden] here"
        assert redaction.known(f"it is {text} here") == "it is [hidden] here"
        assert cut(f"it is {text} here", 12) == "it is [hidde"


def test_many_backslashes_are_looked_at_once() -> None:
    text = BACKSLASH * 300_000
    assert Redaction([".secret_1"]).text(f"{text}x") == f"{text}x"
    assert Redaction([".secret_1"]).text(rf"{text}.secret\_1").strip(BACKSLASH) == "[hidden]"
