# SPDX-License-Identifier: Apache-2.0
"""Long messages in parts: any interleaving gives them again, and what is lost is reported, within bounds."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.hri.assembly import Assembly, ReceivedMessage
from rai_missions.connectors.hri.message import Audio, HRIMessage
from rai_missions.connectors.hri.parts import parts_of
from rai_missions.errors import UsageError
from rai_missions.image import Image
from tests.connectors.hri.test_message import messages

wholes = messages.map(lambda each: replace(each, seq_no=0, seq_end=True))


@given(st.lists(wholes, min_size=1, max_size=4), st.randoms(use_true_random=False), st.integers(1, 9))
def test_parts_in_any_interleaving_with_repeats_give_the_messages_again(
    sent: list[HRIMessage], random: object, most_text: int
) -> None:
    named = [replace(each, communication_id=f"{number}") for number, each in enumerate(sent)]
    cut = [parts_of(each, most_text=most_text, most_bytes=12) for each in named]
    mixed = [part for parts in cut for part in parts if len(parts) > 1 for _ in range(random.randint(1, 2))]  # type: ignore[attr-defined]
    mixed += [parts[0] for parts in cut if len(parts) == 1]
    random.shuffle(mixed)  # type: ignore[attr-defined]
    assembly = Assembly(lone_s=30.0)
    got = [found for part in mixed for found in assembly.add(part, 0.0)]
    whole = [found.message for found in got if not found.why]
    assert sorted(whole, key=repr) == sorted(named, key=repr), "each message once, as it was sent"
    assert all(found.duplicated for found in got if found.why), "a part that came again is all there is to report"
    assert assembly.due is None and assembly.expire(1e9) == (), "nothing is kept"


@given(wholes, st.data())
def test_lost_parts_are_named_and_the_others_reported(message: HRIMessage, data: st.DataObject) -> None:
    parts = parts_of(message, "id", most_text=3, most_bytes=12)
    lost = data.draw(st.sets(st.sampled_from(parts), min_size=1) if len(parts) > 1 else st.just(set()))
    kept = [part for part in parts if part not in lost]
    assembly = Assembly(within_s=2.0, lone_s=2.0)
    got = [found for part in kept for found in assembly.add(part, 0.0)] + list(assembly.expire(2.0))
    if len(parts) > 1 and kept:
        (found,) = got
        assert found.message.text == "".join(part.text for part in kept)
        known = [part.seq_no for part in lost if part.seq_no < kept[-1].seq_no]
        assert sorted(known) == list(found.missing)
        assert found.message.seq_end == (parts[-1] in kept)
        assert found.why or len(kept) == 1


def part(number: int, text: str = "x", end: bool = False, name: str = "", ident: str = "id") -> HRIMessage:
    return HRIMessage(text, (), (), "human", name, ident, number, end)


def whys(found: tuple[ReceivedMessage, ...]) -> list[str]:
    return [each.why for each in found]


def test_a_lone_first_part_is_the_message_of_a_program_that_marks_no_end() -> None:
    assembly = Assembly()
    assert assembly.add(part(0, "stop"), 1.0) == ()
    assert assembly.due == 1.3 and assembly.expire(1.2) == ()
    assert assembly.expire(1.3) == (ReceivedMessage(part(0, "stop")),)


def test_a_message_without_an_id_is_whole() -> None:
    assert Assembly().add(part(0, "go", ident=""), 0.0) == (ReceivedMessage(part(0, "go", True, ident="")),)
    (found,) = Assembly().add(part(3, "go", ident=""), 0.0)
    assert found.why == "part 3 has no communication_id, by which the others are known"


def test_a_message_that_never_ends_is_given_up_with_what_there_is() -> None:
    assembly = Assembly(within_s=5.0)
    for number in (0, 1, 4):
        assembly.add(part(number, str(number)), number * 1.0)
    assert assembly.due == 9.0
    (found,) = assembly.expire(9.0)
    assert (found.message.text, found.missing) == ("014", (2, 3))
    assert found.why == "parts 2, 3 did not come within 5 s"
    for number in (5, 6):
        assembly.add(part(number), 10.0)
    assert whys(assembly.expire(60.0)) == ["parts 0, 1, 2, 3, 4 did not come within 5 s"]
    assembly.add(part(0, ident="b"), 0.0), assembly.add(part(1, ident="b"), 0.0)
    assert whys(assembly.expire(5.0)) == ["the last part did not come within 5 s"]


def test_a_message_that_drips_is_given_up_after_ten_times_as_long() -> None:
    assembly = Assembly(within_s=1.0)
    for number in range(20):
        assembly.add(part(number), number * 0.9)
        if assembly.expire(number * 0.9):
            break
    assert number * 0.9 == pytest.approx(10.8)


def test_parts_that_contradict_each_other_are_reported_and_the_first_counts() -> None:
    assembly = Assembly()
    assembly.add(part(0, "a"), 0.0)
    assert whys(assembly.add(part(0, "b"), 0.0)) == ["part 0 came twice, with different contents; the first one counts"]
    assembly.add(part(2, "c", end=True), 0.0)
    assert whys(assembly.add(part(3), 0.0)) == ["part 3 came, and part 2 is marked as the last one"]
    (whole,) = assembly.add(part(1, "b"), 0.0)
    assert (whole.message.text, whole.reordered, whole.why) == ("abc", 1, "")
    late = assembly.add(part(1, "b"), 0.0)
    assert whys(late) == ["part 1 of a message that has ended came again"]
    other = Assembly()
    other.add(part(5), 0.0)
    assert whys(other.add(part(1, end=True), 0.0)) == ["part 1 is marked as the last one, and part 5 is here"]


def test_what_is_held_is_bounded_and_what_is_given_up_reported() -> None:
    assembly = Assembly(most_open=2, most_held=100)
    for ident in ("a", "b"):
        assembly.add(part(0, ident=ident), 0.0), assembly.add(part(1, ident=ident), 0.0)
    assert whys(assembly.add(part(0, ident="c"), 0.0)) == ["more than 2 messages are incomplete"]
    (found,) = assembly.add(part(1, "x" * 99, ident="c"), 0.0)
    assert (found.message.communication_id, found.why) == ("b", "incomplete messages are more than 100 bytes")
    assert whys(assembly.add(part(1000), 0.0)) == ["part 1000: a message has 1000 parts at the most"]


def test_a_flood_pushes_no_lone_first_part_out_unread() -> None:
    assembly = Assembly(most_open=2)
    assembly.add(part(0, "stop", ident="a"), 0.0), assembly.add(part(0, ident="b"), 0.0)
    (found,) = assembly.add(part(0, ident="c"), 0.0)
    assert (found.message.text, found.why) == ("stop", ""), "it may be the whole message, as at its time"


def test_a_message_that_grows_too_large_is_given_up() -> None:
    assembly = Assembly()
    assembly.add(part(0, "x" * 60_000), 0.0)
    found = assembly.add(part(1, "y" * 60_000), 0.0)
    assert whys(found) == ["its text has more than 100000 characters"] * 2
    assert [each.message.text for each in found] == ["x" * 60_000, "y" * 60_000], "nothing of it is lost"
    picture = Image("p", 3000, 3000, "rgb8", b"")
    assembly.add(replace(part(0, ident="p"), images=(picture,)), 0.0)
    assert "pictures and sound are more" in whys(assembly.add(replace(part(1, ident="p"), images=(picture,)), 0.0))[0]
    sound = (Audio(b"", 8000),) * 40
    assembly.add(replace(part(0, ident="s"), audios=sound), 0.0)
    assert "more than 64 pictures or" in whys(assembly.add(replace(part(1, ident="s"), audios=sound), 0.0))[0]


def test_a_part_is_not_divided_again() -> None:
    with pytest.raises(UsageError, match="part 1 of a message cannot be divided again; send it as it is"):
        parts_of(part(1))
    with pytest.raises(UsageError, match="a message in 2 parts needs a communication_id"):
        parts_of(HRIMessage("abcdef"), most_text=3)
    assert parts_of(HRIMessage("abc")) == (HRIMessage("abc"),)
    assert parts_of(HRIMessage()) == (HRIMessage(),)
