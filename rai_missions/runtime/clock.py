# SPDX-License-Identifier: Apache-2.0
"""Where a run's time comes from: the wall, a simulated world, or a simulation's `/clock`.

Rule: no code sleeps or polls; a run waits in one place, for an event or for an instant.
"""

from __future__ import annotations

import math
import threading
import time
from typing import NamedTuple, Protocol, runtime_checkable

from rai_missions.connectors.connector import Close, Connector, Message
from rai_missions.runtime.mailbox import Mailbox

__all__ = ("Clock", "ContinuedClock", "PublishedClock", "SimulatedClock", "Steppable", "WallClock")

WHOLE_TIME: int = getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC)
"""What counts a suspension as well: Linux has a clock for it, in macOS the monotonic one does."""


@runtime_checkable
class Clock(Protocol):
    """The run's clock, in seconds from its start."""

    def now(self) -> float: ...

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        """Return when the mailbox holds something, or at an instant.

        Args:
            mailbox: Where events come.
            until: An instant on this clock; infinity for none.
            paced: A model or a person is thinking: time goes no faster than on the wall.
        """

    def taken(self, mailbox: Mailbox, *, paced: bool) -> None:
        """Called with each event that a run has taken: a time that moves only in `wait` must move here too.

        Args:
            mailbox: Where it was taken from.
            paced: As in `wait`.
        """


class WallClock:
    """Real time, that in which the machine is suspended included; a new time of day does not move it."""

    def __init__(self) -> None:
        self._start = time.clock_gettime(WHOLE_TIME)

    def now(self) -> float:
        return time.clock_gettime(WHOLE_TIME) - self._start

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        mailbox.wait(None if until == math.inf else max(0.0, until - self.now()))

    def taken(self, mailbox: Mailbox, *, paced: bool) -> None:
        """Do nothing: wall time passes by itself."""


class ContinuedClock:
    """A clock that counts on from the instant at which a run was cut short, at the pace of another clock.

    It stays at this instant until the run begins to look, by `begin` or by waiting: to connect to a robot costs a run
    that is resumed none of its time.

    Args:
        clock: Whose time is counted on.
        start: From where, in seconds on the run's clock.
    """

    def __init__(self, clock: Clock, start: float) -> None:
        self._clock, self._start = clock, start
        self._ahead: float | None = None

    def begin(self) -> float:
        """Time moves from now on; how far it is ahead of the other clock."""
        if self._ahead is None:
            self._ahead = self._start - self._clock.now()
        return self._ahead

    def now(self) -> float:
        return self._start if self._ahead is None else self._clock.now() + self._ahead

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        ahead = self.begin()
        theirs = until - ahead
        while theirs + ahead < until:  # rounded; who waits for `until` would be left just before it
            theirs = math.nextafter(theirs, math.inf)
        self._clock.wait(mailbox, theirs, paced=paced)

    def taken(self, mailbox: Mailbox, *, paced: bool) -> None:
        self._clock.taken(mailbox, paced=paced)


class Steppable(Protocol):
    """What a simulated clock moves: a world."""

    period_s: float

    @property
    def at(self) -> float: ...

    def step(self) -> None: ...


MOST_AT_ONCE = 100
ALONE_S = 0.1


