# SPDX-License-Identifier: Apache-2.0
"""Agents of all tempers, run together in a process of their own: `python troupe.py FILE KIND…`; FILE receives lines."""

from __future__ import annotations

import logging
import sys
import threading
from pathlib import Path

from rai_missions.agents.agent import AgentHealth
from rai_missions.agents.process_agent import ProcessAgent
from rai_missions.agents.runner import AgentRunner, exit_with
from rai_missions.connectors.local import LocalConnector

__all__ = ("Endless", "Player", "agent_of")

BEGINS_S, STOPS_S = 2.0, 20.0
"""Time for each to begin and to end on a machine that does much else."""


class Player:
    """Writes down what is asked of it, and does it as its kind has it."""

    def __init__(self, name: str, kind: str, file: Path) -> None:
        self.name, self.kind, self.file = name, kind, file
        self._is_running = False
        self.connectors = {"stage": LocalConnector()}

    def note(self, what: str) -> None:
        with self.file.open("a", encoding="utf-8") as file:
            file.write(f"{what} {self.name}\n")

    def run(self) -> None:
        self.note("run")
        if self.kind == "refuses":
            raise ValueError("no stage")
        if self.kind == "never_begins":
            threading.Event().wait()
        self.connectors["stage"].start()
        self._is_running = True

    def stop(self) -> None:
        self.note("stop")
        if self.kind == "hangs":
            threading.Event().wait()
        if self.kind == "breaks":
            raise OSError("the curtain is stuck")
        self.connectors["stage"].stop()
        self._is_running = False

    @property
    def health(self) -> AgentHealth:
        if self.kind == "dies" and self._is_running:
            return AgentHealth("died", "stage fright")
        if self.kind == "ends" and self._is_running:
            return AgentHealth("ended", "its part is over")
        if self.kind == "mute":
            threading.Event().wait()
        return AgentHealth("running" if self._is_running else "stopped")


class Endless(Player):
    """One that is waited for in vain, and not for long; for a process of its own, which its thread would keep alive."""

    stop_s = 1.0

    def run(self) -> None:
        super().run()
        threading.Thread(target=threading.Event().wait, daemon=False).start()


def agent_of(name: str, kind: str, file: Path) -> Player | ProcessAgent:
    if kind == "process":
        return ProcessAgent([sys.executable, "-c", f"import time; print('{name}', flush=True); time.sleep(600)"])
    if kind == "stubborn":
        ignoring = "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); time.sleep(600)"
        return ProcessAgent([sys.executable, "-c", ignoring], stop_s=0.2)
    if kind == "crashes":
        return ProcessAgent([sys.executable, "-c", "raise SystemExit('the lights went out')"])
    return (Endless if kind in ("hangs", "never_begins") else Player)(name, kind, file)


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    path = Path(sys.argv[1])
    agents = {f"{number}_{kind}": agent_of(f"{number}_{kind}", kind, path) for number, kind in enumerate(sys.argv[2:])}
    exit_with(AgentRunner(agents, start_s=BEGINS_S, stop_s=STOPS_S))
