# SPDX-License-Identifier: Apache-2.0
"""Offers: what a sentence that no rule reads may have meant is read back, and counts by a person's yes.

Rule: what is offered is possible now, and its role may order it; it never takes the place of what was read back before.
"""

from __future__ import annotations

from collections.abc import Sequence

from rai_missions.conversation.dialogue.order_judge import OrderJudge
from rai_missions.conversation.dialogue.talk import Talk
from rai_missions.conversation.grammar.nearest_orders import NearestOrders
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.inputs import Utterance

__all__ = ("OrderOffers",)


class OrderOffers:
    """Offers orders for sentences that no rule reads.

    Args:
        talk: What the parts of the dialogue share.
        orders: Where an order is judged and read back.
        nearest: Finds what is near.
    """

    def __init__(self, talk: Talk, orders: OrderJudge, nearest: NearestOrders) -> None:
        self._talk, self._orders, self._nearest = talk, orders, nearest

    def offer(self, utterance: Utterance) -> None:
        """Read the nearest order back, if there is one, with those that are near as well."""
        self._offer(utterance, self._near(utterance))

    def offer_by_names(self, utterance: Utterance) -> None:
        """As `offer`, for a question that was read and has no answer: what has a name of the sentence is offered."""
        self._offer(utterance, [sense for sense in self._near(utterance) if _is_by_names(sense)])

    def _near(self, utterance: Utterance) -> list[Sense]:
        if utterance.is_spoken or self._orders.confirmation.order is not None:
            return []
        near = self._nearest.nearest(utterance.text, self._talk.view)
        return [sense for sense in near if self._orders.is_open(sense, utterance.role)]

    def _offer(self, utterance: Utterance, near: Sequence[Sense]) -> None:
        if near:
            self._orders.take(near[0], utterance, mapper="nearest", others=near[1:])


def _is_by_names(sense: Sense) -> bool:
    return bool(sense.named) and all(isinstance(sense.arguments[name], str) for name in sense.named)
