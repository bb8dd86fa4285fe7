# SPDX-License-Identifier: Apache-2.0
"""Whether a message package is there twice, where the loader takes one of them and others speak the other."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from itertools import combinations
from pathlib import Path

from rai_missions.cli.doctor.finding import MachineFinding
from rai_missions.connectors.ros2.names import OURS_TO_BUILD

__all__ = ("copies",)


def copies(environment: Mapping[str, str], home: Path | None = None) -> Iterator[MachineFinding]:
    """Each package of ours to build that is there more than once.

    Args:
        environment: The variables that ROS reads.
        home: Where this Python's packages are; its prefix if left out.
    """
    sourced = [Path(each) for each in environment.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if each]
    places = list(dict.fromkeys(each.resolve() for each in (*sourced, home or Path(sys.prefix))))
    for package in sorted(OURS_TO_BUILD):
        found = [each for each in places if (each / "share" / package / "package.xml").is_file()]
        if len(found) > 1:
            yield _finding(package, found)


def _finding(package: str, found: list[Path]) -> MachineFinding:
    what = f"{package} is there {len(found)} times: {', '.join(map(str, found))}"
    pairs = combinations([_definitions(each / "share" / package) for each in found], 2)
    if all(one[name] == other[name] for one, other in pairs for name in one.keys() & other.keys()):
        return MachineFinding("ok", f"{what}; what they share is the same")
    ours = f"share/rai_missions_interfaces/{package}.files lists what make ros-interfaces installed"
    return MachineFinding("missing", f"{what}, and their messages differ", f"keep one; {ours}")


def _definitions(share: Path) -> Mapping[str, str]:
    """The messages of a package by their files, without comments and empty lines."""
    files = sorted(path for kind in ("msg", "srv", "action") for path in share.glob(f"{kind}/*.{kind}"))
    return {path.name: _meaning(path.read_text(encoding="utf-8", errors="replace")) for path in files}


def _meaning(text: str) -> str:
    lines = (line.partition("#")[0].split() for line in text.splitlines())
    return "\n".join(" ".join(line) for line in lines if line)
