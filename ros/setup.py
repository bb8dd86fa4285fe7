# SPDX-License-Identifier: Apache-2.0
"""The package for colcon (ament_python), from what pyproject.toml states; pip builds the wheel from that file itself.

The packages are links next to this file, since colcon takes only what lies in a package's own folder.
"""

from __future__ import annotations

import os
import sys
import tomllib
from pathlib import Path

from setuptools import find_namespace_packages, setup

HERE = Path(__file__).resolve().parent
PYPROJECT = tomllib.loads((HERE.parent / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT, WHEEL = PYPROJECT["project"], PYPROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]
NAME = "rai_missions"
"""Of the ROS package, which has the name of the Python package."""


def packages() -> dict[str, str]:
    """Each Python package of the wheel, with its folder; folders of data count as packages of their own.

    With --symlink-install colcon is in a folder of links that lacks what the wheel puts inside of a package: the
    package finds that in the checkout itself.
    """
    roots = {root: root for root in WHEEL["packages"]}
    inside = {target.replace("/", "."): source for source, target in WHEEL["force-include"].items()}
    roots |= {package: folder for package, folder in inside.items() if Path(folder).is_dir()}
    found = dict(roots)
    for package, folder in roots.items():
        for inner in find_namespace_packages(str(HERE / folder)):
            if "__pycache__" not in inner:
                found[f"{package}.{inner}"] = f"{folder}/{inner.replace('.', '/')}"
    return found


def shared() -> list[tuple[str, list[str]]]:
    """Each folder of an install's `share`, with the files that go there."""
    folders = {"share/ament_index/resource_index/packages": [f"resource/{NAME}"], f"share/{NAME}": ["package.xml"]}
    for root in ("launch", "missions"):
        for folder, inner, names in os.walk(HERE / root, followlinks=True):
            inner[:] = [each for each in inner if each != "__pycache__"]
            below = Path(folder).relative_to(HERE).as_posix()
            folders[f"share/{NAME}/{below}"] = [f"{below}/{name}" for name in names]
    return [(target, sorted(files)) for target, files in sorted(folders.items()) if files]


def python() -> str:
    """The interpreter of the executables: that of the venv in use, although colcon itself may be the system's."""
    venv = os.environ.get("VIRTUAL_ENV")
    return f"{venv}/bin/python" if venv else sys.executable


def scripts() -> list[str]:
    """The executables: the command line itself, and `run`, for `ros2 run rai_missions run mission.json`."""
    named = {**PROJECT["scripts"], "run": f"{NAME}.cli.main:run"}
    return [f"{name} = {target}" for name, target in named.items()]


FOUND = packages()
sys.executable = python()  # what setuptools writes into the executables, installed or linked
setup(
    name=NAME,
    version=PROJECT["version"],
    description=PROJECT["description"],
    license=PROJECT["license"],
    python_requires=PROJECT["requires-python"],
    install_requires=PROJECT["dependencies"],
    packages=list(FOUND),
    package_dir={package: folder for package, folder in FOUND.items() if package != folder.replace("/", ".")},
    package_data={"": ["*"]},
    data_files=shared(),
    entry_points={"console_scripts": scripts(), **PROJECT.get("entry-points", {})},
    zip_safe=False,
)
