# SPDX-License-Identifier: Apache-2.0
"""Label scenes of the orchard, and figures of them: shares of the best options, what rules and the true kind decide,
and what passes the mission's guard.

    python -m benchmarks.bench_scenes label 500 --first 0 --out labels.jsonl   # all options
    python -m benchmarks.bench_scenes guard 2000 --first 0 --out guard.jsonl   # drive_over, where it is permitted
    python -m benchmarks.bench_scenes figures labels.jsonl guard.jsonl

`--step 2` takes every second seed: of even ones for tuning, of odd ones for reporting.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from pydantic import TypeAdapter

from rai_missions.campaign.labels import label, verdict_of
from rai_missions.campaign.records import best_options
from rai_missions.campaign.scenes import scene
from rai_missions.connectors.connector import Message
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site, View
from rai_missions.keys import Key, Stamped
from rai_missions.mission.files import load
from rai_missions.model import AnyOf
from rai_missions.profile import load_profile
from rai_missions.worlds.orchard.trial import decision_world, try_branch
from rai_missions.worlds.orchard.world import Orchard

TRACTOR = Path(__file__).parents[1] / "missions" / "tractor"
BEFORE = {"all": [{"key": "obstacle.living", "==": False}, {"key": "obstacle.height_m", "<": 0.25}]}
"""The guard of `drive_over` at commit fa87a85a, at the first attempt."""
BEFORE_RULES = {"all": [{"key": "obstacle.living", "==": False}, {"key": "obstacle.height_m", "<": 0.2}]}
"""The first rule at that commit; then: living → signal, else replan."""
Fact = Mapping[str, Any]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("label", "guard"):
        command = commands.add_parser(name)
        command.add_argument("count", type=int)
        command.add_argument("--first", type=int, default=0)
        command.add_argument("--step", type=int, default=1)
        command.add_argument("--out", type=Path, required=True)
    commands.add_parser("figures").add_argument("files", type=Path, nargs="+")
    words = parser.parse_args()
    if words.command == "figures":
        entries = [json.loads(line) for path in words.files for line in path.read_text().splitlines()]
        print("\n".join(figures([one for one in entries if "error" not in one])))
        return
    measure = labelled if words.command == "label" else past_the_guard
    with words.out.open("a") as out:
        for seed in range(words.first, words.first + words.count * words.step, words.step):
            out.write(json.dumps(measured(seed, measure)) + "\n")
            out.flush()


def measured(seed: int, measure: Callable[[Any, Any], Mapping[str, Any]]) -> dict[str, Any]:
    """One scene: what it is, the fact of the detector at the decision, and what was measured."""
    one, begun = scene("orchard", seed), time.process_time()
    found: dict[str, Any] = {"seed": seed, "kind": one.kind, "split": one.split}
    try:
        reports = ObstacleReports()
        world = decision_world(
            {**json.loads(one.spec)["options"], "camera": False, "sight": "geometry"}, reports.listen
        )
        found["fact"] = reports.known(world)
        found |= measure(one, (world, found["fact"]))
    except UsageError as fault:
        found["error"] = str(fault)
    return found | {"cpu_s": round(time.process_time() - begun, 3)}


class ObstacleReports:
    """What the detector reports of the obstacle, as a mission knows it: the last report, unless it is too old."""

    def __init__(self) -> None:
        self._last: tuple[float, Fact] | None = None

    def listen(self, world: Orchard) -> None:
        """Receive what this orchard reports."""
        connector = LocalConnector(now=lambda: world.at)
        topic = load_profile(TRACTOR / "robot.sim.json").blackboard["obstacle"]

        def receive(message: Message) -> None:
            self._last = world.at, json.loads(message.data["data"])

        connector.subscribe(topic.topic or "", topic.type or "", receive)
        world.open(connector)
        connector.start()

    def known(self, world: Orchard) -> Fact | None:
        """The fact at the instant at which the mission learns of the stop, for which it asks every so often."""
        profile, key = load_profile(TRACTOR / "robot.sim.json"), keys()["obstacle"]
        asks_at = world.at + (profile.events["anomaly"].every_s or 0.0)
        while world.at < asks_at:
            world.step()
        at, fact = self._last if self._last is not None else (-math.inf, None)
        return fact if world.at - at < (key.max_age_s or math.inf) else None


def labelled(one: Any, _at: Any) -> Mapping[str, Any]:
    return {"labels": {option: each.verdict for option, each in label(one).items()}}


def past_the_guard(_one: Any, at: Any) -> Mapping[str, Any]:
    world, fact = at
    is_permitted = holds(guard_now(), fact)
    return {"drive_over": verdict_of(try_branch(world, "drive_over"))} if is_permitted else {}


@cache
def guard_now() -> Guard:
    """The guard of `drive_over` in the shipped mission."""
    written = json.loads((TRACTOR / "mission.json").read_text())["states"]["assessing"]["decision"]["options"]
    return guard_of(written["drive_over"]["when"])


def guard_of(data: Any) -> Guard:
    return TypeAdapter(AnyOf[Guard]).validate_python(data)


def holds(guard: Guard, fact: Fact | None) -> bool:
    """Whether a guard is true over a fact that came this moment, at the first attempt."""
    board = {"crossings": Stamped(0, 0.0), "signals": Stamped(0, 0.0)}
    if fact is not None:
        board["obstacle"] = Stamped(fact, 0.0)
    view = SimpleNamespace(at=0.0, board=board, active=frozenset(), entered={}, held={}, event={}, answer={})
    return guard.compile(Site("/guard", keys(), "assessing"))(cast(View, view)) is True


@cache
def keys() -> Mapping[str, Key]:
    return load(TRACTOR / "mission.json").blackboard


def rules_now() -> list[tuple[Guard | None, str]]:
    return [(rule.when, rule.answer) for rule in load_profile(TRACTOR / "robot.sim.json").rules["assessing"]]


def rules_before() -> list[tuple[Guard | None, str]]:
    living = guard_of({"key": "obstacle.living", "==": True})
    return [(guard_of(BEFORE_RULES), "drive_over"), (living, "signal"), (None, "replan")]


def answer(rules: Iterable[tuple[Guard | None, str]], fact: Fact | None) -> str:
    return next(option for guard, option in rules if guard is None or holds(guard, fact))


def figures(entries: list[dict[str, Any]]) -> Iterator[str]:
    """Lines of text: each figure with the number of scenes that it is of."""
    for split in ("tune", "report"):
        found = [one for one in entries if one["split"] == split and "labels" in one]
        if found:
            yield f"{split}: {len(found)} labelled scenes, {mean(one['cpu_s'] for one in found):.2f} CPU-s each"
            yield from shares(found)
            yield from decided(found)
    yield from by_kind(entries)
    for name, guard in (("before", guard_of(BEFORE)), ("now", guard_now())):
        yield from passed(entries, name, guard)


def shares(found: list[dict[str, Any]]) -> Iterator[str]:
    counts: Counter[str] = Counter(option for one in found for option in best(one))
    alone: Counter[str] = Counter(next(iter(best(one))) for one in found if len(best(one)) == 1)
    for option in ("drive_over", "replan", "signal", "abort"):
        often = share(counts[option], len(found))
        yield f"  {option}: one of the best in {often}, alone {alone[option] / len(found):.1%}"


def decided(found: list[dict[str, Any]]) -> Iterator[str]:
    for name, rules in (("before", rules_before()), ("now", rules_now())):
        answers = [(one, answer(rules, one["fact"])) for one in found]
        right = sum(option in best(one) for one, option in answers)
        harm = sum(one["labels"][option] == "harms" for one, option in answers)
        yield f"  rules {name}: best in {share(right, len(found))}, harm in {harm}"


def by_kind(entries: list[dict[str, Any]]) -> Iterator[str]:
    """The option that is best most often for each true kind of `tune`, judged on `report`."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for one in entries:
        if one["split"] == "tune" and "labels" in one:
            counts[one["kind"]].update(best(one))
    judged = [one for one in entries if one["split"] == "report" and "labels" in one and counts[one["kind"]]]
    if judged:
        right = sum(counts[one["kind"]].most_common(1)[0][0] in best(one) for one in judged)
        yield f"the true kind alone, of tune on report: best in {share(right, len(judged))}"


