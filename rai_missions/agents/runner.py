# SPDX-License-Identifier: Apache-2.0
"""Several agents as one: started in order, stopped in reverse, each fault named with its reason.

Rule: no agent waits for another. One that dies, hangs or raises takes no other with it.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Mapping
from typing import NoReturn

from rai_missions.agents.agent import Agent, AgentHealth, why_no_agent
from rai_missions.agents.health import DIAGNOSTIC_ARRAY, DIAGNOSTICS, diagnostics_of
from rai_missions.agents.watched_agent import WatchedAgent
from rai_missions.connectors.connector import Connector
from rai_missions.connectors.worker import Worker
from rai_missions.errors import UsageError
from rai_missions.redaction import logger, shown
from rai_missions.runtime.interrupts import on_signals

__all__ = ("AgentRunner", "exit_with")

log = logger(__name__)

LOOKS_S = 0.2
"""How often the agents are looked at."""
REPORTS_S = 1.0
"""How often their health is published where nothing changes."""


class AgentRunner:
    """Runs agents together; an `Agent` itself.

    Args:
        agents: Name → agent, in the order in which they are to begin.
        connector: Where their health is published on `/diagnostics`; its owner starts and stops it.
        name: The name of these agents together.
        start_s: How long an agent may take to begin.
        stop_s: How long one may take to end that states nothing of it.

    Raises:
        UsageError: Some are no agents, and all of those are named; or they have no names.
    """

    def __init__(
        self,
        agents: Mapping[str, Agent],
        *,
        connector: Connector | None = None,
        name: str = "agents",
        start_s: float = 30.0,
        stop_s: float = 3.0,
    ) -> None:
        if not isinstance(agents, Mapping):
            raise UsageError(f'agents are given by their names, {{"lamp": Lamp()}}, not as {shown(agents)}')
        if wrong := [f"'{each}': {why}" for each, agent in agents.items() if (why := why_no_agent(agent))]:
            raise UsageError("; ".join(wrong))
        self._watched = [WatchedAgent(each, agent) for each, agent in agents.items()]
        self._connector, self._name, self._start_s, self._stop_s = connector, name, start_s, stop_s
        self._leaving, self._hurries, self._changed = threading.Event(), threading.Event(), threading.Event()
        self._lock = threading.Lock()
        self._is_running = False
        self._worker = Worker(f"health of {name}")
        self._last: Mapping[str, AgentHealth] = {}
        self._reported_at = 0.0
        self._is_public = True

    @property
    def agents(self) -> Mapping[str, AgentHealth]:
        """Name → how it fares."""
        return {each.name: each.health for each in self._watched}

    @property
    def health(self) -> AgentHealth:
        """How they fare together: as the worst of them."""
        found = self.agents
        bad = [f"{name}: {each.state}, {each.why}" for name, each in found.items() if each.is_fault]
        if not self._is_running:
            return AgentHealth("stopped" if self._last else "ready", "; ".join(bad))
        return AgentHealth("running" if any(each.lives for each in found.values()) else "ended", "; ".join(bad))

    @property
    def may_act(self) -> bool:
        """Whether one may still do something after its `stop`."""
        return any(each.may_act for each in self._watched)

    @property
    def stop_s(self) -> float:
        """As long as all of them may take, one after the other, and a moment."""
        return sum(each.patience_s(self._stop_s) for each in self._watched) + 1.0

    @property
    def connectors(self) -> Mapping[str, Connector]:
        """The connectors of all agents: `agent/what it is for` → connector."""
        return {f"{each.name}/{name}": found for each in self._watched for name, found in each.connectors.items()}

    def run(self) -> None:
        """Begin each agent, one after the other; what one raises is its health, and the next begins.

        Where `stop` comes meanwhile, those that began end here.
        """
        with self._lock:
            if self._is_running:
                return
            self._is_running = True
            self._worker.start()
            self._worker.every(LOOKS_S, self._look)
            for each in self._watched:
                if not self._leaving.is_set():
                    each.begin(self._start_s, self._leaving)
                    log.info("%s: %s", each.name, each.health.state)
                    self._report()
            if self._leaving.is_set():
                self._end()

    def stop(self) -> None:
        """End them in the reverse order, each within `stop_s`, and cut off the one that hangs.

        Called by an agent's own `run` or `stop`, it returns at once: what waits for that agent ends them all.
        """
        is_within = any(each.is_caller for each in self._watched)
        self._leaving.set()
        if is_within:
            return
        with self._lock:
            if self._is_running:
                self._end()
            self._leaving.clear()

    def _end(self) -> None:
        for each in reversed(self._watched):
            each.end(self._stop_s, self._hurries)
            log.info("%s: %s", each.name, each.health.state)
        for each in reversed(self._watched):
            if each.may_act:
                each.cut_off()
        self._report()
        self._is_running = False
        self._leaving.clear()
        self._hurries.clear()
        self._worker.close(1.0)

    def leave(self) -> None:
        """Have `serve` stop all; a second time, have it wait for no one. From any thread or signal."""
        if self._leaving.is_set():
            self._hurries.set()
        self._leaving.set()
        self._changed.set()

    def serve(self) -> int:
        """Run until a signal comes, `leave` is called, or no agent lives; then stop all.

        Returns:
            The exit status: 1 where an agent failed, died or hangs.
        """
        with on_signals(lambda *_: self.leave()):
            self.run()
            while not self._leaving.is_set() and self.health.state == "running":
                self._changed.wait(LOOKS_S)
                self._changed.clear()
            self.stop()
        return int(any(each.is_fault for each in self.agents.values()))

    def _look(self) -> None:
        for each in self._watched:
            each.look()
        if self.agents != self._last or time.monotonic() - self._reported_at >= REPORTS_S:
            self._report()

    def _report(self) -> None:
        """Log what has become worse, and publish how they fare."""
        found, before = self.agents, self._last
        for name, health in found.items():
            if health.is_fault and before.get(name) != health:
                log.error("%s %s: %s", name, health.state, health.why)
        self._last, self._reported_at = found, time.monotonic()
        self._changed.set()
        if self._connector is not None:
            try:
                self._connector.publish(
                    DIAGNOSTICS, DIAGNOSTIC_ARRAY, diagnostics_of(self._name, found, at=time.time())
                )
                self._is_public = True
            except Exception:
                if self._is_public:
                    log.exception("how the agents fare cannot be published; this is logged once")
                self._is_public = False


def exit_with(runner: AgentRunner) -> NoReturn:
    """Serve, and end the process, also where an agent that hangs, or was not waited for, would keep it alive."""
    status = runner.serve()
    if runner.may_act:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
    sys.exit(status)
