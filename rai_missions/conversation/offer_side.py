# SPDX-License-Identifier: Apache-2.0
"""Offers: what a sentence that no rule reads may have meant is read back, and counts by a person's yes.

Rule: what is offered is possible now, and its role may order it; it never takes the place of what was read back before.
"""

from __future__ import annotations

from rai_missions.conversation.inputs import Utterance
from rai_missions.conversation.nearest_orders import NearestOrders
from rai_missions.conversation.order_side import OrderSide
from rai_missions.conversation.talk import Talk

__all__ = ("OfferSide",)


class OfferSide:
    """Offers orders for sentences that no rule reads.

    Args:
        talk: What the sides share.
        orders: Where an order is judged and read back.
        nearest: Finds what is near.
    """

    def __init__(self, talk: Talk, orders: OrderSide, nearest: NearestOrders) -> None:
        self._talk, self._orders, self._nearest = talk, orders, nearest

    def offer(self, utterance: Utterance) -> None:
        """Read the nearest order back, if there is one, with those that are near as well."""
        if utterance.is_spoken or self._orders.confirmation.order is not None:
            return
        near = self._nearest.nearest(utterance.text, self._talk.view)
        if near := [sense for sense in near if self._orders.is_open(sense, utterance.role)]:
            self._orders.take(near[0], utterance, mapper="nearest", others=near[1:])
