# SPDX-License-Identifier: Apache-2.0
"""How fast and in how much memory missions are proved: the shipped ones, and charts whose states multiply.

`python -m benchmarks.bench_prove [WHAT …]`: the name of a shipped mission; a number of regions of ten states each, side
by side, which share nothing, or with an `s` after it (`5s`) of nine states and with a key that they share: five of them
have a hundred thousand states, six nearly a million; `retry`, a tree that tries 10,000 times; `trees`, the three of
`tree_missions`. A process each, so that the memory is its own. The peer is SPIN, where it and a C compiler are here, on
the same counters as bare bytes: no claims, no guards, no timers, and a program made for them. Last, the tractor's proof
as a person starts it: the whole command.
"""

from __future__ import annotations

import json
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks.figures import children_cpu_s, figure
from benchmarks.tree_missions import TREE_MISSIONS

ROOT = Path(__file__).parents[1]
DIGITS, SHARED_DIGITS = 10, 9
DEFAULT = ("tractor", "rosbot", "3", "5", "5s", "6s", "retry", "trees")
MOST_S = {"5": 0.5, "5s": 2.0, "6s": 60.0, "retry": 5.0}
"""What is proved → the CPU seconds that it may take."""
MOST_MB = {"6s": 600.0}
MOST_COMMAND_S = 0.6
COMMAND = ("prove", "missions/tractor/mission.json", "--robot", "missions/tractor/robot.sim.json")
RETRY: dict[str, Any] = {
    "format": 1, "name": "retrying", "initial": "trying",
    "states": {
        "trying": {
            "tree": {"retry": 10_000, "child": {"call": "reset", "timeout_s": 1}}, "timeout_s": 1e6,
            "transitions": [{"on": ["succeeded", "timed_out"], "to": "over"}, {"on": "failed", "to": "over"}],
        },
        "over": {"final": "aborted"},
    },
}  # fmt: skip
GIVEN: dict[str, list[dict[str, Any]]] = {"retry": [RETRY], "trees": [*TREE_MISSIONS.values()]}
"""What is proved → its missions, where they are written here."""


def counting(regions: int, *, shared: bool = False, digits: int = DIGITS) -> dict[str, Any]:
    """Counters side by side, each moved on by an event of its own.

    Args:
        regions: How many.
        shared: A key lets each begin again; the first region sets it on its way, the second resets it.
        digits: The states of each.
    """

    def region(number: int) -> dict[str, Any]:
        names = [f"s{number}_{digit}" for digit in range(digits)]
        transitions: list[dict[str, Any]] = [
            {"on": f"e{number}", "to": names[(digit + 1) % digits]} for digit in range(digits)
        ]
        if shared:
            transitions[-1]["when"] = {"key": "gate", "==": True}
        if shared and number < 2:
            transitions[2]["do"] = [{"set": "gate", "value": number == 0}]
        return {
            "initial": names[0],
            "states": {n: {"transitions": [transition]} for n, transition in zip(names, transitions, strict=True)},
        }

    return {
        "format": 1,
        "name": "counting",
        "version": "1.0.0",
        "initial": "all",
        **({"blackboard": {"gate": {"type": "boolean", "initial": False}}} if shared else {}),
        "events": {**{f"e{number}": {} for number in range(regions)}, "stop": {}},
        "states": {"all": {"parallel": {f"r{n}": region(n) for n in range(regions)}}, "over": {"final": "aborted"}},
        "transitions": [{"on": "stop", "to": "over"}],
    }


