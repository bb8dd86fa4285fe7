# SPDX-License-Identifier: Apache-2.0
"""The lock of what tests and tools stand on: every package has its hashes, and is what pyproject.toml asks for."""

from __future__ import annotations

import importlib.util
from pathlib import Path

ROOT = Path(__file__).parents[2]
LOCK = """thing==1.2 ; sys_platform == 'linux' \\
    --hash=sha256:aa
thing==1.3 ; sys_platform != 'linux' \\
    --hash=sha256:bb
"""
EXTRAS = ("sim", "draw", "local", "mqtt", "record", "watch", "browser", "dev")


def told(lock: str, *asked: str) -> list[str]:
    spec = importlib.util.spec_from_file_location("audit", ROOT / "scripts/audit.py")
    assert spec is not None and spec.loader is not None
    audit = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(audit)
    project = {"dependencies": list(asked), "optional-dependencies": {extra: [] for extra in EXTRAS}}
    return list(audit.faults(lock, project))


def test_a_lock_that_fits_has_no_fault() -> None:
    assert told(LOCK, "Thing>=1,<2", "other; sys_platform == 'nowhere'") == []


def test_what_is_missing_too_old_or_without_a_hash_is_told() -> None:
    assert told(LOCK, "other>=1") == ["other>=1 is not in the lock"]
    assert told(LOCK, "thing>=1.3") == ["thing>=1.3 is locked at 1.2, 1.3"]
    assert told("thing==1.2\n") == ["thing has no hash"]


def test_every_package_of_the_lock_has_hashes_and_no_place_of_its_own() -> None:
    text = (ROOT / "requirements/dev.lock").read_text()
    assert "://" not in text and told(text) == []
