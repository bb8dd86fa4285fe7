# SPDX-License-Identifier: Apache-2.0
"""Intervals and tests: published figures, laws against a slow oracle, and how often they are wrong in simulation."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.campaign import statistics
from rai_missions.campaign.statistics import (
    Interval,
    clustered_interval,
    holm,
    paired_test,
    student_quantile,
    wilson,
)

PUBLISHED = [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)]
"""Newcombe 1998, table I, method 3."""
STUDENT = [
    (1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (5, 2.571), (6, 2.447), (8, 2.306), (10, 2.228), (15, 2.131),
    (20, 2.086), (30, 2.042), (60, 2.000), (120, 1.980),
]  # fmt: skip
"""Fisher and Yates, Statistical Tables, table III: two-sided 5 %."""
pair_lists = st.lists(st.tuples(st.integers(0, 5), st.booleans(), st.booleans()), max_size=9)


@pytest.mark.parametrize(("successes", "count", "low", "high"), PUBLISHED)
def test_wilsons_interval_is_the_published_one(successes: int, count: int, low: float, high: float) -> None:
    assert list(wilson(successes, count)) == pytest.approx([low, high], abs=5e-5)


@pytest.mark.parametrize(("freedom", "quantile"), STUDENT)
def test_students_quantiles_are_the_published_ones(freedom: int, quantile: float) -> None:
    assert student_quantile(0.975, freedom) == pytest.approx(quantile, abs=1e-3)


def test_holms_values_are_the_published_ones() -> None:
    # Holm's own example: p values of three tests at 5 %; and R's p.adjust of 0.01 to 0.05
    assert holm([0.01, 0.02, 0.03, 0.04, 0.05]) == pytest.approx((0.05, 0.08, 0.09, 0.09, 0.09))
    assert holm([0.03, 0.01, 0.02]) == pytest.approx((0.04, 0.03, 0.04))
    assert holm([]) == ()


def test_one_pair_a_cluster_is_mcnemars_exact_test() -> None:
    # Agresti, Categorical Data Analysis (2002), section 10.1: 86 against 150 discordant answers, z = −4.17
    pairs = [(n, True, False) for n in range(86)] + [(1000 + n, False, True) for n in range(150)]
    found = paired_test([*pairs, *((5000 + n, True, True) for n in range(794))])
    exact = 2 * sum(Fraction(_choose(236, k), 2**236) for k in range(87))
    assert found.p == pytest.approx(float(exact), rel=1e-9)
    assert (found.wins, found.losses, found.pairs) == (86, 150, 1030)
    assert found.low == pytest.approx(-0.091, abs=1e-3) and found.high == pytest.approx(-0.033, abs=1e-3)


def _choose(n: int, k: int) -> int:
    found = 1
    for step in range(k):
        found = found * (n - step) // (step + 1)
    return found


@given(pair_lists)
def test_the_p_value_is_the_share_of_signs_that_are_as_extreme(pairs: list[tuple[int, bool, bool]]) -> None:
    sums = {cluster: sum(a - b for each, a, b in pairs if each == cluster) for cluster, _, _ in pairs}
    signs = list(product((1, -1), repeat=len(sums)))
    seen = abs(sum(sums.values()))
    extreme = sum(abs(sum(s * d for s, d in zip(sign, sums.values(), strict=True))) >= seen for sign in signs)
    assert paired_test(pairs).p == pytest.approx(extreme / len(signs))


@given(pair_lists)
def test_a_comparison_the_other_way_round_is_the_same_with_the_other_sign(pairs: list[tuple[int, bool, bool]]) -> None:
    one, other = paired_test(pairs), paired_test([(cluster, b, a) for cluster, a, b in pairs])
    assert one.p == pytest.approx(other.p)
    assert (one.wins, one.losses) == (other.losses, other.wins)
    assert one.low == pytest.approx(-other.high)


@given(st.lists(st.floats(0, 1), max_size=30))
def test_holm_keeps_the_order_and_lowers_no_value(values: list[float]) -> None:
    adjusted = holm(values)
    assert all(after >= before for before, after in zip(values, adjusted, strict=True))
    ranked = sorted(zip(values, adjusted, strict=True))
    assert [p for _, p in ranked] == sorted(adjusted)


@given(st.integers(0, 60), st.integers(1, 60))
def test_an_interval_holds_its_share_and_mirrors(successes: int, count: int) -> None:
    successes = min(successes, count)
    low, high = wilson(successes, count)
    assert 0 <= low <= successes / count <= high <= 1
    assert list(wilson(count - successes, count)) == pytest.approx([1 - high, 1 - low])


@given(st.lists(st.booleans(), min_size=1, max_size=40), st.integers(2, 5))
def test_the_same_answer_given_several_times_is_no_more_evidence(outcomes: list[bool], times: int) -> None:
    once = clustered_interval(enumerate(outcomes))
    copied = clustered_interval([(n, outcome) for n, outcome in enumerate(outcomes) for _ in range(times)])
    assert copied.share == once.share and copied.cells == times * len(outcomes)
    assert copied.effective <= len(outcomes) + 1e-9
    assert copied.high - copied.low >= once.high - once.low - 1e-9


def test_without_cells_an_interval_is_all_there_is() -> None:
    nothing = clustered_interval([])
    assert (nothing.low, nothing.high, nothing.cells) == (0.0, 1.0, 0) and nothing.share != nothing.share
    assert paired_test([]).p == 1.0


def _clusters(chance: random.Random, groups: int, size: int, share: float) -> list[tuple[object, bool]]:
    """Clusters whose own shares vary about the share, as scenes of one seed do."""
    own = (chance.betavariate(3 * share, 3 * (1 - share)) for _ in range(groups))
    return [(group, chance.random() < each) for group, each in enumerate(own) for _ in range(size)]


@pytest.mark.parametrize("share", [0.5, 0.8, 0.95])
def test_the_interval_covers_the_share_in_nineteen_of_twenty_campaigns(share: float) -> None:
    chance = random.Random(1)
    found: list[Interval] = [clustered_interval(_clusters(chance, 40, 5, share)) for _ in range(400)]
    covered = sum(each.low <= share <= each.high for each in found) / len(found)
    blind = sum(_covers(each, share) for each in found) / len(found)
    assert covered >= 0.925  # 0.95 less 2.3 standard errors of 400 campaigns
    assert blind < 0.9, "as if the cells were independent, far fewer are: the simulation distinguishes the two"


def _covers(found: Interval, share: float) -> bool:
    low, high = wilson(found.share * found.cells, found.cells)
    return low <= share <= high


def test_two_equal_models_are_found_different_in_one_campaign_of_twenty_at_most() -> None:
    chance = random.Random(2)
    alarms = blind = 0
    for _ in range(400):
        pairs = list[tuple[object, bool, bool]]()
        for group in range(30):
            first, second = chance.betavariate(1, 1), chance.betavariate(1, 1)
            pairs += [(group, chance.random() < first, chance.random() < second) for _ in range(6)]
        alarms += paired_test(pairs).p < 0.05
        blind += paired_test((number, a, b) for number, (_, a, b) in enumerate(pairs)).p < 0.05
    assert alarms / 400 <= 0.0745  # 0.05 and 2.3 standard errors
    assert blind / 400 > 0.1, "without clusters the same test raises many false alarms"


def test_a_difference_that_is_there_is_found() -> None:
    chance = random.Random(3)
    pairs = [(group, chance.random() < 0.8, chance.random() < 0.6) for group in range(200) for _ in range(2)]
    found = paired_test(pairs)
    assert found.p < 0.001 and found.low > 0


def test_many_clusters_give_the_normal_distributions_value(monkeypatch: pytest.MonkeyPatch) -> None:
    pairs = [(n, n % 3 == 0, n % 3 != 0) for n in range(300)]
    exact = paired_test(pairs)
    monkeypatch.setattr(statistics, "LARGEST_EXACT", 0)
    assert exact.p == pytest.approx(7.6e-9, rel=0.1)  # 100 against 200: z = 5.77
    assert paired_test(pairs).p == pytest.approx(exact.p, rel=0.1)
