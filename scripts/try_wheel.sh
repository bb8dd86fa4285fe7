#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Builds the wheel, installs it into a fresh environment, and runs the tests marked `installed` on it, away from the
# checkout: what is missing from the wheel shows here. The dependencies are those of .venv, so nothing is downloaded.
set -euo pipefail
cd "$(dirname "$0")/.."

checkout="$PWD"
away="$(mktemp -d)"
trap 'rm -rf "$away"' EXIT

.venv/bin/python -m build --wheel --no-isolation --outdir "$away/dist" . >"$away/build.log" 2>&1 || {
    cat "$away/build.log" >&2
    exit 1
}
.venv/bin/python -m venv --without-pip "$away/venv"
.venv/bin/python -m pip --python "$away/venv/bin/python" install --quiet --disable-pip-version-check --no-deps "$away"/dist/*.whl

# The path file lends the dependencies, but not the checkout: path files found along it are not read.
lend='import sysconfig; print(sysconfig.get_path("purelib"))'
.venv/bin/python -c "$lend" >"$("$away/venv/bin/python" -c "$lend")/lent.pth"

# Without what others may be writing at this moment.
tar -C "$checkout" --exclude=__pycache__ --exclude=node_modules -cf - tests missions docs benchmarks pyproject.toml | tar -C "$away" -xf -
cd "$away"
# Only the files that have such tests: to load them all takes longer than to run these.
grep -rlZ --include='test_*.py' 'pytest\.mark\.installed' tests |
    PATH="$away/venv/bin:$checkout/.venv/bin:$PATH" xargs -0 venv/bin/python -m pytest -q -p no:cacheprovider -m installed