def passed(entries: list[dict[str, Any]], name: str, guard: Guard) -> Iterator[str]:
    tried = entries if name == "now" else [one for one in entries if "labels" in one]
    known = [(one, holds(guard, one["fact"])) for one in tried if "labels" in one or "drive_over" in one]
    crossed = [(one, one.get("drive_over") or one["labels"]["drive_over"]) for one, permitted in known if permitted]
    harm = sum(verdict == "harms" for _, verdict in crossed)
    scenes = len([one for one in tried if one.get("fact") is not None])
    passable = [(one, permitted) for one, permitted in known if "labels" in one and one["split"] == "report"]
    passable = [each for each in passable if each[0]["labels"]["drive_over"] == "completes"]
    through = sum(permitted for _, permitted in passable)
    bound = f"of {scenes} scenes at most {upper(harm, scenes):.2%}"
    yield f"guard {name}: permits {len(crossed)}, {harm} of them harm: {bound}"
    if passable:
        yield f"guard {name}: of what is truly passable on report, passed {share(through, len(passable))}"


def best(one: Mapping[str, Any]) -> frozenset[str]:
    return best_options(one["labels"])


def share(count: int, of: int) -> str:
    return f"{count / of:.1%} ({count}/{of})"


def mean(values: Iterable[float]) -> float:
    found = list(values)
    return sum(found) / len(found)


def upper(count: int, of: int) -> float:
    """The upper bound of a share with 95 % confidence (Clopper and Pearson, one-sided), by bisection."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        tail = sum(math.comb(of, k) * middle**k * (1 - middle) ** (of - k) for k in range(count + 1)) if middle else 1.0
        low, high = (middle, high) if tail > 0.05 else (low, middle)
    return high


if __name__ == "__main__":
    main()
