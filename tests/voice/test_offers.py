# SPDX-License-Identifier: Apache-2.0
"""Which offer of a turn is transcribed next: laws over any order of offers, pauses and replies."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.voice.offers import OfferQueue, TurnOffer


@given(st.lists(st.sampled_from(["offered", "void", "replied"]), max_size=40))
def test_each_offer_is_transcribed_once_and_in_order_but_for_those_void_before(events: list[str]) -> None:
    queue, taken, left_out, busy = OfferQueue(), list[TurnOffer](), set[TurnOffer](), 0
    offers = 0
    for event in [*events, *["replied"] * 41]:
        if event == "offered":
            offers += 1
            queue.add(TurnOffer(1, offers), bytes([offers]))
        elif event == "void":
            offer = TurnOffer(1, offers)
            if queue.void(offer):
                assert offer not in taken
                left_out.add(offer)
        elif busy:
            queue.done()
            busy -= 1
        if (found := queue.take()) is not None:
            assert found[1] == bytes([found[0].offer]), "each with its sound"
            taken.append(found[0])
            busy += 1
        assert busy <= 1, "one at a time"
    assert taken == [each for number in range(1, offers + 1) if (each := TurnOffer(1, number)) not in left_out]


@given(st.lists(st.sampled_from(["offered", "void", "replied", "lost"]), max_size=40))
def test_what_is_lost_is_transcribed_once_more_ahead_of_the_others_unless_it_is_void(events: list[str]) -> None:
    queue, offers, now, again, void = OfferQueue(), 0, 0, set[int](), set[int]()
    for event in events:
        if event == "offered":
            offers += 1
            queue.add(TurnOffer(1, offers), bytes([offers]))
        elif event == "void":
            queue.void(TurnOffer(1, offers))
            void.add(offers)
        elif now and event == "lost" and now not in again | void:
            assert queue.again()
            again.add(now)
            assert queue.take() == (TurnOffer(1, now), bytes([now]))
        elif now:
            assert event == "replied" or not queue.again()
            queue.done()
            now = 0
        if (found := queue.take()) is not None:
            now = found[0].offer
