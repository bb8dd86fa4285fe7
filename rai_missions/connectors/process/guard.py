# SPDX-License-Identifier: Apache-2.0
"""`python -m rai_missions.connectors.process.guard WORK REQUESTS REPLIES BYTES`: a process, and its guard.

It forks once. The child does the work; this process, the first of a session of its own, ends whatever descends from
the child: where the engine closes the pipe of its standard input or is gone, where the child ends, and where its
processes together are resident in more memory than they may be.

Rule: nothing of the work runs here, and nothing that it does is waited for. Linux alone is asked for anything.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import json
import os
import select
import signal
import sys
import time

__all__ = ("descendants", "main", "resident")

LOOK_S = 0.1
"""How often memory is measured."""
SHARE = 50
"""After it was looked for new processes, so many times as long is waited: a fiftieth of a core at the most."""
LAST_S = 2.0
"""How long what was killed is waited for."""
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36
GIB = 2**30
PAGE = os.sysconf("SC_PAGE_SIZE")
NICE = 5
"""The mission comes first where cores are few."""


def main(work: str, requests: int, replies: int, most: int) -> int:
    """Start the process, and end with it.

    Args:
        work: What the process does, as `module:function`, a module of ours.
        requests: The descriptor from which the process reads.
        replies: The descriptor to which it writes.
        most: Bytes of resident memory.
    """
    _prctl(PR_SET_CHILD_SUBREAPER, 1)  # what daemons its children leave behind stay descendants
    _prctl(PR_SET_PDEATHSIG, signal.SIGCONT)  # the child may have stopped this process
    engine = os.getppid()
    worker = os.fork()
    if worker == 0:
        _become_worker(work, requests, replies)
    os.close(requests)
    os.close(replies)
    why = _watch(worker, engine, most)
    end_all(os.getpid())
    with contextlib.suppress(OSError):
        os.write(1, json.dumps({"ended": why}).encode())
    return 0


def _become_worker(work: str, requests: int, replies: int) -> None:
    code = 1
    try:
        _prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        os.setpgid(0, 0)
        silent = os.open(os.devnull, os.O_RDWR)
        for fd in (0, 1, 2):
            os.dup2(silent, fd)
        os.set_inheritable(requests, False)
        os.set_inheritable(replies, False)
        with contextlib.suppress(OSError):
            os.nice(NICE)
            with open("/proc/self/oom_score_adj", "w", encoding="ascii") as score:
                score.write("1000")  # where memory is short, the kernel ends this one and not the mission
        module, _, name = work.partition(":")
        getattr(importlib.import_module(module), name)(requests, replies)
        code = 0
    finally:
        os._exit(code)


def _watch(worker: int, engine: int, most: int) -> str:
    """Wait until there is a reason to end everything; the reason."""
    ended, due, others = _on_child(), 0.0, list[int]()
    while True:
        ready, _, _ = select.select([0, ended], [], [], LOOK_S)
        if ended in ready:
            os.read(ended, 64)
        if (how := _reap(worker)) is not None:
            return how
        if 0 in ready and not os.read(0, 64):
            return "it was closed"
        if os.getppid() != engine:
            return "the engine is gone"
        if time.monotonic() >= due:
            began = time.monotonic()
            others = [pid for pid in descendants(os.getpid()) if pid != worker]
            due = began + SHARE * (time.monotonic() - began)
        used = sum(map(resident, (worker, *others)))
        if used > most:
            return f"it used {used / GIB:.2f} GiB of memory and may use {most / GIB:g}"


def _on_child() -> int:
    """A descriptor that can be read when a child has ended."""
    ended, rings = os.pipe()
    os.set_blocking(rings, False)
    signal.signal(signal.SIGCHLD, lambda number, frame: None)
    signal.set_wakeup_fd(rings, warn_on_full_buffer=False)
    return ended


def _reap(worker: int) -> str | None:
    """Take note of what has ended; how the process did, if it did."""
    with contextlib.suppress(ChildProcessError):
        while (found := os.waitpid(-1, os.WNOHANG))[0]:
            if found[0] == worker:
                return _how(found[1])
    return None


def _how(status: int) -> str:
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        with contextlib.suppress(ValueError):
            return f"it was ended by {signal.Signals(number).name}"
        return f"it was ended by signal {number}"
    return f"it ended with status {os.WEXITSTATUS(status)}"


def end_all(root: int) -> None:
    """Kill all that descends from a process, also what is begun meanwhile, and wait for it for a while."""
    until = time.monotonic() + LAST_S
    while time.monotonic() < until:
        for pid in descendants(root):
            with contextlib.suppress(OSError):
                if os.getpgid(pid) == pid:
                    os.killpg(pid, signal.SIGKILL)  # at once, so that none of them begins another
                os.kill(pid, signal.SIGKILL)
        try:
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        except ChildProcessError:
            return
        time.sleep(0.005)


def resident(pid: int) -> int:
    """Bytes of memory in which a process is resident; 0 for one that is gone."""
    try:
        with open(f"/proc/{pid}/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * PAGE
    except (OSError, IndexError):
        return 0


def descendants(root: int) -> list[int]:
    """The processes that descend from one, itself left out."""
    children: dict[int, list[int]] = {}
    for name in os.listdir("/proc") if os.path.isdir("/proc") else ():
        if name.isdecimal() and (parent := _parent(name)):
            children.setdefault(parent, []).append(int(name))
    found = [root]
    for pid in found:
        found += children.get(pid, ())
    return found[1:]


def _parent(pid: str) -> int:
    """A process's parent; 0 where it is gone."""
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            return int(file.read().rpartition(b")")[2].split()[1])
    except (OSError, IndexError, ValueError):
        return 0


def _prctl(what: int, value: int) -> None:
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(what, value, 0, 0, 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], *map(int, sys.argv[2:5])))
