# SPDX-License-Identifier: Apache-2.0
"""The figures of a campaign as Markdown, for a pull request or a page of documents.

Rule: names from the store are shown as code, each character that could mean more by its number.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rai_missions.campaign.report.comparisons import LEVEL, Comparison
from rai_missions.campaign.report.figures import CampaignFigures, GroupFigures
from rai_missions.errors import counted
from visualize.campaign_page.plots import at_most, chance, lasting, percent, span
from visualize.diff.markdown import quoted

__all__ = ("markdown",)


def markdown(figures: CampaignFigures, comparisons: Sequence[Comparison], *, name: str) -> bytes:
    """The file."""
    return ("\n".join(_lines(figures, comparisons, name)) + "\n").encode("utf-8", "replace")


def _lines(figures: CampaignFigures, comparisons: Sequence[Comparison], name: str) -> Iterator[str]:
    seeds = len({scene.seed for scene in figures.scenes.values()})
    yield from (f"### Campaign {quoted(name)}", "")
    left = f", {left} of them without a cell yet" if (left := len(figures.scenes) - figures.reached) else ""
    split = quoted(figures.split)
    scenes = f"{counted(len(figures.scenes), 'scene')} of {counted(seeds, 'seed')}"
    yield f"{scenes} (split {split}){left}; shares with 95 % intervals."
    yield from (
        "",
        "| model | embodiment | mission | best | 95 % | harm | harm past the guard | named most "
        "| median | tokens a cell | answered | no answer | failed |",
        "|" + " --- |" * 13,
    )
    yield from map(_group, figures.groups)
    for each in figures.baselines:
        yield (
            f"| {quoted(each.name)} | | | {percent(each.accuracy.share)} | {span(each.accuracy)}"
            f" | {percent(each.harm.share)} | | | | | | | |"
        )
    better = [each for each in comparisons if each.is_significant]
    yield from (
        "",
        f"{len(better)} of {len(comparisons)} comparisons are significant (paired in the same scenes,"
        f" clustered by seed, Holm at {LEVEL:g}); the others are noise.",
        "",
    )
    if better:
        yield from ("| first | second | of | points | 95 % | p |", "|" + " --- |" * 6)
    yield from map(_comparison, better)


def _comparison(found: Comparison) -> str:
    test = found.test
    interval = f"{100 * test.low:+.1f} – {100 * test.high:+.1f}"
    names = f"{quoted(found.first)} | {quoted(found.second)} | {found.measure}"
    return f"| {names} | {100 * test.difference:+.1f} | {interval} | {chance(found.adjusted)} |"


def _group(group: GroupFigures) -> str:
    option, share = group.collapse
    asked = max(1, len(group.latencies))
    cells = [
        *map(quoted, (group.name.model, group.name.embodiment, group.name.mission)),
        percent(group.accuracy.share),
        span(group.accuracy),
        percent(group.harm.share),
        at_most(group.harm_past_guard),
        f"{quoted(option) or 'none'} {percent(share)}",
        lasting(group.latency.median),
        f"{(group.prompt_tokens + group.completion_tokens) / asked:.0f}",
        *(str(group.status[word]) for word in ("answered", "no_answer", "failed")),
    ]
    return f"| {' | '.join(cells)} |"
