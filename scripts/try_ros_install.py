# SPDX-License-Identifier: Apache-2.0
"""Finds an installed ROS package as `ros2 run` and `ros2 launch` do, and runs it: for `try_ros_package.sh`.

Source: `get_executable_path` of ros2run, and `get_share_file_path_from_package` of ros2launch: the executables of a
package are in `lib/<package>` of its prefix, its launch files anywhere in `share/<package>`.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from ament_index_python import get_package_prefix, get_package_share_directory

import rai_missions

PACKAGE = "rai_missions"


def executable(name: str) -> Path:
    """The one executable of a name, as `ros2 run` chooses it."""
    (found,) = (
        Path(folder, each)
        for folder, _, names in os.walk(Path(get_package_prefix(PACKAGE), "lib", PACKAGE))
        for each in names
        if each == name and os.access(Path(folder, each), os.X_OK)
    )
    return found


def output(program: Path, *words: str, status: int = 0) -> str:
    """What a program reports; it must exit with a status."""
    # What a shell of a robot has: the sourced workspace, and no virtual environment.
    kept = {name: value for name, value in os.environ.items() if name not in ("VIRTUAL_ENV", "PYTHONHOME")}
    done = subprocess.run([program, *words], env=kept, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == status, f"{program.name} {' '.join(words)}: {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


def main(workspace: Path) -> None:
    """Hold an installation to what the guide promises of it."""
    (home,) = (Path(folder) for folder in rai_missions.__path__)
    assert workspace in home.parents, f"the package comes from {home}, and not from the workspace"
    share = Path(get_package_share_directory(PACKAGE))
    assert share == workspace / "install" / PACKAGE / "share" / PACKAGE, share
    (launch_file,) = (Path(folder, each) for folder, _, names in os.walk(share) for each in names if "launch" in each)
    compile(launch_file.read_text(encoding="utf-8"), str(launch_file), "exec")

    assert output(executable("rai-missions"), "--version").startswith("rai_missions ")
    assert "no fault" in output(executable("rai-missions"), "check", str(share / "missions/tractor/mission.json"))
    # A mission without a robot has nothing to succeed at.
    ran = output(executable("run"), str(workspace / "lamp.json"), "--ros-args", "-r", "__node:=by_colcon", status=1)
    assert "aborted" in ran, ran
    output(executable("rai-missions"), "new", str(workspace / "own"), "--template", "tractor")
    if (workspace / "install" / "rai_missions_msgs").is_dir():
        import rai_missions_msgs
        from rai_missions_msgs.action import RunMission

        assert workspace in Path(rai_missions_msgs.__file__).parents and RunMission.Goal().arguments == ""
        print("rai_missions_msgs is built, and loads")
    print(f"{executable('run')} runs")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
