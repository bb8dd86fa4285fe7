# SPDX-License-Identifier: Apache-2.0
"""A process that runs commands under an audit hook and reports what they opened, executed and reached.

Rule: it is reported, as JSON on its input, `[[word, …], …]`, one list a command; it prints what each returned and did.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT
REACHES = (
    "socket.connect",
    "socket.bind",
    "socket.sendto",
    "socket.getaddrinfo",
    "urllib.Request",
    "ftplib.",
    "smtplib.",
)
STARTS = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "pty.spawn")
EVENTS: list[list[str]] = []


def audit(name: str, given: tuple[Any, ...]) -> None:
    """Write down what matters of an audit event (PEP 578)."""
    if name == "open" and isinstance(given[0], str | bytes):
        writes = isinstance(given[2], int) and given[2] & WRITING
        EVENTS.append(["write" if writes else "read", os.path.realpath(os.fsdecode(given[0]))])
    elif name == "exec":
        EVENTS.append(["execute", str(getattr(given[0], "co_filename", given[0]))])
    elif name == "sqlite3.connect":
        EVENTS.append(["read", os.path.realpath(str(given[0]).removeprefix("file:").partition("?")[0])])
    elif name in ("os.listdir", "os.scandir"):
        EVENTS.append(["read", os.path.realpath(str(given[0]))])
    elif name.startswith(REACHES):
        EVENTS.append(["reach", repr(given)[:200]])
    elif name.startswith(STARTS):
        EVENTS.append(["start", repr(given)[:200]])


def main() -> None:
    """Run what the input reports."""
    from rai_missions.cli.main import main as command

    commands = json.load(sys.stdin)
    sys.addaudithook(audit)
    ended = []
    for words in commands:
        try:
            ended.append(command(words))
        except SystemExit as end:
            ended.append(int(end.code or 0))
    sys.stdout.write("\n" + json.dumps({"ended": ended, "received": EVENTS}) + "\n")


if __name__ == "__main__":
    main()
