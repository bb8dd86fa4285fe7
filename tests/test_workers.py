# SPDX-License-Identifier: Apache-2.0
"""A worker that dies fails the test in which it died, and nothing else."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
ENV = {"PYTHONPATH": str(ROOT), "PATH": "", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
"""Each process loads what is used here alone: with every plugin that is installed, it takes twice as long to begin."""
HOW = """
import pytest
from tests.workers import ByFile

@pytest.hookimpl
def pytest_xdist_make_scheduler(config, log):
    return ByFile(config, log)
"""
DEAD_BEFORE = """
import pytest

def pytest_runtest_logreport(report):
    if report.nodeid.endswith("test_alone.py::test_it[19]") and report.when == "call" and hasattr(report, "node"):
        with pytest.raises(EOFError):
            report.node.channel.waitclose(60)
        report.node._down = False
"""
"""The test before the fatal one is over once its worker is dead, and that has yet to be received."""
ALONE = """
import os, pytest

@pytest.mark.parametrize("number", range(140))
def test_it(number):
    if number == {fatal}:
        os._exit(1)
"""
TOGETHER = """
import os, pytest

@pytest.fixture(scope="module")
def once():
    return 0

@pytest.mark.parametrize("number", range(6))
def test_it(once, number):
    if number == 2:
        os._exit(1)
"""


def run(folder: Path, workers: int, conftest: str = HOW) -> str:
    (folder / "conftest.py").write_text(conftest)
    tried = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-p",
            "no:cacheprovider",
            "-p",
            "xdist",
            "-q",
            "-n",
            str(workers),
            "-c",
            "/dev/null",
            "--rootdir",
            str(folder),
            str(folder),
        ],
        cwd=ROOT,
        env=ENV,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    return tried.stdout


def test_one_that_dies_late_leaves_the_others_with_work(tmp_path: Path) -> None:
    (tmp_path / "test_alone.py").write_text(ALONE.format(fatal=130))
    assert "1 failed, 139 passed" in run(tmp_path, 2)


def test_the_only_one_that_dies_is_replaced_and_runs_what_is_left(tmp_path: Path) -> None:
    (tmp_path / "test_alone.py").write_text(ALONE.format(fatal=20))
    (tmp_path / "test_together.py").write_text(TOGETHER)
    assert "2 failed, 144 passed" in run(tmp_path, 1)


def test_one_that_is_dead_before_it_would_get_its_next_test_leaves_the_others_with_work(tmp_path: Path) -> None:
    (tmp_path / "test_alone.py").write_text(ALONE.format(fatal=20))
    assert "1 failed, 139 passed" in run(tmp_path, 1, HOW + DEAD_BEFORE)