class SimulatedClock:
    """Time that moves only when nothing waits to be dealt with, or when what was dealt with never ends.

    A mission that asks its rules again and again has an answer to each question in the instant in which it asks. On the
    wall that takes time as well; so time passes by a step of the world, or by `ALONE_S` without one, once more was
    taken than had come and `MOST_AT_ONCE` that this had caused.

    Args:
        world: Stepped as time moves; without one time jumps to the next instant that anybody waits for.
        speed: Simulated seconds to one of the wall at the most; infinity for as fast as it goes.
    """

    def __init__(self, world: Steppable | None = None, speed: float = math.inf) -> None:
        self._world, self._speed = world, speed
        self._alone_at = 0.0
        self._pace = Pace(math.inf, 0.0, 0.0)
        self._left = MOST_AT_ONCE

    def now(self) -> float:
        return self._alone_at if self._world is None else self._world.at

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        speed = self._go_at(paced=paced)
        while mailbox.empty and self.now() < until:
            self._go_to(mailbox, self.now() + self._world.period_s if self._world is not None else until, speed)
        self._refill(mailbox)

    def _go_to(self, mailbox: Mailbox, target: float, speed: float) -> None:
        """Move to an instant once its turn has come; return before where something comes first."""
        early_s = self._pace.early_s(target) if speed != math.inf else (math.inf if target == math.inf else 0.0)
        if early_s > 0:
            mailbox.wait(early_s if early_s != math.inf else None)
            self._flow(target)
            return
        if early_s < -LATE_S:
            self._pace = Pace(speed, time.monotonic(), self.now())
        self._advance(target)

    def _refill(self, mailbox: Mailbox) -> None:
        """Set how many events may be taken before time passes, although none of them ends."""
        self._left = mailbox.waiting + MOST_AT_ONCE

    def taken(self, mailbox: Mailbox, *, paced: bool) -> None:
        self._left -= 1
        if self._left > 0:
            return
        target = self.now() + (self._world.period_s if self._world is not None else ALONE_S)
        if self._go_at(paced=paced) == math.inf or self._pace.early_s(target) <= 0:
            self._advance(target)
            self._left = mailbox.waiting + MOST_AT_ONCE

    def _go_at(self, *, paced: bool) -> float:
        """The speed that time has now."""
        speed = min(self._speed, 1.0) if paced else self._speed
        if speed != self._pace.speed:
            self._pace = Pace(speed, time.monotonic(), self.now())
        return speed

    def _flow(self, target: float) -> None:
        """Without a world, what came on the way to an instant came before it."""
        if self._world is None and self._pace.speed != math.inf:
            self._alone_at = max(self._alone_at, min(target, self._pace.reached()))

    def _advance(self, target: float) -> None:
        if self._world is not None:
            self._world.step()
        else:
            self._alone_at = target


LATE_S = 0.25
"""Simulated time so far behind its pace does not make up for it: a model or a person who thinks would lose it."""


class Pace(NamedTuple):
    """How fast simulated time may go, from an instant on the wall and on the run's clock."""

    speed: float
    wall: float
    start: float

    def early_s(self, at: float) -> float:
        """How many seconds of the wall an instant still lies ahead; negative if it is late."""
        return self.wall + (at - self.start) / self.speed - time.monotonic()

    def reached(self) -> float:
        """The instant whose turn it is now."""
        return self.start + (time.monotonic() - self.wall) * self.speed


SILENCE_S = 2.0
"""Where no time was received for so long on the wall, the simulation is gone, or was never there."""
JUMP_S = 60.0
"""Two times received one after the other that lie farther apart belong to two simulations."""


class PublishedClock:
    """Time as a simulation publishes it, on ROS's `/clock`: seconds since the run began.

    It never goes back and never stays still for good: a run that waits for a robot that is gone must not wait for ever,
    so a silence is filled with time as on the wall.

    Args:
        silence_s: Seconds on the wall after which time passes by itself.
    """

    def __init__(self, silence_s: float = SILENCE_S) -> None:
        self._silence_s = silence_s
        self._lock = threading.Lock()
        self._at = 0.0
        self._published: float | None = None
        self._received_at = time.monotonic()
        self._waiting: tuple[float, Mailbox] | None = None

    def follow(self, connector: Connector) -> Close:
        """Live by the time that is published on the robot's graph; what ends it."""
        return connector.subscribe("/clock", "rosgraph_msgs/msg/Clock", self.receive)

    def receive(self, message: Message) -> None:
        """The simulation has published a rosgraph_msgs/msg/Clock; from any thread."""
        stamp = message.data["clock"]
        self.advance(stamp["sec"] + stamp["nanosec"] / 1e9)

    def advance(self, published: float) -> None:
        """The simulation's time is now so many seconds; from any thread."""
        with self._lock:
            passed_s = 0.0 if self._published is None else published - self._published
            lived = self._at + (passed_s if 0.0 < passed_s <= JUMP_S else 0.0)
            self._at, self._published = max(lived, self._now()), published
            self._received_at = time.monotonic()
            due, mailbox = self._waiting or (math.inf, None)
            if mailbox is None or self._at < due:
                return
            self._waiting = None
        mailbox.wake()

    def now(self) -> float:
        with self._lock:
            return self._now()

    def _now(self) -> float:
        return self._at + max(0.0, time.monotonic() - self._received_at - self._silence_s)

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        """Return when the mailbox holds something, or when the simulation has reached an instant."""
        while mailbox.empty:
            with self._lock:
                now = self._now()
                if now >= until:
                    break
                self._waiting = (until, mailbox)
                silent_in_s = max(0.0, self._received_at + self._silence_s - time.monotonic())
                least_s = silent_in_s + (until - now if not silent_in_s else 0.0)
            mailbox.wait(None if until == math.inf else max(least_s, 1e-3))
        with self._lock:
            self._waiting = None

    def taken(self, mailbox: Mailbox, *, paced: bool) -> None:
        """Do nothing: wall time passes by itself."""
