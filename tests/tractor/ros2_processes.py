# SPDX-License-Identifier: Apache-2.0
"""A world in one process and its mission in another, both by the real command line, on a ROS domain of their own."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from rai_missions.connectors.contract import Inbox
from rai_missions.journal import read
from tests.ros2 import QUICK_DISCOVERY, lock_free_domain
from tests.trips import taken_options

ROOT = Path(__file__).parents[2]
TRACTOR = ROOT / "missions" / "tractor"
CLI = [sys.executable, "-W", "ignore", "-m", "rai_missions.cli.main"]
PATIENCE_S = 150.0


@contextmanager
def ros_domain(logs: Path) -> Iterator[dict[str, str]]:
    """The environment of processes that find each other and no one else."""
    domain, lock = lock_free_domain()
    with lock:
        yield {
            **os.environ,
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_DOMAIN_ID": str(domain),
            "FASTRTPS_DEFAULT_PROFILES_FILE": str(QUICK_DISCOVERY),
            "ROS_LOG_DIR": str(logs),
        }


class Process:
    """A command of ours that runs, and the lines that it has reported.

    Args:
        words: The command line after `rai-missions`.
        environment: Of `ros_domain`.
    """

    def __init__(self, words: list[str], environment: Mapping[str, str]) -> None:
        self.lines: Inbox[str] = Inbox(PATIENCE_S)
        self._process = subprocess.Popen(
            [*CLI, *words],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=ROOT,
            env=dict(environment),
        )
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.lines(line.rstrip("\n"))

    def wait_for(self, pattern: str) -> str:
        """Wait for a line; returns it."""
        found = self.lines.wait(lambda lines: any(re.search(pattern, line) for line in lines), f"a line {pattern!r}")
        return next(line for line in found if re.search(pattern, line))

    def ends(self) -> int:
        """Wait for its end; its exit status."""
        status = self._process.wait(PATIENCE_S)
        self._reader.join()
        return status

    @property
    def is_over(self) -> bool:
        return self._process.poll() is not None

    def signal(self, number: signal.Signals) -> None:
        self._process.send_signal(number)

    @property
    def text(self) -> str:
        return "\n".join(self.lines.all)

    def close(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self.ends()
        assert self._process.stdout is not None
        self._process.stdout.close()


class Graph:
    """Processes on one domain; all are ended with it."""

    def __init__(self, environment: Mapping[str, str], folder: Path) -> None:
        self.environment, self.folder = environment, folder
        self._processes: list[Process] = []

    def start(self, *words: str) -> Process:
        self._processes.append(Process(list(words), self.environment))
        return self._processes[-1]

    def world(self, *words: str, speed: str = "4", **options: Any) -> Process:
        """An orchard, once it is ready."""
        given = [word for name, value in options.items() for word in ("--option", f"{name}={json.dumps(value)}")]
        started = self.start("world", "orchard", "--ros", "--speed", speed, *words, *given)
        started.wait_for("^ready")
        return started

    def mission(self, **changed: Any) -> Path:
        """The shipped mission with other values of its own."""
        file = self.folder / "mission.json"
        file.write_text(json.dumps(json.loads((TRACTOR / "mission.json").read_text()) | changed))
        return file

    def run(
        self,
        *words: str,
        alleys: int = 1,
        robot: Path = TRACTOR / "robot.ros2.json",
        mission: Path = TRACTOR / "mission.json",
    ) -> Process:
        """The shipped mission with a shipped profile, unless others are named."""
        journal = str(self.folder / "run.journal")
        return self.start(
            "run",
            str(mission),
            "--robot",
            str(robot),
            "--no-operator",
            "--set",
            f"alleys={alleys}",
            "--journal",
            journal,
            *words,
        )

    def close(self) -> None:
        for each in self._processes:
            each.close()


Kind = TypeVar("Kind", bound=Graph)


def graph_in(folder: Path, kind: Callable[[Mapping[str, str], Path], Kind]) -> Iterator[Kind]:
    """For a fixture: processes on a domain of their own, which end with the test."""
    with ros_domain(folder / "ros-log") as environment:
        made = kind(environment, folder)
        yield made
        made.close()


def answers(journal: Path) -> list[str]:
    """The options that were taken, one after the other; the same again and again appears here once."""
    with read(journal) as record:
        taken = taken_options(record.steps())
    return [option for index, option in enumerate(taken) if index == 0 or taken[index - 1] != option]
