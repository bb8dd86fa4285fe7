# SPDX-License-Identifier: Apache-2.0
"""The lock of what tests and tools are on: every package has its hashes, and is what pyproject.toml asks for."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any, NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
LOCK = """thing==1.2 ; sys_platform == 'linux' \\
    --hash=sha256:aa
thing==1.3 ; sys_platform != 'linux' \\
    --hash=sha256:bb
"""


def audit() -> Any:
    spec = importlib.util.spec_from_file_location("audit", ROOT / "scripts/audit.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def faults(lock: str, *asked: str) -> list[str]:
    auditing = audit()
    project = {"dependencies": list(asked), "optional-dependencies": {extra: [] for extra in auditing.EXTRAS}}
    return list(auditing.faults(lock, project))


def test_a_lock_that_fits_has_no_fault() -> None:
    assert faults(LOCK, "Thing>=1,<2", "other; sys_platform == 'nowhere'") == []


def test_what_is_missing_too_old_or_without_a_hash_is_reported() -> None:
    assert faults(LOCK, "other>=1") == ["other>=1 is not in the lock"]
    assert faults(LOCK, "thing>=1.3") == ["thing>=1.3 is locked at 1.2, 1.3"]
    assert faults("thing==1.2\n") == ["thing has no hash"]


def test_every_package_of_the_lock_has_hashes_and_no_place_of_its_own() -> None:
    text = (ROOT / "requirements/dev.lock").read_text()
    assert "://" not in text and faults(text) == []


def test_the_weights_have_a_hash() -> None:
    lines = (ROOT / "requirements/weights.lock").read_text().splitlines()
    assert len(lines) == 2 and "==" in lines[0] and lines[1].strip().startswith("--hash=sha256:")


class Listed(NamedTuple):
    stdout: str
    stderr: str = ""


def listed(**words: Any) -> Listed:
    return Listed(json.dumps({"dependencies": [{"name": "thing", "version": "1", **words}]}))


FLAW = {"id": "CVE-1", "fix_versions": ["2"]}
ANSWERS: dict[str, tuple[Listed, int, str]] = {
    "nothing is known of all": (listed(vulns=[]), 0, "1 packages looked up"),
    "a flaw is known": (listed(vulns=[FLAW]), 1, "thing 1: CVE-1, mended in 2"),
    "no package is to be found": (listed(skip_reason="not found"), 2, "not looked up: pip-audit's data"),
    "it cannot be asked": (Listed("", "ConnectionError: no way"), 2, "not looked up: ConnectionError: no way"),
}


@pytest.mark.parametrize("name", ANSWERS)
def test_an_audit_reports_what_came_of_it(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    answer, status, reported = ANSWERS[name]
    monkeypatch.setattr("subprocess.run", lambda *_, **__: answer)
    assert audit()._known(tmp_path) == status
    assert reported in capsys.readouterr().out
