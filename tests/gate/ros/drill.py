# SPDX-License-Identifier: Apache-2.0
"""The drill: a gate, three holders and a base, a process each; and the judgement of what gate and base wrote down.

Holders are stopped and continued at random (SIGSTOP, SIGCONT); they drop, delay and fall silent by themselves.
"""

from __future__ import annotations

import json
import random
import signal
import statistics
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.connectors.contract import Inbox
from tests.gate.ros.party import CODES

ROOT = Path(__file__).parents[3]
HOLDERS = tuple(CODES)
LEASES = {"autonomy": 0.7, "agent": 0.3, "operator": 0.5}
NAMES = {code: who for who, code in CODES.items()}


class Party:
    """A process that reports on its output, a JSON list a line."""

    def __init__(self, *words: str) -> None:
        self.lines: Inbox[Any] = Inbox(60.0)
        self.process = subprocess.Popen(
            [sys.executable, "-W", "ignore", *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT
        )
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines(json.loads(line) if line.startswith("[") else ["text", line])

    def end(self) -> list[Any]:
        """Let it end by itself; what it reported."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.send_signal(signal.SIGCONT)
        self.process.stdin.close()
        try:
            self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._reader.join()
        self.process.stdout.close()
        return self.lines.all


class Record(NamedTuple):
    """What is left of a drill."""

    log: list[dict[str, Any]]
    """What the gate wrote down."""
    arrived: list[tuple[float, float, float]]
    """What came to the base: who, which, and how many seconds it took."""
    direct: list[float]
    """How many seconds a message took that went past the gate, on a topic of its own."""
    status: list[dict[str, Any]]
    holders: dict[str, dict[str, int]]
    """Who → what it reports to have sent."""
    closing: str
    """The gate's last words."""


@contextmanager
def parties(domain: int, seed: int, log: Path) -> Iterator[tuple[Party, dict[str, Party]]]:
    """The gate and the others, ready; they are ended in the end, whatever happens."""
    leases = [word for who, lease_s in LEASES.items() for word in ("--lease", f"{who}={lease_s}")]
    gate = Party(
        "-m",
        "rai_missions.cli.main",
        "gate",
        "--ros",
        "--domain",
        str(domain),
        "--log",
        str(log),
        "--memory",
        str(log) + ".memory",
        *leases,
    )
    script = str(Path(__file__).with_name("party.py"))
    others = {each: Party(script, each, str(domain), str(seed + code)) for code, each in enumerate(("base", *HOLDERS))}
    try:
        gate.lines.wait(
            lambda reported: any("commands are received" in str(each[-1]) for each in reported), "the gate is open"
        )
        for each in others.values():
            each.lines.wait(lambda reported: ["ready"] in reported, "it is ready")
        yield gate, others
    finally:
        for each in (gate, *others.values()):
            if each.process.poll() is None:
                each.end()


def drill(domain: int, seconds: float, seed: int, log: Path) -> Record:
    """Let them contend for so long."""
    die = random.Random(seed)
    with parties(domain, seed, log) as (gate, others):
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            time.sleep(die.uniform(0.1, 0.5))
            frozen = others[die.choice(HOLDERS)].process
            frozen.send_signal(signal.SIGSTOP)
            time.sleep(die.uniform(0.05, 1.2))
            frozen.send_signal(signal.SIGCONT)
        holders = {who: others[who].end()[-1][1] for who in HOLDERS}
        gate.process.send_signal(signal.SIGINT)
        closing = gate.end()[-1][-1]
        base = others["base"].end()[-1][1]
    rows = [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]
    arrived = [(who, which, took) for who, which, took in base["arrived"]]
    return Record(rows, arrived, base["direct"], base["status"], holders, closing)


def violations(record: Record) -> list[str]:
    """Whatever contradicts that there is one holder, and that only the holder's commands reach the base."""
    return [*_of_log(record.log), *_of_base(record), *_of_status(record.status)]


def _of_log(log: Sequence[dict[str, Any]]) -> Iterator[str]:
    holder, grant = "autonomy", 0
    seen: set[tuple[str, float]] = set()
    for row in log:
        if row["did"] == "changed":
            if (row["from"], row["grant"]) != (holder, grant + 1):
                yield f"control went from {holder} by {row}"
            holder, grant = row["to"], row["grant"]
        if row["did"] not in ("passed", "refused"):
            continue
        key = (row["who"], row["data"]["linear"]["y"])
        if CODES[row["who"]] != row["data"]["linear"]["x"]:
            yield f"a command of a stranger on {row['who']}'s topic: {row}"
        if key in seen:
            yield f"one command twice: {row}"
        seen.add(key)
        if (row["did"] == "passed") != (row["who"] == holder) or row["grant"] != grant:
            yield f"{holder} held control (grant {grant}): {row}"


def _of_base(record: Record) -> Iterator[str]:
    """What arrives is what the gate published, in its order; the quality of service may skip, never reorder."""
    published = [(row["who"], row["data"]["linear"]["y"]) for row in record.log if row["did"] == "passed"]
    places = {key: place for place, key in enumerate(published)}
    last = -1
    for code, number, _ in record.arrived:
        if code == 0.0:
            continue
        place = places.get((NAMES[code], number))
        if place is None:
            yield f"the base received {NAMES[code]}'s {number:g}, which the gate did not pass"
        elif place <= last:
            yield f"the base received {NAMES[code]}'s {number:g} after what the gate passed later"
        else:
            last = place


def _of_status(statuses: Sequence[dict[str, Any]]) -> Iterator[str]:
    holders: dict[int, str] = {}
    for status in statuses:
        if holders.setdefault(status["revision"], status["holder"]) != status["holder"]:
            yield f"grant {status['revision']} was {holders[status['revision']]}'s and {status['holder']}'s"
    revisions = [status["revision"] for status in statuses]
    if revisions != sorted(revisions):
        yield "revisions went backwards"


def figures(record: Record) -> dict[str, Any]:
    """The numbers of a drill."""
    did = Counter(row["did"] for row in record.log)
    lapses = sum(row["did"] == "changed" and "silent" in row["why"] for row in record.log)
    gated = sorted(took * 1e3 for code, _, took in record.arrived if code)
    direct = sorted(took * 1e3 for took in record.direct)
    sent = sum(each["sent"] for each in record.holders.values())
    report = {"sent": sent, "passed": did["passed"], "refused": did["refused"]}
    report |= {
        "received": did["passed"] + did["refused"],
        "arrived": len(gated),
        "handovers": did["changed"],
        "lapses": lapses,
    }
    report |= {
        "requests": did["answered"],
        "denied": sum(bool(row["why"]) for row in record.log if row["did"] == "answered"),
    }
    for name, all_ in (("gated_ms", gated), ("direct_ms", direct)):
        if len(all_) > 1:
            report[name] = [round(statistics.median(all_), 3), round(all_[int(len(all_) * 0.99)], 3)]
    return report | {"violations": len(violations(record))}
