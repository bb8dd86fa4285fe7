# SPDX-License-Identifier: Apache-2.0
"""What is written comes back equal, and what cannot is refused."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given

from rai_missions.engine.decision import Evidence, Question
from rai_missions.engine.step import Ask, Handover, Move, Step
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.journal import decode, difference, encode
from rai_missions.journal.json_values import from_json, to_json
from tests.rigs.journals import steps, values


def through_json(content: Any) -> Any:
    return json.loads(json.dumps(content, allow_nan=False))


@given(steps)
def test_a_step_comes_back_as_it_was(step: Step) -> None:
    back = decode(through_json(encode(step)))
    assert back == step
    assert difference(step, back) == ""


@given(values)
def test_a_value_comes_back_with_its_types(value: Any) -> None:
    back = from_json(through_json(to_json(value)), lambda ref, digest: bytes)
    assert back == value
    assert repr(back) == repr(value)


@given(steps)
def test_a_step_reads_back_from_what_it_was_written_as_and_writes_the_same_again(step: Step) -> None:
    written = through_json(encode(step))
    assert through_json(encode(decode(written))) == written


@given(steps, steps)
def test_a_difference_is_found_exactly_where_there_is_one(one: Step, other: Step) -> None:
    assert (difference(one, other) == "") == (repr(one) == repr(other))


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (float("nan"), "NaN"),
        ({"a": [b"raw"]}, "not b'raw' (bytes)"),
        ({1: "one"}, "are text, not 1; write '1'"),
        ({"a": {2, 3}}, "(set)"),
    ],
)
def test_what_cannot_come_back_is_refused(value: Any, message: str) -> None:
    with pytest.raises(UsageError) as refused:
        encode(Step(1, 0.0, Event("found", 0.0, {"it": value})))
    assert message in str(refused.value)


def test_only_the_pictures_of_a_question_are_kept() -> None:
    shown, seen = (Image(f"camera@{number}", 2, 2, "rgb8", bytes([number] * 12)) for number in (1, 2))
    question = Question(1, "assessing", "agent", "What now?", (), (Evidence("camera", shown, 0.1, True),))
    step = Step(1, 0.0, Event("anomaly", 0.0, {"seen": seen}), writes=(("camera", seen),), effects=(Ask(question),))
    kept: list[Image] = []

    def keep(image: Image) -> str:
        kept.append(image)
        return image.digest

    written = encode(step, keep)
    assert kept == [shown]
    assert written["effects"][0]["ask"]["question"]["evidence"][0]["value"]["sha256"] == shown.digest
    assert "sha256" not in written["writes"][0][1]


def test_bytes_that_were_not_kept_are_missed_only_when_they_are_wanted() -> None:
    step = Step(1, 0.0, Event("seen", 0.0, {"it": Image("camera@1", 2, 2, "rgb8", bytes(12))}))
    image = decode(encode(step)).event.data["it"]
    assert (image.ref, image.width, image.encoding) == ("camera@1", 2, "rgb8")
    with pytest.raises(UsageError, match=r"picture 'camera@1' was read without its bytes"):
        _ = image.data


STEP = Step(3, 1.5, Event("anomaly", 1.5), (Move((), ("driving",), ("assessing", "x")),), effects=(Handover("agent"),))


@pytest.mark.parametrize(
    ("got", "message"),
    [
        (STEP, ""),
        (STEP._replace(why="x"), "step 3 (anomaly, 1.5 s): why was '', now it is 'x'"),
        (
            STEP._replace(moves=(Move((), ("driving",), ("assessing", "y")),)),
            "step 3 (anomaly, 1.5 s): moves[0].entered[1] was 'x', now it is 'y'",
        ),
        (STEP._replace(effects=()), "step 3 (anomaly, 1.5 s): effects[0] was Handover(to='agent'), now it is absent"),
        (
            STEP._replace(event=Event("anomaly", 1.5, {"n": 1})),
            "step 3 (anomaly, 1.5 s): event.data.n was absent, now it is 1",
        ),
        (STEP._replace(at=2), "step 3 (anomaly, 1.5 s): at was 1.5, now it is 2"),
        (STEP._replace(writes=(("n", True),)), "step 3 (anomaly, 1.5 s): writes[0] was absent, now it is ('n', True)"),
    ],
)
def test_a_difference_is_reported_with_its_place(got: Step, message: str) -> None:
    assert difference(STEP, got) == message


LEAST = {"seq": 1, "at": 0, "event": {"name": "x"}}
PICTURE = {"$image": "x", "width": "2", "height": 2, "encoding": "png"}


@pytest.mark.parametrize(
    "written",
    [
        [], {}, {"seq": "one"}, {**LEAST, "colour": 1}, {**LEAST, "event": 3}, {**LEAST, "effects": [{"fly": {}}]},
        {**LEAST, "event": {"name": "x", "data": {"a": {"$code": "x"}}}}, {**LEAST, "guards": [["a", 1]]},
        {**LEAST, "event": {"name": "x", "data": {"a": PICTURE}}}, {**LEAST, "notes": "n"}, {**LEAST, "effects": [7]},
        {**LEAST, "seq": "one"}, {**LEAST, "at": "noon"}, {**LEAST, "why": 3}, {**LEAST, "kept": "yes"},
    ],
)  # fmt: skip
def test_what_is_no_step_is_not_read_as_one(written: Any) -> None:
    with pytest.raises((ValueError, TypeError, AttributeError)):
        decode(written)


@given(steps)
def test_a_row_of_an_earlier_version_is_compared_by_the_fields_that_it_has(step: Step) -> None:
    """Such a row has no mode; what it has is compared as ever."""
    written = encode(step)
    for name in ("mode", "holder", "verdicts", "refusal", "kept"):
        written.pop(name, None)
    early = decode(written)
    assert difference(early, step) == ""
    assert difference(early, step._replace(notes=(*step.notes, "more"))) != ""
    assert difference(step, step._replace(mode=None)) != ""


@pytest.mark.parametrize(
    ("field", "value"), [("mode", "asleep"), ("holder", "thief"), ("refusal", 1), ("kept", "yes"), ("verdicts", [{}])]
)
def test_what_no_step_can_be_is_no_step(field: str, value: object) -> None:
    with pytest.raises((ValueError, TypeError)):
        decode({**encode(STEP), field: value})


def test_a_write_that_repeats_a_value_of_its_step_counts_for_nothing() -> None:
    """As in journals of earlier versions, which have the first item of an `each` twice."""
    once = STEP._replace(writes=(("item", 1), ("n", 1), ("item", 2)))
    assert difference(once._replace(writes=(("item", 1), ("n", 1), ("item", 1), ("item", 2))), once) == ""
    assert difference(once._replace(writes=(("item", 1), ("n", 1), ("item", 1.0), ("item", 2))), once) != ""
    assert difference(once._replace(writes=(*once.writes, ("item", 1))), once) != ""
