# SPDX-License-Identifier: Apache-2.0
"""Each test ends by its limit, whatever it runs in."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ENV = {"PYTHONPATH": str(ROOT), "PATH": "", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
LOADED = ("-p", "tests.limits", "-p", "pytest_timeout", "-p", "_hypothesis_pytestplugin")
"""What is tried, and no plugin else: to load all that are installed takes as long as the rest of a process."""
DRAWN = """
from hypothesis import given, strategies as st

@given(st.integers())
def test_it(number):
    print("example", number, flush=True)
    while True:
        pass
"""
HELD_BACK = """
def test_it():
    while True:
        try:
            while True:
                pass
        except BaseException:
            pass
"""
IN_C = """
import collections, itertools

def test_it():
    collections.deque(itertools.repeat(0), maxlen=0)
"""


@pytest.mark.parametrize(
    ("source", "sentence"),
    [(DRAWN, "OutOfTime"), (HELD_BACK, "Timeout (0:00:"), (IN_C, "Timeout (0:00:")],
    ids=["hypothesis draws", "every exception is caught", "the interpreter's lock is held"],
)
def test_a_test_ends_by_its_limit(tmp_path: Path, source: str, sentence: str) -> None:
    (tmp_path / "test_endless.py").write_text(source)
    (tmp_path / "conftest.py").write_text("import tests.limits\ntests.limits.GRACE_S = 0.4\n")
    run = subprocess.run(
        [sys.executable, "-m", "pytest", *LOADED, "-s", "-p", "no:cacheprovider", "--timeout", "0.3", tmp_path],
        cwd=ROOT,
        env=ENV,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert run.returncode != 0
    assert sentence in run.stdout + run.stderr
    assert len(re.findall(r"example -?\d", run.stdout)) <= 1, "no other example follows"


def test_a_drill_has_its_time_also_where_it_is_run_by_itself(request: pytest.FixtureRequest) -> None:
    rig = next(each for each in request.config.pluginmanager.get_plugins() if hasattr(each, "DRILL_S"))
    request.node.add_marker(pytest.mark.drill)
    rig.pytest_collection_modifyitems([request.node])
    assert request.node.get_closest_marker("timeout").args == (rig.DRILL_S,) == (3600,)
