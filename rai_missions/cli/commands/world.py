# SPDX-License-Identifier: Apache-2.0
"""`rai-missions world`: a simulated robot in a process of its own, as a real one is."""

from __future__ import annotations

import argparse
import json
import math
import os
import signal
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from rai_missions.cli.signals import on_signals
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.runtime.clock import Mailbox, SimulatedClock
from rai_missions.worlds.bridge import Front, Stage, company
from rai_missions.worlds.world import World

__all__ = ("world",)

LOOK_S = 3.0
"""After so long on the wall whoever else is there is known, as a connector's `discovery_s` has it."""
REPORT_S = 60.0
"""Seconds on the wall between two words that all is well."""


def world(given: argparse.Namespace) -> int:
    """Put a world on ROS until somebody ends it."""
    if not given.ros:
        raise UsageError(
            f"say where the world shall stand: 'rai-missions world {given.world} --ros' puts it on the ROS graph; "
            "in one process with its mission a profile opens it: "
            "rai-missions run missions/tractor/mission.json --robot missions/tractor/robot.sim.json"
        )
    from rai_missions.connectors.ros2 import open_connector

    domain = {} if given.domain is None else {"domain_id": given.domain}
    connector = open_connector({"pictures": True, **domain})
    made = _open(given)
    mailbox = Mailbox()
    try:
        with _ended_by_signal(mailbox):
            connector.start()
            mailbox.wait(LOOK_S)
            taken = company(connector)
            front = Front(connector, lambda name, fact: _say(f"{made.at:9.1f} s  {name}: {fact}"), taken)
            stage = Stage(made, front.as_connector())
            made.open(front.as_connector())
            _introduce(given, front)
            _go(stage, front, given.speed, mailbox)
    finally:
        connector.stop()
        made.close()
    return 0


def _open(given: argparse.Namespace) -> World:
    from rai_missions.worlds import open_world

    options = _options(given)
    try:
        return open_world(given.world, **options)
    except (TypeError, ValueError, AttributeError) as fault:  # a value of another kind than the world takes
        told = ", ".join(f"{name}={json.dumps(value)}" for name, value in options.items())
        raise UsageError(
            f"the world {given.world!r} cannot be opened with {told}: a value there is of another type than it takes"
        ) from fault


def _go(stage: Stage, front: Front, speed: float, mailbox: Mailbox) -> None:
    """Step the world at its pace until the mailbox says that it is over."""
    clock = SimulatedClock(stage, speed)
    began = wall = time.monotonic()
    at = stage.at
    while mailbox.empty and time.monotonic() - began < LOOK_S:
        clock.wait(mailbox, stage.at + LOOK_S * min(speed, 1.0), paced=False)
    front.refuse_company()  # two that came at once did not see each other before
    while mailbox.empty:
        clock.wait(mailbox, stage.at + REPORT_S * min(speed, 1.0), paced=False)
        if time.monotonic() - wall >= REPORT_S:
            pace = (stage.at - at) / (time.monotonic() - wall)
            _say(f"{stage.at:9.1f} s  {pace:.1f} simulated seconds to one of the wall")
            wall, at = time.monotonic(), stage.at
    _say(f"{stage.at:9.1f} s  ended")


def _options(given: argparse.Namespace) -> dict[str, Any]:
    """What the world's class takes; a value is JSON, or text where it is none."""
    options: dict[str, Any] = {}
    for pair in given.option:
        name, sign, text = pair.partition("=")
        if not sign:
            raise UsageError(f"--option {pair}: write KEY=VALUE")
        try:
            options[name] = json.loads(text)
        except json.JSONDecodeError:
            options[name] = text
    if given.seed is not None:
        options["seed"] = given.seed
    if given.no_camera:
        options["camera"] = False
    return options


def _introduce(given: argparse.Namespace, front: Front) -> None:
    domain = given.domain if given.domain is not None else os.environ.get("ROS_DOMAIN_ID") or "0"
    pace = "as fast as it goes" if given.speed == math.inf else f"{given.speed:g} simulated seconds to one of the wall"
    _say(f"{given.world} on ROS 2, domain {domain}: {pace}")
    _list("service", front.services)
    _list("action", front.actions)
    _list("topic", front.topics)
    for name, why in front.left_out.items():
        _say(f"  left out {name}: {why}")
    _say("ready; Ctrl-C ends it")


def _list(sort: str, names: Mapping[str, str]) -> None:
    for name in sorted(names):
        _say(f"  {sort:8} {name} ({names[name]})")


def _say(line: str) -> None:
    print(line, flush=True)


@contextmanager
def _ended_by_signal(mailbox: Mailbox) -> Iterator[None]:
    """The first interrupt ends the world in good order, a second one at once."""

    def end(number: int, _frame: Any) -> None:
        if not mailbox.empty:
            raise KeyboardInterrupt
        mailbox.post(Event("end", 0.0, {"signal": signal.Signals(number).name}))

    with on_signals(end):
        yield
