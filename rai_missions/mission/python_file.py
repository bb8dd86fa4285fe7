# SPDX-License-Identifier: Apache-2.0
"""Files in Python, executed by path; that of a mission offers `mission`, a `Mission` or a function that returns one.

Rule: what goes wrong in the file is the author's to mend and comes with its line; nothing is written next to the file.
"""

from __future__ import annotations

import ast
import hashlib
import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from types import CoroutineType, ModuleType
from typing import Any

from rai_missions.errors import DefinitionError, Fault, meant, suggestion
from rai_missions.mission.json_reader import file_bytes
from rai_missions.mission.mission import Mission
from rai_missions.redaction import shown

__all__ = ("call_offered", "run_file", "run_mission_file")

OURS = "rai_missions"


def run_mission_file(file: Path) -> Mission:
    """The file's `mission`, or what its function of that name returns.

    Raises:
        DefinitionError: The file cannot be executed, has no `mission`, or that is or returns something else.
        UsageError: There is no such file.
    """
    source = file_bytes(file)  # first: only of a file that is there it is known where it is
    module = run_file(file, source)
    if not hasattr(module, "mission"):
        raise _refused("the file has no 'mission'; write `mission = Mission(…)` or `def mission() -> Mission:`", file)
    offered: Any = module.mission
    if isinstance(offered, Mission):
        return offered
    if not callable(offered):
        raise _refused(f"'mission' is {shown(repr(offered))}; it is to be a Mission, or a function of it", file)
    mission: Any = call_offered(offered, file)
    if not isinstance(mission, Mission):
        raise _refused(f"mission() returned {shown(repr(mission))}; return a Mission", file)
    return mission


def run_file(file: Path, source: bytes) -> ModuleType:
    """Execute a file's text, and give the module that it makes.

    Args:
        file: Where it is; what goes wrong comes with its line there.
        source: Its text.

    Raises:
        DefinitionError: It cannot be executed.
    """
    path, name = file.resolve(), str(file)
    module = ModuleType(f"_program_{hashlib.sha256(os.fsencode(path)).hexdigest()[:16]}")
    module.__file__ = str(path)
    # By its name there, dataclasses and type hints of the file find their way home.
    sys.modules[module.__name__] = module
    try:
        exec(compile(source, str(path), "exec"), module.__dict__)  # noqa: S102 - a file that is named is a program
    except SyntaxError as error:
        raise DefinitionError([Fault("", f"line {error.lineno or 1}: not Python: {error.msg}")], name) from None
    except (Exception, SystemExit) as error:
        hint = _place_of_import(error, source) if isinstance(error, ImportError) else meant(error)
        raise _from(error, path, name, hint) from error
    return module


def call_offered(function: Callable[[], Any], file: Path) -> Any:
    """What a function of such a file returns.

    Raises:
        DefinitionError: It raises, or is an `async def`.
    """
    try:
        made = function()
    except (Exception, SystemExit) as error:
        raise _from(error, file.resolve(), str(file), meant(error)) from error
    if isinstance(made, CoroutineType):
        made.close()
        raise _refused(f"{made.__name__}() is an async function, and nothing awaits it; write `def`", file)
    return made


def _from(error: BaseException, path: Path, name: str, hint: str = "") -> DefinitionError:
    """An error raised in the file, with the innermost line of the file that led to it."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
    where = f"line {lines[-1]}: " if lines else ""
    if isinstance(error, DefinitionError):
        where = f"{where}in {error.source}: " if error.source else where
        return DefinitionError((Fault(fault.place, f"{where}{fault.sentence}") for fault in error.faults), name)
    text = str(error).strip()
    return DefinitionError([Fault("", f"{where}{type(error).__name__}" + (f": {text}" if text else "") + hint)], name)


def _place_of_import(error: ImportError, source: bytes) -> str:
    """Where a name is that a file imports from the wrong package of ours, or a name like it, in words."""
    package = sys.modules.get(error.name or "")
    if package is None or package.__name__.split(".")[0] != OURS:
        return ""
    imports = [each for each in ast.walk(ast.parse(source)) if isinstance(each, ast.ImportFrom)]
    names = [alias.name for each in imports if each.module == package.__name__ for alias in each.names]
    for name in names:
        if not hasattr(package, name):
            homes = [
                each
                for each, module in list(sys.modules.items())
                if each.split(".")[0] == OURS and name in getattr(module, "__all__", ())
            ]
            if homes:
                return f"; it is in {min(homes, key=len)}"
            return suggestion(name, [each for each in dir(package) if not each.startswith("_")])
    return ""


def _refused(sentence: str, file: Path) -> DefinitionError:
    return DefinitionError([Fault("", sentence)], str(file))
