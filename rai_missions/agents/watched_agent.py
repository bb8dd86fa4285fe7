# SPDX-License-Identifier: Apache-2.0
"""One agent among several: started, looked at and stopped so that it holds up no other, whatever it does."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeVar, get_args, get_type_hints

from rai_missions.agents.agent import Agent, AgentHealth, HasConnectors, ReportsHealth, StopsSlowly, reports_health
from rai_missions.connectors.connector import Connector
from rai_missions.connectors.worker import Worker
from rai_missions.errors import raised_text
from rai_missions.redaction import cut, cut_repr, logger

__all__ = ("WatchedAgent",)

log = logger(__name__)

LOOK_S = 2.0
"""An agent that does not report within that how it fares hangs."""
TURN_S = 0.02
STATES = get_args(get_type_hints(AgentHealth)["state"])
T = TypeVar("T")


class WatchedAgent:
    """An agent and what is known of it.

    Args:
        name: For people.
        agent: What is run.
    """

    def __init__(self, name: str, agent: Agent) -> None:
        self.name, self.agent = name, agent
        self._health = AgentHealth("ready")
        self._asked_at: float | None = None
        self._is_given_up = False
        self._has_returned = threading.Event()
        self._awaited: set[threading.Thread] = set()
        self._worker = Worker(f"health of {name}")

    @property
    def health(self) -> AgentHealth:
        """What was last known."""
        asked_at = self._asked_at
        if self._health.state == "running" and asked_at is not None and time.monotonic() - asked_at > LOOK_S:
            return AgentHealth("hangs", f"it has not reported how it fares for {LOOK_S:g} s")
        return self._health

    @property
    def may_act(self) -> bool:
        """Whether it may still do something after its `stop`: it hangs, or that was waited for no longer."""
        return self._is_given_up or self.health.state == "hangs"

    @property
    def is_caller(self) -> bool:
        """Whether the agent's own `run` or `stop`, which is waited for, calls this."""
        return threading.current_thread() in self._awaited

    def begin(self, within_s: float, leaving: threading.Event) -> None:
        """Run it; where that fails or hangs, its health states why."""
        self._asked_at = None
        self._worker.start()
        self._has_returned = has_returned = threading.Event()

        def run() -> None:
            try:
                self.agent.run()
            finally:
                has_returned.set()

        self._health = self._attempt("run", run, within_s, leaving) or AgentHealth("running")

    def look(self) -> None:
        """Ask how it fares; never waits."""
        agent = self.agent
        if self._health.state == "running" and self._asked_at is None and reports_health(agent):
            self._asked_at = time.monotonic()
            self._worker.post(lambda: self._ask(agent))

    def end(self, within_s: float, leaving: threading.Event) -> None:
        """Stop it; where that fails or hangs, or its `run` does not return either, its health states why.

        Of one that died the first reason stays: what cannot begin often cannot end either. One that is waited for no
        longer does not hang: it had its time.

        Args:
            within_s: How long it may take, where it states nothing else.
            leaving: Once it is set, nothing is waited for.
        """
        before = self.health
        if before.state == "ready":
            return
        patience_s = self.patience_s(within_s)  # first: an agent may take its time to state it
        until = time.monotonic() + patience_s
        failure = self._attempt("stop", partial(_stop, self.agent), patience_s, leaving)
        self._is_given_up = failure is not None and failure.state == "hangs" and time.monotonic() < until
        if self._is_given_up and before.state == "running":
            failure = AgentHealth("stopped", "it was not waited for to the end")
        elif self._is_given_up or (
            failure is not None and before.state in ("failed", "died") and failure.state == "died"
        ):
            failure = None
        has_begun_late = before.state == "hangs" and failure is None and self._returns(until, leaving)
        is_stopped = before.state == "running" or has_begun_late
        self._health = failure or (AgentHealth("stopped") if is_stopped else before)
        self._worker.close(0.0)

    def _returns(self, until: float, leaving: threading.Event) -> bool:
        """Whether its `run` returns by then."""
        while not self._has_returned.wait(TURN_S) and time.monotonic() < until and not leaving.is_set():
            pass
        return self._has_returned.is_set()

    def patience_s(self, within_s: float) -> float:
        """How long its `stop` may take: what it states itself, or else so many seconds."""

        def stated() -> float:
            stop_s = float(self.agent.stop_s if isinstance(self.agent, StopsSlowly) else within_s)
            return stop_s if 0 < stop_s < math.inf else within_s

        return self._look_up("stop_s", stated, within_s)

    @property
    def connectors(self) -> Mapping[str, Connector]:
        """What it talks through, as far as it states that."""
        nothing: Mapping[str, Connector] = {}
        return self._look_up(
            "connectors", lambda: dict(self.agent.connectors) if isinstance(self.agent, HasConnectors) else {}, nothing
        )

    def cut_off(self) -> None:
        """Close its ways to robots and people: it `may_act`, and must move nothing later."""
        for purpose, connector in self.connectors.items():
            failure = self._attempt(f"stop of '{purpose}'", partial(_stop, connector), LOOK_S, threading.Event())
            become = failure.why if failure is not None else "was stopped"
            log.warning("%s is cut off; its connector '%s': %s", self.name, purpose, become)

    def _ask(self, agent: ReportsHealth) -> None:
        try:
            stated: object = agent.health
        except BaseException as error:  # noqa: BLE001 - an agent takes no other with it
            stated = AgentHealth("died", f"it cannot report how it fares: {cut(raised_text(error), 200)}")
        no_health = AgentHealth("died", f"it reports {cut_repr(stated, 100)}; {HEALTH}")
        found = stated if isinstance(stated, AgentHealth) and _is_health(stated) else no_health
        self._asked_at = None
        if self._health.state == "running" and found.state != "ready":
            self._health = found

    def _look_up(self, what: str, read: Callable[[], T], other: T) -> T:
        """What the agent states of itself; something else where it raises or hangs, which is logged."""
        found: list[T] = []
        failure = self._attempt(what, lambda: found.append(read()), LOOK_S, threading.Event())
        if failure is not None:
            log.warning("%s: %s", self.name, failure.why)
        return found[0] if found else other

    def _attempt(
        self, what: str, act: Callable[[], object], within_s: float, leaving: threading.Event
    ) -> AgentHealth | None:
        """Do it on a thread of its own; what that makes of the agent's health where it is not done."""
        raised: list[BaseException] = []

        def attempt() -> None:
            try:
                act()
            except BaseException as error:  # noqa: BLE001 - an agent takes no other with it
                raised.append(error)

        thread = threading.Thread(target=attempt, name=f"{self.name}: {what}", daemon=True)
        self._awaited.add(thread)
        thread.start()
        began = time.monotonic()
        while thread.is_alive() and time.monotonic() < began + within_s and not leaving.is_set():
            thread.join(TURN_S)
        self._awaited.discard(thread)
        if thread.is_alive():
            return AgentHealth("hangs", f"{what} has not returned within {time.monotonic() - began:.1f} s")
        if raised:
            return AgentHealth("died", f"{what} raised {cut(raised_text(raised[0]), 200)}")
        return None


def _stop(what: Agent | Connector) -> None:
    """Stop it; whether it can be stopped at all is found here, where what it raises is caught."""
    what.stop()


HEALTH = f"health is an AgentHealth whose state is one of {', '.join(STATES)}"


def _is_health(stated: AgentHealth) -> bool:
    """Whether its fields are what they are declared to be, so that it can be published."""
    return stated.state in STATES and all(map(isinstance, stated, (str, str, Mapping)))
