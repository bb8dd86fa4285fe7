# SPDX-License-Identifier: Apache-2.0
"""Looks at what this project is on: whether the lock holds what pyproject.toml asks for, and what is known of it.

Rule: exit 0 nothing is wrong, 1 a lock that does not fit or a known vulnerability, 2 the vulnerabilities could not be
looked up (no pip-audit, or its data is out of reach); with --offline they are not asked for.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

__all__ = ("faults", "locked", "main")

ROOT = Path(__file__).parents[1]
LOCK = ROOT / "requirements/dev.lock"
EXTRAS = tuple((ROOT / "requirements/dev.extras").read_text().split())
"""What the lock is made for. ROS's wheels are for one platform, and what is only measured against is no risk."""
PINNED = re.compile(r"^([A-Za-z0-9._-]+)==([^\s;\\]+)")


def locked(text: str) -> dict[str, tuple[set[str], int]]:
    """Package → its versions in a lock, one a platform, and how many hashes they have."""
    found: dict[str, tuple[set[str], int]] = {}
    name = ""
    for line in text.splitlines():
        if pin := PINNED.match(line):
            name = canonicalize_name(pin[1])
            found.setdefault(name, (set(), 0))[0].add(pin[2])
        if "--hash=sha256:" in line:
            versions, hashes = found[name]
            found[name] = versions, hashes + 1
    return found


def faults(text: str, project: dict[str, object]) -> Iterator[str]:
    """What in a lock does not fit pyproject.toml's `project`."""
    found = locked(text)
    yield from (f"{name} has no hash" for name, (_, hashes) in found.items() if not hashes)
    extras: dict[str, list[str]] = project["optional-dependencies"]  # type: ignore[assignment]
    asked: list[str] = [*project["dependencies"], *(each for extra in EXTRAS for each in extras[extra])]  # type: ignore[misc]
    for requirement in map(Requirement, asked):
        if requirement.marker is not None and not requirement.marker.evaluate({**default_environment(), "extra": ""}):
            continue
        versions, _ = found.get(canonicalize_name(requirement.name), (set(), 0))
        if not versions:
            yield f"{requirement} is not in the lock"
        elif not all(requirement.specifier.contains(version) for version in versions):
            yield f"{requirement} is locked at {', '.join(sorted(versions))}"


def _known(lock: Path) -> int:
    """Ask pip-audit; returns the exit status."""
    command = [sys.executable, "-m", "pip_audit", "-r", str(lock), "--no-deps", "--disable-pip", "-f", "json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    try:
        listed = json.loads(done.stdout)["dependencies"]
    except (ValueError, KeyError):
        why = (done.stderr.strip().splitlines() or ["it reported nothing"])[-1]
        print(f"not looked up: {why[:300]}; what is the lock with its hashes")
        return 2
    skipped = [each["name"] for each in listed if "skip_reason" in each]
    bad = [(each, flaw) for each in listed for flaw in each.get("vulns", ())]
    for each, flaw in bad:
        print(f"{each['name']} {each['version']}: {flaw['id']}, mended in {', '.join(flaw['fix_versions']) or 'none'}")
    if len(skipped) == len(listed):
        print("not looked up: pip-audit's data is out of reach from here; what is the lock with its hashes")
        return 2
    print(f"{len(listed) - len(skipped)} packages looked up, {len(skipped)} not to be found, {len(bad)} flaws known")
    return 1 if bad else 2 if skipped else 0


def main() -> int:
    """Audit; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--offline", action="store_true", help="look at the lock alone")
    given = parser.parse_args()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    text = LOCK.read_text()
    wrong = list(faults(text, project))
    for sentence in wrong:
        print(f"{LOCK.name}: {sentence}; make lock")
    print(f"{LOCK.name}: {len(locked(text))} packages, each with its hashes")
    if wrong:
        return 1
    return 0 if given.offline else _known(LOCK)


if __name__ == "__main__":
    sys.exit(main())
