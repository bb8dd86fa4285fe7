# SPDX-License-Identifier: Apache-2.0
"""The desk: how often what was asked for is so in the end, by the world's truth, and how often that is misjudged.

`python -m benchmarks.bench_desk [SECTION …] [--count N] [--seed N] [--jobs N]`; sections: `arrange` (sort, stack and
swap without faults), `faults` (the same with things that slip, are pushed, taken, dropped and misread), `persistent`
(the same where every look takes one thing in five for another: what is so cannot be known), `goals` (at, left of, next
to, tower, grouped, over one to nine things), `refused` (requests that must not be acted on), `hard` (goals of
nine kinds at desks on which things touch, crowd, lean and hide each other, by two judges) and `combined` (the same with
faults that come together).
"""

from __future__ import annotations

import argparse
import statistics
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

from tests.desk.episodes import Episode, episode
from tests.desk.outside import HardEnd, combined_faults, hard_case, played_hard
from tests.desk.scenes import CASES, Case

__all__ = ("main",)


class Judged(NamedTuple):
    case: Case
    episode: Episode


def played(case: Case) -> Judged:
    return Judged(case, episode(case.request, case.world))


def _is_right(one: Judged) -> bool:
    return one.episode.outcome == one.case.outcome and (one.episode.outcome != "succeeded" or one.episode.is_so is True)


def report(name: str, judged: Sequence[Judged]) -> None:
    """Print a section's figures, and each case that did not end as it should."""
    ends = Counter(one.episode.outcome for one in judged)
    right = sum(_is_right(one) for one in judged)
    false = [one for one in judged if one.episode.is_false_success]
    missed = [one for one in judged if one.episode.is_false_failure]
    cpu = sorted(one.episode.cpu_s for one in judged)
    simulated = statistics.median(one.episode.simulated_s for one in judged)
    print(f"{name}: {right} of {len(judged)} end as they should ({right / len(judged):.1%}); {dict(ends)}")
    print(f"  succeeded that is not so: {len(false)}; failed that is so: {len(missed)}")
    p95 = cpu[int(0.95 * (len(cpu) - 1))]
    print(f"  CPU an episode: p50 {statistics.median(cpu):.2f} s, p95 {p95:.2f} s; simulated p50 {simulated:.1f} s")
    for case, end in judged:
        if not _is_right(Judged(case, end)):
            print(f"  seed {case.seed}: {case.request!r}: {end.outcome} ({end.state}), so: {end.is_so}; {end.why}")


def hard(seed: int) -> HardEnd:
    return played_hard(hard_case(seed))


def combined(seed: int) -> HardEnd:
    return played_hard(hard_case(seed, **combined_faults(seed)))


HARD: Mapping[str, Callable[[int], HardEnd]] = {"hard": hard, "combined": combined}


def report_hard(name: str, ends: Sequence[HardEnd]) -> None:
    """Print a section's figures by the plain judge, and each case that did not succeed."""
    done = [one for one in ends if one.outcome == "succeeded"]
    refused = [one for one in ends if one.outcome == "aborted"]
    false = [one for one in ends if one.is_false_success]
    missed = [one for one in ends if one.is_false_failure]
    print(f"{name}: {len(done)} of {len(ends)} succeeded, {len(refused)} refused before anything moved")
    print(f"  succeeded that is not so: {len(false)}; failed that is so: {len(missed)}")
    print(f"  CPU an episode: p50 {statistics.median(one.cpu_s for one in ends):.2f} s")
    for one in ends:
        if one.outcome != "succeeded" or one.is_false_success:
            case = one.case
            missing = "; ".join(one.unmet[:2])
            print(f"  seed {case.seed} ({case.desk}): {case.request!r}: {one.state}; {one.why}; {missing}")


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", default=list(CASES), help=f"of {', '.join((*CASES, *HARD))}")
    parser.add_argument("--count", type=int, default=40, help="episodes a section (40)")
    parser.add_argument("--seed", type=int, default=0, help="the first seed (0)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (2)")
    given = parser.parse_args(arguments)
    with ProcessPoolExecutor(given.jobs) as pool:
        for name in given.sections:
            seeds = range(given.seed, given.seed + given.count)
            if name in HARD:
                report_hard(name, list(pool.map(HARD[name], seeds)))
                continue
            cases = [CASES[name](seed) for seed in seeds]
            report(name, list(pool.map(played, cases)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
