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
