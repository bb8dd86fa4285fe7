# SPDX-License-Identifier: Apache-2.0
"""Types of ROS by their names, `nav2_msgs/action/NavigateToPose`, found when they are first used."""

from __future__ import annotations

import importlib.util
import os
import site
import sys
import sysconfig
from functools import cache
from pathlib import Path
from typing import Any

from rai_missions.connectors.connector import TypeKind
from rai_missions.errors import ConnectorError, suggestion

__all__ = ("check_name", "find_type", "why_absent", "why_no_type")

WHAT = {"msg": "message", "srv": "service", "action": "action"}
EXAMPLE = {"msg": "std_msgs/msg/String", "srv": "std_srvs/srv/Trigger", "action": "nav2_msgs/action/NavigateToPose"}
INTERFACES = ("_msgs", "_srvs", "_interfaces")
"""How the name of a package of types ends."""
OURS_TO_BUILD = {"nav2_msgs": " (Nav2)", "rai_interfaces": " (RAI)", "rai_missions_msgs": "", "tf2_msgs": ""}
"""Packages that no wheel brings and whose definitions we have, and what brings them along on a robot."""


class NoSuchType(ConnectorError):
    """A type that no machine has: its name is none, or its package lacks it."""


@cache
def check_name(name: str, kind: TypeKind) -> None:
    """Whether ROS takes a name.

    Raises:
        ConnectorError: It does not; the sentence states where it goes wrong.
    """
    from rclpy.exceptions import NameValidationException
    from rclpy.validate_full_topic_name import validate_full_topic_name
    from rclpy.validate_topic_name import validate_topic_name

    try:
        validate_topic_name(name, is_service=kind != "msg")
        if name.startswith("/") and "{" not in name:
            validate_full_topic_name(name, is_service=kind != "msg")
    except NameValidationException as fault:
        why, _, where = str(fault).partition(":\n")
        at = where.partition("\n")[2].find("^") - where.find(name[:1] or "'")
        rest = f" from {name[at:]!r} on" if 0 < at < len(name) else ""
        raise ConnectorError(f"{name!r} is no name in ROS{rest}: {why.partition(': ')[2]}") from None


@cache
def find_type(name: str, kind: TypeKind) -> Any:
    """The class of a message, service or action.

    Raises:
        ConnectorError: No such package or type on this machine, or a name of another kind.
    """
    package, _, rest = name.partition("/")
    middle, _, last = rest.partition("/")
    if middle != kind or not package.isidentifier() or not last.isidentifier():
        given = f"{name!r} is no name of a {WHAT[kind]} type" if name else f"the type of the {WHAT[kind]} is missing"
        raise NoSuchType(f"{given}; one looks like {EXAMPLE[kind]!r}")
    _check_is_interfaces(package, kind)
    try:
        module = importlib.import_module(f"{package}.{kind}")
    except ModuleNotFoundError as fault:
        raise ConnectorError(_missing(fault, package, kind)) from None
    found = getattr(module, last, None)
    if not hasattr(found, "_TYPE_SUPPORT"):
        there = [each for each in vars(module) if each[0].isupper()]
        raise NoSuchType(f"{package} has no {WHAT[kind]} type {last!r}{suggestion(last, there)}")
    return found


def _check_is_interfaces(package: str, kind: TypeKind) -> None:
    """A profile may name any package, and importing one runs it: only an installed one with such types is imported.

    Raises:
        ConnectorError: There is such a package, and it has none, or is not installed.
    """
    spec = importlib.util.find_spec(package)
    if spec is None:
        return
    folders = [Path(each) for each in spec.submodule_search_locations or ()]
    if not any((folder / kind / "__init__.py").is_file() for folder in folders):
        raise ConnectorError(f"the package {package!r} has no {WHAT[kind]} types")
    if not all(_is_installed(package, folder.absolute()) for folder in folders):
        sentence = f"the package {package!r} in {folders[0].parent} is not installed, and is not imported"
        raise ConnectorError(f"{sentence}; source the workspace that has it, or install its wheel")


def _is_installed(package: str, folder: Path) -> bool:
    """Whether a package's folder is where a wheel is installed, or in a prefix whose ament index lists it.

    The working directory is no such place, whatever `sys.path` has.
    """
    places = {*map(sysconfig.get_path, ("purelib", "platlib")), *site.getsitepackages()}
    if site.ENABLE_USER_SITE:
        places.add(site.getusersitepackages())
    if folder.parent.resolve() in {Path(each).resolve() for each in places if each} - {Path.cwd().resolve()}:
        return True
    prefixes = [Path(each) for each in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if each]
    indices = [each for each in prefixes if (each / "share/ament_index/resource_index/packages" / package).is_file()]
    return any(
        folder.is_relative_to(prefix.absolute()) or folder.resolve().is_relative_to(prefix.resolve())
        for prefix in indices
    )


def why_absent(name: str, kind: TypeKind) -> str:
    """Why a type is not to be had here, in a sentence; empty if it is."""
    try:
        find_type(name, kind)
    except ConnectorError as fault:
        return str(fault)
    return ""


def why_no_type(name: str, kind: TypeKind) -> str:
    """Why no machine has a type, in a sentence; empty if one has, or if nothing here has its package."""
    try:
        find_type(name, kind)
    except NoSuchType as fault:
        return str(fault)
    except ConnectorError:
        return ""
    return ""


def _missing(fault: ModuleNotFoundError, package: str, kind: TypeKind) -> str:
    if fault.name not in (package, f"{package}.{kind}"):
        return f"the types of {package!r} do not load: {fault}"
    near = suggestion(package, _interface_packages())
    remedy = near if "did you mean" in near else "; source the workspace that has it, or install it"
    if package in OURS_TO_BUILD:
        remedy = f"; source a ROS 2 that has it{OURS_TO_BUILD[package]}, or build it in a checkout: make ros-interfaces"
    return f"no ROS package {package!r} on this machine{remedy}"


def _interface_packages() -> list[str]:
    """What is named like a package of types, in the folders where imports look; nothing in these folders is read."""
    places = [each for each in sys.path if os.path.isdir(each)]
    return sorted({name for each in places for name in os.listdir(each) if name.endswith(INTERFACES)})
