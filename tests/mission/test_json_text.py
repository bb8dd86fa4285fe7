# SPDX-License-Identifier: Apache-2.0
"""Any bytes are a JSON value or faults with their places."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.errors import DefinitionError, UsageError
from rai_missions.mission.json_reader import MAX_BYTES, MAX_DEPTH, file_bytes, parse_json, too_deep

JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(codec="utf-8")),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(st.characters(codec="utf-8")), inner),
)


def refusals(raw: bytes) -> list[str]:
    with pytest.raises(DefinitionError) as refused:
        parse_json(raw, "m.json")
    return str(refused.value).splitlines()


@given(JSON)
def test_what_json_can_state_is_read_as_it_was_written(value: object) -> None:
    assert parse_json(json.dumps(value).encode()) == value
    assert parse_json(json.dumps(value, ensure_ascii=False).encode("utf-8-sig")) == value


@given(st.binary() | st.text(alphabet='{}[]",:\\u0189dDeE+-.truefalsn \n', max_size=60).map(str.encode))
def test_any_bytes_are_a_value_or_a_fault(raw: bytes) -> None:
    try:
        json.dumps(parse_json(raw), allow_nan=False).encode()
    except DefinitionError as error:
        str(error).encode()


@given(JSON, st.data())
def test_a_text_cut_short_is_never_read_as_a_whole_object(value: object, data: st.DataObject) -> None:
    raw = json.dumps({"value": value}).encode()
    cut = raw[: data.draw(st.integers(0, len(raw) - 1))]
    assert refusals(cut)


@pytest.mark.parametrize(
    ("raw", "sentence"),
    [
        (b" \n", "/: the file is empty; write a JSON object"),
        (
            b'{"a": 1,\n "b": [2',
            "/: line 2, column 9: the text ends in the middle (expecting ',' delimiter); is the file cut short?",
        ),
        (
            b'{"a": "b',
            "/: line 1, column 7: the text ends in the middle (unterminated string starting at); "
            "is the file cut short?",
        ),
        (b'{"a" 1}', "/: line 1, column 6: not JSON: expecting ':' delimiter, at '1}'"),
        (
            b'{"a": True}',
            "/: line 1, column 7: not JSON: expecting value, at 'True}'; write true or false, in lower case",
        ),
        (b'{"a": None}', "/: line 1, column 7: not JSON: expecting value, at 'None}'; write null"),
        (
            b'{"a": "b\tc"}',
            "/: line 1, column 9: not JSON: invalid control character, at '\\tc\"}'; inside a text a tabulator is \\t",
        ),
        (
            b'{"a": "b,\n"c": 1}',
            "/: line 1, column 10: not JSON: invalid control character, at ''; "
            "end the text with a quote on its line, or write \\n for a new line",
        ),
        (
            b"format: 1\nname: m\n",
            "/: line 1, column 1: not JSON: expecting value, at 'format: 1'; "
            'JSON has braces around it, and its words in quotes: {"format": 1}',
        ),
        (b"{} {}", "/: line 1, column 4: there is more after the end of the JSON value; keep one value a file"),
        (b'{"a":\n"\xff"}', "/: line 2, byte 7: not UTF-8; save the file in that encoding"),
        ('{"a": 1}'.encode("utf-16"), "/: line 1, byte 0: not UTF-8; save the file in that encoding"),
        (
            b"[" * 200_000,
            f"/: line 1, column {MAX_DEPTH + 1}: more than {MAX_DEPTH} objects and lists inside each other; nest less",
        ),
        (b'{"a/b": [NaN]}', "/a~1b/0: 'NaN' is not a number that JSON has; give a finite one"),
        (b'{"a": -Infinity}', "/a: '-Infinity' is not a number that JSON has; give a finite one"),
        (b'{"a": 1e999}', "/a: '1e999' is larger than any number here; give a smaller one"),
        (b'{"a": 9223372036854775808}', "/a: '9223372036854775808' does not fit in 64 bits; give a smaller number"),
        (b'{"a": "\\ud800"}', "/a: '\\ud800' holds half a character (a lone surrogate); write it whole"),
        (b'{"\\udfff": 1}', "/\\udfff: the word '\\udfff' holds half a character; write it whole"),
        (b'{"x": {"a": 1, "a": 2}}', "/x/a: 'a' appears more than once in this object; keep one"),
    ],
)
def test_what_is_wrong_is_reported_with_its_place(raw: bytes, sentence: str) -> None:
    assert refusals(raw) == [f"m.json: {sentence}"]


@pytest.mark.parametrize(
    ("raw", "remedy"),
    [
        (b'{"a": 1,\n // b\n "c": 2}', "at '// b'; JSON has no comments: write what is for people as \"about\""),
        (b'{"a": 1 # b\n}', "at '# b'; JSON has no comments: write what is for people as \"about\""),
        (b'{"a": 1,\n}', "; take away the comma before the end"),
        (b"[1, 2,]", "; take away the comma before the end"),
        (b"{'a': 1}", "; texts and words are in double quotes"),
    ],
)
def test_what_other_formats_allow_is_refused_with_what_is_right_here(raw: bytes, remedy: str) -> None:
    (sentence,) = refusals(raw)
    assert "not JSON" in sentence
    assert sentence.endswith(remedy)


def test_brackets_in_text_do_not_nest() -> None:
    text = '"[[[{{{' + "[" * 500 + '\\"["'
    assert parse_json(text.encode()) == json.loads(text)


def test_a_number_of_many_digits_is_a_fault_too() -> None:
    assert "does not fit in 64 bits" in refusals(b'{"a": ' + b"9" * 100_000 + b"}")[0]


def test_as_deep_as_the_bound_is_read() -> None:
    assert parse_json(b"[" * MAX_DEPTH + b"]" * MAX_DEPTH) is not None


def first_too_deep(text: str) -> int | None:
    """Where text first nests deeper than the bound, letter by letter."""
    depth, is_text, is_escaped = 0, False, False
    for at, letter in enumerate(text):
        if is_text:
            is_text = is_escaped or letter != '"'
            is_escaped = letter == "\\" and not is_escaped
        else:
            is_text = letter == '"'
            depth += (letter in "[{") - (letter in "]}")
            if depth > MAX_DEPTH:
                return at
    return None


@pytest.mark.parametrize("times", [MAX_DEPTH // 2, MAX_DEPTH // 2 + 1, MAX_DEPTH, MAX_DEPTH + 1])
@pytest.mark.parametrize(
    ("opening", "closing"),
    [("[", "]"), ("{", "}"), ("[{", "}]"), ("{}[", "]"), ("[", "}"), ('["]"', '"["]'), ('["\\"]\\""', '"\\"[\\""]')],
)
@pytest.mark.parametrize("middle", ["", "{}", "{[]}", "[", "]", '"', '"]"'])
def test_the_depth_is_that_of_the_brackets_outside_texts(opening: str, closing: str, times: int, middle: str) -> None:
    text = opening * times + middle + closing * times
    assert too_deep(text) == first_too_deep(text)


def test_every_oddity_is_reported_at_once() -> None:
    assert len(refusals(b'{"a": NaN, "a": Infinity, "b": ["\\udc00", 1e400]}')) == 4


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    large = tmp_path / "large.json"
    with large.open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(DefinitionError, match="larger than 16 MiB"):
        file_bytes(large)


@pytest.mark.parametrize(
    ("name", "sentence"),
    [("no.json", "there is no file"), (".", "is a folder; name"), ("x" * 5000, "there is no file")],
)
def test_a_file_that_is_not_there_is_for_the_caller_to_mend(tmp_path: Path, name: str, sentence: str) -> None:
    with pytest.raises(UsageError, match=sentence):
        file_bytes(tmp_path / name)


def test_a_pipe_is_no_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.json")
    with pytest.raises(UsageError, match="is a "):
        file_bytes(tmp_path / "pipe.json")
