#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Builds the ROS packages with colcon, as in a workspace, and runs what `ros2 run` finds: scripts/try_ros_package.sh
#
# The packages of Python and the ROS wheels are those of .venv, or of VENV=/path, as on a robot those of its venv; colcon
# is in an environment of its own, as there in the system's. rai_missions_msgs is built along where `make
# ros-interfaces` has put the generators.
set -euo pipefail
cd "$(dirname "$0")/.."

checkout="$PWD"
venv="$(realpath "${VENV:-.venv}")"
away="$(mktemp -d)"
trap 'rm -rf "$away"' EXIT
export PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_INPUT=1 ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST

inform() { printf '%s\n' "ros package: $*" >&2; }

"$venv/bin/python" -m venv "$away/venv"
# setuptools as Ubuntu 24.04 has it: what builds with it builds on a robot.
"$away/venv/bin/python" -m pip install -qq "colcon-core>=0.18,<1" "colcon-ros>=0.5,<1" "setuptools==68.1.2"

paths=(ros)
if [ -d "$venv/share/rosidl_default_generators" ]; then
    paths+=(interfaces/rai_missions_msgs)
else
    inform "rai_missions_msgs is left out: its generators are not in $venv (make ros-interfaces installs them)"
fi

# A workspace that is built in one way, and what an installation must be able to do.
try() {
    local workspace="$away/$1"
    shift
    mkdir "$workspace"
    (
        cd "$workspace"
        export VIRTUAL_ENV="$venv" PATH="$away/venv/bin:$venv/bin:$PATH"
        export AMENT_PREFIX_PATH="$venv" CMAKE_PREFIX_PATH="$venv" PYTHONDONTWRITEBYTECODE=1
        "$away/venv/bin/colcon" --log-level error build "$@" --paths "${paths[@]/#/$checkout/}" \
            --cmake-args -DBUILD_TESTING=OFF -DCMAKE_BUILD_TYPE=Release -DPython3_EXECUTABLE="$venv/bin/python" \
            >build.log 2>&1 || { cat build.log >&2 && exit 1; }
    )
    (
        cd "$workspace"
        export AMENT_PREFIX_PATH="$venv"
        set +u
        # shellcheck disable=SC1091
        source install/local_setup.sh
        set -u
        cat >lamp.json <<'JSON'
{"format": 1, "name": "lamp", "initial": "on",
 "states": {"on": {"transitions": [{"after_s": 0.1, "to": "off"}]}, "off": {"final": "aborted"}}}
JSON
        "$venv/bin/python" "$checkout/scripts/try_ros_install.py" "$workspace"
    )
}

try installed
try linked --symlink-install
inform "both kinds of installation run"
