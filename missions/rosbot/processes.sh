#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# The house as processes of their own on ROS 2: the world, and the mission as a node with the live page.
# processes.sh [WORDS OF run…], such as: processes.sh --set task=find --set object=cup --set place=bedroom
# WORLD="--seed 3 --option people=2" are words of the world; MISSION and ROBOT name other files.
# VOICE="" adds ears and a voice in a process of their own, and a conversation; its value are words of `voice`.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
export ROS_AUTOMATIC_DISCOVERY_RANGE="${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}"
log="$(mktemp)"

read -r -a world <<<"${WORLD:-}"
# In sessions of their own: Ctrl-C reaches the run alone, whose end is reported before the voice ends.
setsid rai-missions world house --ros "${world[@]}" >"$log" 2>&1 &
running=("$!")
watching=()
talk=()
# watch_over NAME PROCESS: the run continues without it, so its end is reported at once.
watch_over() {
    while kill -0 "$2" 2>/dev/null; do sleep 0.5; done
    echo "processes.sh: the $1 (process $2) has ended, and the run has not" >&2
}
end() {
    kill "${watching[@]}" 2>/dev/null || true
    kill -INT "${running[@]}" 2>/dev/null || true
    wait "${running[@]}" 2>/dev/null || true
    rm -f "$log"
}
trap end EXIT
for _ in $(seq 300); do
    if grep -q "^ready" "$log"; then break; fi
    if ! kill -0 "${running[0]}" 2>/dev/null; then
        cat "$log" >&2
        exit 2
    fi
    sleep 0.2
done
watch_over world "${running[0]}" &
watching+=("$!")
if [[ -n "${VOICE+set}" ]]; then
    read -r -a voice <<<"$VOICE"
    setsid rai-missions voice --ros "${voice[@]}" &
    running+=("$!")
    watch_over voice "${running[1]}" &
    watching+=("$!")
    talk=(--talk)
fi
rai-missions run "${MISSION:-$here/assist.json}" --robot "${ROBOT:-$here/robot.ros2.json}" --node --watch \
    "${talk[@]:---no-operator}" "$@"
