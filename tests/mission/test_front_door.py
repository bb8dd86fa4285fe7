# SPDX-License-Identifier: Apache-2.0
"""The package's front door offers every public name, and opens the rooms behind it only when asked."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import rai_missions

ROOT = Path(__file__).parents[2]
PROBE = """
import json, sys, time
import pydantic
before, start = set(sys.modules), time.process_time()
{code}
print(json.dumps([sorted(set(sys.modules) - before), time.process_time() - start]))
"""


def after(code: str) -> tuple[list[str], float]:
    """The modules that some code loads next to pydantic, and the CPU seconds it takes."""
    received = subprocess.run(
        [sys.executable, "-c", PROBE.format(code=code)], capture_output=True, text=True, check=True
    )
    modules, seconds = json.loads(received.stdout)
    return modules, seconds


def test_every_public_name_is_there() -> None:
    for name in rai_missions.__all__:
        assert getattr(rai_missions, name) is not None
    assert set(rai_missions.__all__) <= set(dir(rai_missions))
    with pytest.raises(AttributeError, match="has no attribute 'Chrat'"):
        rai_missions.Chrat  # type: ignore[attr-defined]  # noqa: B018


LIGHT = ("errors", "event", "mission", "mission.references")


def test_importing_the_package_loads_no_model_and_nothing_heavy() -> None:
    modules, seconds = after("import rai_missions")
    ours = [name for name in modules if name.startswith("rai_missions.")]
    assert set(ours) <= {f"rai_missions.{room}" for room in LIGHT}
    assert not {"numpy", "jsonschema", "py_trees", "sqlite3", "transitions", "rich"} & set(modules)
    assert seconds < 0.06


@pytest.mark.parametrize(
    "first", ["import rai_missions.mission.files, rai_missions.event", "import rai_missions.engine"]
)
def test_names_that_are_modules_too_are_what_the_front_door_reports(first: str) -> None:
    modules, _ = after(
        f"{first}\nfrom rai_missions import load, event\nassert callable(load) and event.x.__path__ == 'event.x'"
    )
    assert "rai_missions.mission.files" in modules


def test_options_without_parameters_load_nothing_that_judges_by_schemas() -> None:
    words = ["check", "missions/tractor/mission.json", "--robot", "missions/tractor/robot.sim.json"]
    modules, _ = after(
        f"import contextlib, io\nfrom rai_missions.cli.main import main\n"
        f"with contextlib.redirect_stdout(io.StringIO()): assert main({words!r}) == 0"
    )
    assert "rai_missions.profile.coverage" in modules
    assert "jsonschema" not in modules


@pytest.mark.parametrize(("path", "has_goals"), [("missions/tractor/mission.json", False),
                                                 ("missions/desk/stack.json", True)])  # fmt: skip
def test_the_planner_is_loaded_with_a_mission_that_has_goals(path: str, has_goals: bool) -> None:
    modules, _ = after(f"from rai_missions import Chart, load; Chart(load({str(ROOT / path)!r}))")
    assert ("rai_missions.planning.planner" in modules) is has_goals
