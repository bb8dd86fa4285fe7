# SPDX-License-Identifier: Apache-2.0
"""A simulated robot on ROS for `rai-missions world`, in a process of its own as a real one is."""

from __future__ import annotations

import math
import os
import signal
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import Any

from rai_missions.event import Event
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.interrupts import on_signals
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.worlds import open_world
from rai_missions.worlds.bridge import PublishedWorld, TrackedConnector, taken_names

__all__ = ("serve_world",)

LOOK_S = 3.0
"""After so long on the wall clock all other nodes are known, as a connector's `discovery_s` has it."""
REPORT_S = 60.0
"""Seconds on the wall between two words that all is well."""


def serve_world(name: str, options: Mapping[str, Any], *, domain: int | None, speed: float) -> int:
    """Put a world on ROS until an interrupt; returns the exit status.

    Args:
        name: The world's.
        options: What its class takes.
        domain: The ROS domain; None is that of `ROS_DOMAIN_ID`.
        speed: Simulated seconds for each second of wall time.
    """
    from rai_missions.connectors.ros2 import open_connector

    connector = open_connector({"pictures": True, **({} if domain is None else {"domain_id": domain})})
    world = open_world(name, **options)
    mailbox = Mailbox()
    try:
        with _ended_by_signal(mailbox):
            connector.start()
            mailbox.wait(LOOK_S)
            taken = taken_names(connector)
            front = TrackedConnector(connector, lambda name, fact: _print(f"{world.at:9.1f} s  {name}: {fact}"), taken)
            stage = PublishedWorld(world, front)
            world.open(front)
            _introduce(name, domain, speed, front)
            _go(stage, front, speed, mailbox)
    finally:
        connector.stop()
        world.close()
    return 0


def _go(stage: PublishedWorld, front: TrackedConnector, speed: float, mailbox: Mailbox) -> None:
    """Step the world at its pace until the mailbox holds the end."""
    clock = SimulatedClock(stage, speed)
    began = wall = time.monotonic()
    at = stage.at
    while mailbox.empty and time.monotonic() - began < LOOK_S:
        clock.wait(mailbox, stage.at + LOOK_S * min(speed, 1.0), paced=False)
    front.refuse_rivals()  # two that came at once did not see each other before
    while mailbox.empty:
        clock.wait(mailbox, stage.at + REPORT_S * min(speed, 1.0), paced=False)
        if time.monotonic() - wall >= REPORT_S:
            pace = (stage.at - at) / (time.monotonic() - wall)
            _print(f"{stage.at:9.1f} s  {pace:.1f} simulated seconds to one of the wall")
            wall, at = time.monotonic(), stage.at
    _print(f"{stage.at:9.1f} s  ended")


def _introduce(name: str, domain: int | None, speed: float, front: TrackedConnector) -> None:
    where = domain if domain is not None else os.environ.get("ROS_DOMAIN_ID") or "0"
    pace = "as fast as it goes" if speed == math.inf else f"{speed:g} simulated seconds to one of the wall"
    _print(f"{name} on ROS 2, domain {where}: {pace}")
    for sort, names in (("service", front.services), ("action", front.actions), ("topic", front.topics)):
        for name in sorted(names):
            _print(f"  {sort:8} {name} ({names[name]})")
    for name, why in front.left_out.items():
        _print(f"  left out {name}: {why}")
    _print("ready; Ctrl-C ends it")


_print = partial(print, flush=True)


@contextmanager
def _ended_by_signal(mailbox: Mailbox) -> Iterator[None]:
    """The first interrupt ends the world in good order, a second one at once."""

    def end(number: int, _frame: Any) -> None:
        if not mailbox.empty:
            raise KeyboardInterrupt
        mailbox.post(Event("end", 0.0, {"signal": signal.Signals(number).name}))

    with on_signals(end):
        yield
