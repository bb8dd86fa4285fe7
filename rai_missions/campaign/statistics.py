# SPDX-License-Identifier: Apache-2.0
"""What a share of cells is worth: intervals, paired tests and corrections for many of them.

Rule: scenes of one seed are one observation. Whatever an interval or a test counts as independent is a cluster, and
where each cluster has one member the results are the textbook's.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from statistics import NormalDist
from typing import NamedTuple

__all__ = ("Interval", "PairedTest", "clustered_interval", "holm", "paired_test", "student_quantile", "wilson")

CONFIDENCE = 0.95
LARGEST_EXACT = 200_000
"""Steps of a distribution that is worked out exactly; a longer one is taken as normal."""


class Interval(NamedTuple):
    """A share with its confidence interval."""

    share: float
    """0 to 1; NaN where nothing was counted."""
    low: float
    high: float
    cells: int
    effective: float
    """Independent cells that are worth as much: `cells`, less where cells of one cluster are alike."""


class PairedTest(NamedTuple):
    """Two answerers compared in the same scenes."""

    difference: float
    """Of the shares, first less second."""
    low: float
    high: float
    p: float
    """Two-sided; 1 where they never differ."""
    pairs: int
    """Cells that both have."""
    clusters: int
    wins: int
    """Pairs in which the first alone has it."""
    losses: int
    """Pairs in which the second alone has it."""


def wilson(successes: float, count: float, *, quantile: float | None = None) -> tuple[float, float]:
    """The score interval of a share, 0 to 1.

    Source: E. B. Wilson, "Probable inference, the law of succession, and statistical inference", Journal of the
    American Statistical Association 22 (1927) 209–212; as method 3 of R. G. Newcombe, Statistics in Medicine 17 (1998)
    857–872.

    Args:
        successes: 0 to `count`; need not be whole.
        count: Independent observations; with none the interval is all of 0 to 1.
        quantile: Of the standard normal or another distribution; left out: for 95 %.
    """
    if count <= 0:
        return 0.0, 1.0
    z = NormalDist().inv_cdf((1 + CONFIDENCE) / 2) if quantile is None else quantile
    share, squared = successes / count, z * z
    middle = share + squared / (2 * count)
    reach = z * math.sqrt(max(0.0, share * (1 - share) / count + squared / (4 * count * count)))
    scale = 1 + squared / count
    low = 0.0 if successes <= 0 else max(0.0, (middle - reach) / scale)
    high = 1.0 if successes >= count else min(1.0, (middle + reach) / scale)
    return low, high


def clustered_interval(outcomes: Iterable[tuple[object, bool]]) -> Interval:
    """The 95 % interval of a share whose observations come in clusters.

    It is Wilson's with as many observations as the clusters are worth: p (1 − p) over the variance of the ratio
    estimator between clusters, and Student's quantile for their number less one. Where the share is 0 or 1 the
    clusters show nothing of their likeness, and each counts as one observation.

    Source: N. Dean and M. Pagano, "Evaluating confidence interval methods for binomial proportions in clustered
    surveys", Journal of Survey Statistics and Methodology 3 (2015) 484–503; effective size by E. L. Korn and B. I.
    Graubard, Survey Methodology 24 (1998) 193–201.

    Args:
        outcomes: The cluster of each observation, and whether it is a success.
    """
    sizes, hits = Counter[object](), Counter[object]()
    for cluster, success in outcomes:
        sizes[cluster] += 1
        hits[cluster] += success
    count, groups, successes = sum(sizes.values()), len(sizes), sum(hits.values())
    if not count:
        return Interval(math.nan, 0.0, 1.0, 0, 0.0)
    share = successes / count
    if groups == count:  # each its own cluster: Wilson's
        return Interval(share, *wilson(successes, count), count, float(count))
    effective = _effective(share, sizes, hits) if 0 < successes < count and groups > 1 else float(groups)
    quantile = student_quantile((1 + CONFIDENCE) / 2, groups - 1) if groups > 1 else None
    return Interval(share, *wilson(share * effective, effective, quantile=quantile), count, effective)


def _effective(share: float, sizes: Mapping[object, int], hits: Mapping[object, int]) -> float:
    """Independent observations with the variance that these clusters have; at least one, at most all."""
    count, groups = sum(sizes.values()), len(sizes)
    squares = math.fsum((hits[cluster] - share * size) ** 2 for cluster, size in sizes.items())
    variance = squares / count**2 * groups / (groups - 1)
    return float(count) if variance <= 0 else max(1.0, min(float(count), share * (1 - share) / variance))


def paired_test(pairs: Iterable[tuple[object, bool, bool]]) -> PairedTest:
    """Whether the first answerer has more successes than the second in the same scenes, beyond chance.

    Under the hypothesis that both are alike within each cluster, the sign of a cluster's difference is a fair coin;
    the test has the exact distribution of the sum over all signs. With one pair a cluster it is McNemar's exact test.
    The interval of the difference is Student's over the clusters' differences.

    Source: Q. McNemar, Psychometrika 12 (1947) 153–157; the permutation of signs: R. A. Fisher, The Design of
    Experiments (1935), section 21; by clusters: N. A. Obuchowski, Statistics in Medicine 17 (1998) 1495–1507.

    Args:
        pairs: The cluster of each pair, and whether the first and the second have a success.
    """
    sums, sizes = Counter[object](), Counter[object]()
    count = wins = losses = 0
    for cluster, first, second in pairs:
        count += 1
        sizes[cluster] += 1
        sums[cluster] += int(first) - int(second)
        wins += first and not second
        losses += second and not first
    if not count:
        return PairedTest(math.nan, -1.0, 1.0, 1.0, 0, 0, 0, 0)
    difference = (wins - losses) / count
    low, high = _difference_interval(difference, sums, sizes)
    p = _sign_flip_p([abs(each) for each in sums.values() if each], abs(wins - losses))
    return PairedTest(difference, low, high, p, count, len(sums), wins, losses)


def _difference_interval(
    difference: float, sums: Mapping[object, int], sizes: Mapping[object, int]
) -> tuple[float, float]:
    groups, count = len(sums), sum(sizes.values())
    if groups < 2:
        return -1.0, 1.0
    squares = math.fsum((each - difference * sizes[cluster]) ** 2 for cluster, each in sums.items())
    error = math.sqrt(squares * groups / (groups - 1)) / count
    reach = student_quantile((1 + CONFIDENCE) / 2, groups - 1) * error
    return max(-1.0, difference - reach), min(1.0, difference + reach)


def _sign_flip_p(sizes: Sequence[int], seen: int) -> float:
    """The chance that a sum of these numbers, each with a fair coin's sign, is as far from 0 as `seen`."""
    if not sizes or not seen:
        return 1.0
    if sum(sizes) * len(set(sizes)) > LARGEST_EXACT:
        return min(1.0, math.erfc(seen / math.sqrt(2 * sum(each * each for each in sizes))))
    chances = {0: 1.0}
    for size, times in sorted(Counter(sizes).items()):
        chances = _added(chances, size, times)
    return min(1.0, math.fsum(chance for total, chance in chances.items() if abs(total) >= seen))


