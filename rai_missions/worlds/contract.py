# SPDX-License-Identifier: Apache-2.0
"""What every world must do, as a function that a world's tests call."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rai_missions.connectors.connector import Message
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError
from rai_missions.given import check_function
from rai_missions.worlds.world import World

__all__ = ("check_world",)


def check_world(make: Callable[[], World], topics: Iterable[str], *, steps: int = 40) -> None:
    """Hold a world to the contract of `World`.

    Args:
        make: Gives a fresh world, always of the same seed.
        topics: Topics that the world publishes within the steps.
        steps: How many steps to go.

    Raises:
        AssertionError: A promise is broken; the text states which.
        UsageError: The topics are no list of them, or there are none: nothing would be compared.
    """
    check_function(make, "check_world", "what makes a world", "give its class, or a function")
    if isinstance(topics, str):
        raise UsageError(f"the topics of a world are a list, [{topics!r}], not one text")
    names = tuple(topics)
    if not names:
        raise UsageError("a world is held to its contract by what it publishes: give topics of it")
    first, second = _published(make(), names, steps), _published(make(), names, steps)
    for name in names:
        assert any(message.topic == name for message in first), f"nothing is published on {name}"
    for one, other in zip(first, second, strict=True):
        assert (one.topic, one.at, repr(one.data)) == (other.topic, other.at, repr(other.data)), (
            f"the same seed and the same calls give the same run, but: {one} and {other}"
        )


def _published(world: World, topics: tuple[str, ...], steps: int) -> list[Message]:
    received: list[Message] = []
    connector = LocalConnector(now=lambda: world.at)
    for topic in topics:
        connector.subscribe(topic, "", received.append)
    world.open(connector)
    connector.start()
    assert world.at == 0.0, f"time starts at 0, not {world.at}"
    for number in range(1, steps + 1):
        world.step()
        assert abs(world.at - number * world.period_s) < 1e-6, f"step {number} ends at {world.at}"
        assert all(message.at <= world.at + 1e-9 for message in received), f"a message from the future: {received[-1]}"
    world.close()
    world.close()
    return received
