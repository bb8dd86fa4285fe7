# SPDX-License-Identifier: Apache-2.0
"""Opening a world by its name: what exists, what is missing, what it costs."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rai_missions.errors import UsageError
from rai_missions.worlds import open_world
from rai_missions.worlds.libraries import configure_libraries


def test_an_unknown_world_names_those_that_exist() -> None:
    with pytest.raises(UsageError, match="there is no world 'orchad'; did you mean 'orchard'"):
        open_world("orchad")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"trees": 5}, "the world 'orchard' has no option 'trees'; there are: seed, alleys,"),
        ({"obstacles": ["cow"]}, "obstacles: no kind 'cow'; there are: branch, log, crate"),
        ({"obstacles": [{"kind": "log", "colour": 3}]}, "obstacles: no field 'colour'; there is: across_m, alley"),
        ({"obstacles": ["log", "log"], "alleys": 1}, "obstacles: 2 obstacles for 1 alleys"),
        ({"stop_at_m": -3, "alleys": 1}, "stop_at_m takes a number from 0 to 100, not -3"),
        ({"alleys": 0}, "alleys: an orchard has 1 to 30 alleys, not 0"),
        ({"length_m": 5}, "length_m: an alley is 12 to 200 m long, not 5"),
        ({"detector": {"blur": 1}, "alleys": 1}, "detector: no option 'blur'; there is: confuse, false_alarm"),
        ({"detector": {"miss": 2}, "alleys": 1}, "detector: miss takes a number from 0 to 1, not 2"),
        ({"detector": {"noise": "x"}, "alleys": 1}, "detector: noise takes a number from 0 to 100, not 'x'"),
        ({"alleys": "x"}, "the world 'orchard' cannot be opened with alleys=\"x\": alleys takes a whole number"),
        ({"alleys": True}, "the world 'orchard' cannot be opened with alleys=true: alleys takes a whole number"),
        (
            {"length_m": "far", "camera": "no", "robot": 1, "battery": 7, "detector": "good"},
            'the world \'orchard\' cannot be opened with length_m="far", camera="no", robot=1, battery=7, '
            'detector="good": length_m takes a finite number, camera takes true or false, robot takes text, '
            "battery takes an object, detector takes an object",
        ),
        ({"battery": {"charge": "full"}}, "battery: charge takes a finite number, not 'full'"),
        ({"battery": {"volts": 1}, "alleys": 1}, "battery: no option 'volts'; there is: capacity_wh, charge"),
    ],
)
def test_a_wrong_option_names_the_right_ones(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(UsageError) as fault:
        open_world("orchard", **options)
    assert str(fault.value).startswith(sentence)


def test_a_missing_package_reports_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("rai_missions.worlds.orchard")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(UsageError, match=r"needs the package 'mujoco'.*pip install '\.\[sim\]'"):
        open_world("orchard")


def test_importing_the_worlds_loads_no_simulator() -> None:
    code = "import sys, rai_missions.worlds; print(*[m for m in ('mujoco', 'numpy', 'PIL') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


CPU_OF_THREADS = """
import os
from pathlib import Path
import rai_missions.worlds.orchard
others = [task for task in Path("/proc/self/task").iterdir() if int(task.name) != os.getpid()]
print(sum(int((task / "schedstat").read_text().split()[0]) for task in others) / 1e6)
"""


@pytest.mark.skipif(not Path("/proc/self/schedstat").exists(), reason="the CPU time of a thread is not shown here")
def test_threads_of_a_world_that_have_nothing_to_do_take_no_cpu_time() -> None:
    words = {name: text for name, text in os.environ.items() if not name.startswith("OPENBLAS")}
    found = subprocess.run(
        [sys.executable, "-c", CPU_OF_THREADS], env=words, capture_output=True, text=True, check=True
    )
    assert float(found.stdout) < 5, "milliseconds; OpenBLAS spins for about 25 by itself"


def test_what_the_environment_has_for_a_library_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    given = {"OPENBLAS_THREAD_TIMEOUT": "20", "MUJOCO_GL": "osmesa"}
    for name, text in given.items():
        monkeypatch.setenv(name, text)
    configure_libraries()
    assert {name: os.environ[name] for name in given} == given