def _added(chances: Mapping[int, float], size: int, times: int) -> dict[int, float]:
    """A distribution with `times` coins of ±size more."""
    halves = -times * math.log(2)
    coins = {
        size * (2 * heads - times): math.exp(
            math.lgamma(times + 1) - math.lgamma(heads + 1) - math.lgamma(times - heads + 1) + halves
        )
        for heads in range(times + 1)
    }
    found: dict[int, float] = {}
    for before, chance in chances.items():
        for step, more in coins.items():
            found[before + step] = found.get(before + step, 0.0) + chance * more
    return found


def holm(values: Sequence[float]) -> tuple[float, ...]:
    """p values as they are where this many are tested together, in the same order.

    By them the chance of one false alarm or more among all of them stays at the level.

    Source: S. Holm, "A simple sequentially rejective multiple test procedure", Scandinavian Journal of Statistics 6
    (1979) 65–70.
    """
    order = sorted(range(len(values)), key=lambda index: values[index])
    adjusted, highest = [1.0] * len(values), 0.0
    for rank, index in enumerate(order):
        highest = max(highest, min(1.0, (len(values) - rank) * values[index]))
        adjusted[index] = highest
    return tuple(adjusted)


def student_quantile(probability: float, freedom: int) -> float:
    """The quantile of Student's t, right to 0.001 for 3 degrees of freedom and better for more; exact for 1 and 2.

    Source: G. W. Hill, "Algorithm 396: Student's t-quantiles", Communications of the ACM 13 (1970) 619–620.

    Args:
        probability: Above 0.5 and below 1.
        freedom: Degrees of freedom, 1 or more.
    """
    tails = 2 * (1 - probability)
    if freedom == 1:
        return 1 / math.tan(tails * math.pi / 2)
    if freedom == 2:
        return math.sqrt(2 / (tails * (2 - tails)) - 2)
    n = float(freedom)
    a = 1 / (n - 0.5)
    b = 48 / a**2
    c = ((20_700 * a / b - 98) * a - 16) * a + 96.36
    d = ((94.5 / (b + c) - 3) / b + 1) * math.sqrt(a * math.pi / 2) * n
    y = (d * tails) ** (2 / n)
    if y > a + 0.05:
        x = NormalDist().inv_cdf(tails / 2)
        y = x * x
        if freedom < 5:
            c += 0.3 * (n - 4.5) * (x + 0.6)
        c = (((0.05 * d * x - 5) * x - 7) * x - 2) * x + b + c
        y = (((((0.4 * y + 6.3) * y + 36) * y + 94.5) / c - y - 3) / b + 1) * x
        y = math.expm1(a * y * y)
    else:
        y = ((1 / (((n + 6) / (n * y) - 0.089 * d - 0.822) * (n + 2) * 3) + 0.5 / (n + 4)) * y - 1) * (n + 1) / (
            n + 2
        ) + 1 / y
    return math.sqrt(n * y)