def measure(what: str) -> dict[str, Any]:
    from rai_missions import load
    from rai_missions.mission.mission import Mission
    from rai_missions.profile import load_profile, robot_facts
    from rai_missions.prove import prove

    robot = None
    if what in GIVEN:
        missions = [Mission.model_validate(given) for given in GIVEN[what]]
    elif (digits := what.removesuffix("s")).isdigit():
        is_shared = digits != what
        chart = counting(int(digits), shared=is_shared, digits=SHARED_DIGITS if is_shared else DIGITS)
        missions = [Mission.model_validate(chart)]
    else:
        missions = [load(ROOT / "missions" / what / "mission.json")]
        robot = robot_facts(load_profile(ROOT / "missions" / what / "robot.sim.json"))
    before = time.process_time()
    proofs = [prove(each, robot_facts=robot, most=2_000_000) for each in missions]
    return {
        "what": named(what),
        "verdict": ", ".join(sorted({each.verdict for each in proofs})),
        "states": sum(each.states for each in proofs),
        "steps": sum(each.steps for each in proofs),
        "cpu_s": time.process_time() - before,
        "memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def named(what: str) -> str:
    """What is proved, in words."""
    if what in GIVEN:
        return {"retry": "10,000 tries", "trees": "3 trees"}[what]
    digits = what.removesuffix("s")
    if not digits.isdigit():
        return what
    return f"{digits} regions of {SHARED_DIGITS}, a key" if digits != what else f"{digits} regions"


def command_s() -> float:
    """The CPU seconds of the command that proves the tractor, the least of three."""
    spent = []
    for _ in range(3):
        before = children_cpu_s()
        subprocess.run(
            [sys.executable, "-m", "rai_missions.cli.main", *COMMAND], cwd=ROOT, check=True, capture_output=True
        )
        spent.append(children_cpu_s() - before)
    return min(spent)


def by_spin(regions: int) -> tuple[int, float]:
    """How many states SPIN stores of such a chart, and the CPU seconds that its compiled verifier takes."""
    counters = "".join(f"byte c{number};\n" for number in range(regions))
    moves = "".join(f"  :: atomic {{ c{each} = (c{each} + 1) % {DIGITS} }}\n" for each in range(regions))
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "counting.pml").write_text(f"{counters}init {{\n  do\n{moves}  :: break\n  od\n}}\n")
        for command in (["spin", "-a", "counting.pml"], ["cc", "-O2", "-DNOREDUCE", "-w", "-o", "pan", "pan.c"]):
            subprocess.run(command, cwd=folder, check=True, capture_output=True)
        before = children_cpu_s()
        depth = f"-m{2 * DIGITS ** min(regions, 6)}"
        printed = subprocess.run(["./pan", depth], cwd=folder, check=True, capture_output=True, text=True).stdout
        spent = children_cpu_s() - before
    stored = re.search(r"(\d+) states, stored", printed)
    return int(stored[1]) if stored else 0, spent


def main() -> None:
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measure(sys.argv[2])))
        return
    for what in sys.argv[1:] or DEFAULT:
        ran = subprocess.run(
            [sys.executable, "-m", "benchmarks.bench_prove", "--one", what], capture_output=True, text=True, check=True
        )
        result = json.loads(ran.stdout)
        pace = result["steps"] / result["cpu_s"]
        print(
            f"{result['what']:<16} {result['verdict']:<9} {result['states']:>9} states {result['steps']:>9} steps"
            f" {result['cpu_s']:>8.2f} s CPU {pace:>8.0f} steps/s {result['memory_mb']:>6.0f} MB"
        )
        peer = None
        if what.isdigit() and shutil.which("spin") and shutil.which("cc"):
            states, spent = by_spin(int(what))
            ratio = f"   of this ours takes {result['cpu_s'] / spent:.2g}" if spent >= 0.01 else ""
            peer = ("SPIN, bare counters", spent)
            print(f"{'  SPIN':<22} {states:>9} states {'':>15} {spent:>8.2f} s CPU{ratio}")
        figure(f"prove {result['what']}", result["cpu_s"], "s", peer=peer, most=MOST_S.get(what))
        if what in MOST_MB:
            figure(f"prove {result['what']}: memory", result["memory_mb"], "MB", most=MOST_MB[what])
    whole = command_s()
    print(f"{'rai-missions prove, tractor, whole command':<52} {whole:>8.2f} s CPU")
    figure("rai-missions prove, tractor, whole command", whole, "s", most=MOST_COMMAND_S)


if __name__ == "__main__":
    main()
