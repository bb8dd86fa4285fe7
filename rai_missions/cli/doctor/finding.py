# SPDX-License-Identifier: Apache-2.0
"""What the doctor reports of one thing, and how it tries what may crash or hang."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

from rai_missions.redaction import cut

__all__ = ("MachineFinding", "ProbeResult", "tried")

PROBE = "rai_missions.cli.doctor.probe"


class MachineFinding(NamedTuple):
    """One thing looked at."""

    status: Literal["ok", "warns", "absent", "missing"]
    """`missing` is needed; `absent` is there for those who want it; `warns` works, with a danger that it names."""
    what: str
    remedy: str = ""

    def __str__(self) -> str:
        return f"{self.status:8}{self.what}" + (f": {self.remedy}" if self.remedy else "")


class ProbeResult(NamedTuple):
    """What came of something tried in a process of its own."""

    value: Any = None
    fault: str = ""
    """Why there is no value, in a sentence."""


def tried(what: str, given: Any, environment: Mapping[str, str], *, within_s: float = 30.0) -> ProbeResult:
    """Try one of the probes; it may crash, hang or print anything.

    Args:
        what: The probe.
        given: Its input, a JSON value.
        environment: The variables of its process.
        within_s: How long it may take.
    """
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-W", "ignore", "-m", PROBE, what],
            input=json.dumps(given),
            capture_output=True,
            text=True,
            errors="replace",
            timeout=within_s,
            env=dict(environment),
            check=False,
        )
    except subprocess.TimeoutExpired:
        return ProbeResult(fault=f"nothing came back within {within_s:g} s")
    lines = done.stdout.splitlines()
    if done.returncode == 0 and lines:
        return ProbeResult(json.loads(lines[-1]))
    words = [line.strip() for line in done.stderr.splitlines() if line.strip()]
    if done.returncode < 0:
        return ProbeResult(fault=f"it crashed ({signal.Signals(-done.returncode).name})")
    return ProbeResult(fault=cut(words[-1], 300) if words else f"it ended with {done.returncode}")
