# SPDX-License-Identifier: Apache-2.0
"""A process that has loaded everything and started nothing, from which one life after the other is forked.

Rule: a life is the real command line with a terminal of its own, and begins without any thread, node or open file of
another life. What is loaded before is all that it is spared.
"""

from __future__ import annotations

import gc
import json
import os
import pty
import select
import signal
import sys
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

PRINTS_S, LOOKS_S = 0.25, 0.01
NEEDED = ("test_msgs/action/Fibonacci", "std_srvs/srv/Trigger", "std_msgs/msg/Int32", "std_msgs/msg/Bool")
REHEARSAL = {
    "name": "rehearsal", "initial": "asking",
    "states": {
        "asking": {"decision": {"question": "On?", "options": {"on": {"about": "on"}}, "ask": ["operator"],
                                "deadline_s": 1, "fallback": "on"}, "transitions": [{"on": "on", "to": "sitting"}]},
        "sitting": {"tree": {"sequence": [{"wait_s": 0.01}]}, "timeout_s": 5,
                    "transitions": [{"on": "succeeded", "to": "over"}]},
        "over": {"final": "canceled"}},
}  # fmt: skip


def load_all(folder: Path) -> None:
    """Load whatever a run over ROS 2 loads: by a run without a robot, and by name."""
    from rai_missions.cli.main import main
    from rai_missions.connectors.ros2 import connector as _connector
    from rai_missions.connectors.ros2.names import find_type

    for name in NEEDED:
        cls = find_type(name, name.split("/")[1])  # type: ignore[arg-type]
        type(cls).__import_type_support__()
    mission, journal = folder / "rehearsal.json", folder / "rehearsal.journal"
    mission.write_text(json.dumps(REHEARSAL))
    silence = os.open(os.devnull, os.O_WRONLY)
    kept = os.dup(1)
    os.dup2(silence, 1)
    main(["run", str(mission), "--journal", str(journal)])
    main(["replay", str(journal)])
    os.dup2(kept, 1)
    assert _connector is not None and threading.active_count() == 1
    gc.collect()
    gc.freeze()


class Life:
    """One forked process.

    Args:
        wish: `words` of the command line, the file for what it reports, and the `instant` at which it kills itself.
    """

    def __init__(self, wish: Mapping[str, Any]) -> None:
        self.pid, self._terminal = pty.fork()
        if self.pid == 0:
            live(wish)
        os.set_blocking(self._terminal, False)
        self.signal_to = self.pid

    def type(self, text: str) -> None:
        """A person types; what the terminal echoes is not looked at."""
        try:
            os.read(self._terminal, 65536)
        except OSError:
            pass
        try:
            os.write(self._terminal, text.encode())
        except OSError:
            pass

    def status(self) -> int | None:
        """As `subprocess` has it; None while it lives."""
        pid, status = os.waitpid(self.pid, os.WNOHANG)
        if pid == 0:
            return None
        os.close(self._terminal)
        return os.waitstatus_to_exitcode(status)


def live(wish: Mapping[str, Any]) -> None:
    """In the child: run the command, and end."""
    status = 70
    try:
        reported = os.open(wish["out"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(reported, 1)
        os.dup2(reported, 2)
        if wish["instant"]:
            from tests.replay.instants import Instant, die_at

            die_at(Instant(*wish["instant"]))
        from rai_missions.cli.main import main

        status = main(wish["words"])
        import atexit

        atexit._run_exitfuncs()
    except BaseException:  # noqa: BLE001 - whatever it is, it must not continue as the process it was forked from
        import traceback

        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def say(**what: Any) -> None:
    sys.stdout.write(json.dumps(what) + "\n")
    sys.stdout.flush()


def serve() -> None:
    """Take wishes from standard input: a life, or a signal to the one that lives."""
    life, typed, waiting = None, 0.0, b""
    while True:
        ready, _, _ = select.select([0], [], [], LOOKS_S if life else None)
        if ready:
            read = os.read(0, 65536)
            if not read:
                break
            *lines, waiting = (waiting + read).split(b"\n")
            for line in lines:
                wish = json.loads(line)
                if "signal" not in wish:
                    life = Life(wish)
                    say(pid=life.pid)
                elif life is not None:
                    os.kill(life.pid, wish["signal"])
        if life is None:
            continue
        if time.monotonic() - typed > PRINTS_S:
            life.type("on\n")
            typed = time.monotonic()
        if (status := life.status()) is not None:
            life = None
            say(status=status)
    if life is not None:
        os.kill(life.pid, signal.SIGKILL)


if __name__ == "__main__":
    load_all(Path(sys.argv[1]))
    say(ready=True)
    serve()
