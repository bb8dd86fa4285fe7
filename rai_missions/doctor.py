# SPDX-License-Identifier: Apache-2.0
"""What this machine has, what it lacks, and how to get it."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Literal, NamedTuple

__all__ = ("Finding", "examine")

EXTRAS = (
    ("sim", ("mujoco", "numpy", "PIL"), "simulated worlds"),
    ("draw", ("graphviz_pure",), "pictures without a system Graphviz"),
    ("local", ("xllamacpp",), "a model that needs no key and no network"),
    ("openai", ("langchain_openai",), "models of OpenAI and of servers that speak its protocol"),
    ("anthropic", ("langchain_anthropic",), "models of Anthropic"),
    ("ollama", ("langchain_ollama",), "models served by Ollama"),
    ("record", ("mcap",), "recordings that Foxglove opens"),
)
NEEDED = ("pydantic", "langchain-core", "py-trees", "transitions", "jsonschema", "graphviz", "rich")


class Finding(NamedTuple):
    """One thing looked at."""

    status: Literal["ok", "absent", "missing"]
    """`missing` is needed; `absent` is there for those who want it."""
    what: str
    remedy: str = ""

    def __str__(self) -> str:
        return f"{self.status:8}{self.what}" + (f": {self.remedy}" if self.remedy else "")


def examine() -> Iterator[Finding]:
    """Look at everything that this project uses."""
    here = ".".join(map(str, sys.version_info[:3]))
    enough = sys.version_info >= (3, 11)
    yield Finding("ok" if enough else "missing", f"Python {here}", "" if enough else "3.11 or newer is needed")
    for name in NEEDED:
        yield _package(name)
    for extra, modules, what in EXTRAS:
        there = all(_has(module) for module in modules)
        remedy = "" if there else f"pip install 'rai_missions[{extra}]'"
        yield Finding("ok" if there else "absent", f"extra {extra} ({what})", remedy)
    yield _drawing()
    yield _rendering()
    yield from _ros()


def _has(module: str) -> bool:
    if module == "graphviz_pure":
        return _program("graphviz-pure") is not None
    return importlib.util.find_spec(module) is not None


def _package(name: str) -> Finding:
    try:
        return Finding("ok", f"{name} {version(name)}")
    except PackageNotFoundError:
        return Finding("missing", name, f"pip install {name}")


def _program(name: str) -> str | None:
    beside = Path(sys.executable).parent / name
    return str(beside) if beside.exists() else shutil.which(name)


def _drawing() -> Finding:
    for name in ("dot", "graphviz-pure"):
        if found := _program(name):
            return Finding("ok", f"pictures are drawn by {found}")
    return Finding("absent", "nothing draws SVG and PNG", "install Graphviz, or pip install 'rai_missions[draw]'")


def _rendering() -> Finding:
    if importlib.util.find_spec("mujoco") is None:
        return Finding("absent", "a camera in simulated worlds", "pip install 'rai_missions[sim]'")
    from rai_missions.errors import UsageError
    from rai_missions.worlds.world import open_world

    try:
        world = open_world("orchard", alleys=1, obstacles=["none"])
        world.close()
    except UsageError as error:
        return Finding("absent", "a camera in simulated worlds", str(error))
    return Finding("ok", f"simulated worlds, pictures by MUJOCO_GL={os.environ.get('MUJOCO_GL', 'the display')}")


def _ros() -> Iterator[Finding]:
    """A robot's own ROS and the wheels from PyPI must not meet in one process."""
    sourced, wheels = os.environ.get("ROS_DISTRO"), _installed("ros-rclpy")
    if sourced and wheels:
        remedy = "use one: a shell without the sourced ROS, or an environment without the ros-* wheels"
        yield Finding("missing", f"ROS {sourced} is sourced and ROS wheels are installed", remedy)
    elif sourced or wheels:
        yield Finding("ok", f"ROS: {sourced or 'from wheels'}")


def _installed(name: str) -> bool:
    try:
        version(name)
    except PackageNotFoundError:
        return False
    return True
