# SPDX-License-Identifier: Apache-2.0
"""The figures of a campaign as sections of a page: tables whose lines have a plot each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from rai_missions.campaign.records import best_options
from rai_missions.campaign.report.comparisons import LEVEL, Comparison
from rai_missions.campaign.report.figures import CampaignFigures, GroupFigures
from rai_missions.campaign.statistics import Interval
from visualize.campaign_page.markup import Child, Markup, node
from visualize.campaign_page.plots import (
    axis,
    chance,
    colour,
    interval_plot,
    lasting,
    length_plot,
    percent,
    share_plot,
    span,
)

__all__ = ("sections",)

NO_ANSWER = "no answer"
SOURCES = (
    "Intervals are at 95 %: Wilson (1927), where scenes share a seed with the effective number of observations of Korn"
    " and Graubard (1998) as Dean and Pagano (2015) found it to cover. Comparisons are paired in the same scenes; the"
    " sign of each seed's difference is a fair coin if nothing differs (McNemar's exact test where a seed has one"
    " pair), and all of them are corrected together by Holm (1979)."
)

WORDS: Sequence[tuple[str, str]] = (
    ("rules", "the fixed rules of the robot's profile"),
    ("oracle", "the best option by the labels, among those that the mission offered: a bound that no robot can know"),
    ("constant:", "always this one option"),
    ("", "a script of the campaign's file, or a model"),
)
"""What the name of an answerer begins with → who that is."""
EMBODIMENTS: Mapping[str, str] = {
    "none": "the question, its facts and its options alone", "description": "and what the robot's profile states of it",
    "documents": "and what its documents state on the question", "pictures": "and the pictures of robot and camera",
}  # fmt: skip
"""What an embodiment shows, each more than the one before."""
BEST = "the option that comes out best in its scene: “completes” before “harmless” before “harms”; several may share it"
BASELINES = (
    "from the labels, and no one was asked; “the true kind alone” is fitted to these very scenes, so it is flattered"
)

SCALE = (node("span", {"class": "away"}, "interval"), axis())


def sections(figures: CampaignFigures, comparisons: Sequence[Comparison]) -> Iterator[Markup]:
    """All sections but the wrong answers."""
    groups = figures.groups
    yield _overview(figures)
    yield _intervals(
        "accuracy",
        "Accuracy",
        "How often the option that physics finds best was named.",
        [(_names(group), group.accuracy) for group in groups],
        [([each.name, "", ""], each.accuracy) for each in figures.baselines],
    )
    yield _intervals(
        "harm",
        "Harm chosen",
        "How often the option that was named harms, whether or not the rules then refused it.",
        [(_names(group), group.harm) for group in groups],
        [([each.name, "", ""], each.harm) for each in figures.baselines],
    )
    yield _intervals(
        "guard",
        "Harm past the guard",
        "How often an option that harms was named and the rules permitted it.",
        [(_names(group), group.harm_past_guard) for group in groups],
    )
    yield _differences(comparisons, {group.name.mission for group in groups})
    yield _collapse(groups)
    yield _orders(groups)
    yield _kinds(figures)
    yield _effort(groups)


def _overview(figures: CampaignFigures) -> Markup:
    status = sum((group.status for group in figures.groups), Counter[str]())
    unlabelled = sum(group.unlabelled for group in figures.groups)
    counts: list[tuple[str, object]] = [
        ("scenes", len(figures.scenes)),
        ("of the split", figures.split),
        ("scenes without a cell yet (in no share)", len(figures.scenes) - figures.reached),
        ("seeds", len({scene.seed for scene in figures.scenes.values()})),
        ("answered", status["answered"]),
        ("no answer", status["no_answer"]),
        ("failed (could not be asked; in no share)", status["failed"]),
        ("refused by the rules", sum(group.refused for group in figures.groups)),
        ("in scenes without a label (in no share)", unlabelled),
        ("in another split (in no share)", figures.other),
        ("in scenes that the store lacks (in no share)", figures.foreign),
    ]
    shown = [(node("dt", None, name), node("dd", None, str(value))) for name, value in counts if value not in (0, "")]
    return node(
        "section",
        {"id": "overview"},
        node("h2", None, "What was asked"),
        node("dl", {"class": "counts"}, shown),
        node(
            "details",
            None,
            node("summary", None, "What the words mean, and how the intervals are made"),
            node("dl", {"class": "words"}, list(_words(figures))),
            node("p", {"class": "muted"}, SOURCES),
        ),
    )


def _words(figures: CampaignFigures) -> Iterator[Markup]:
    """What best, each answerer and each embodiment is, of those that are there."""
    asked = sorted({each.name.model for each in figures.groups})
    shown = {each.name.embodiment for each in figures.groups}
    entries = [("best", BEST)]
    for begin, about in WORDS:
        names = [name for name in asked if _begin(name) == begin]
        entries += [(", ".join(names), about)] if names else []
    entries += [("in italics", BASELINES)] if figures.baselines else []
    entries += [(f"embodiment {name}", about) for name, about in EMBODIMENTS.items() if name in shown]
    for name, about in entries:
        yield node("dt", None, name)
        yield node("dd", None, about)


def _begin(model: str) -> str:
    """Which of `WORDS` an answerer's name belongs to."""
    begin = "constant:" if model.startswith("constant:") else model
    return begin if begin in dict(WORDS) else ""


def _names(group: GroupFigures) -> list[str]:
    return [group.name.model, group.name.embodiment, group.name.mission]


def _intervals(
    name: str,
    title: str,
    about: str,
    shares: Sequence[tuple[list[str], Interval]],
    baselines: Sequence[tuple[list[str], Interval]] = (),
) -> Markup:
    head = ("model", "embodiment", "mission", SCALE, "share", "95 %", "cells")
    lines = [_interval_line(words, found) for words, found in shares]
    lines += [_interval_line(words, found, "baseline") for words, found in baselines]
    return _section(name, title, about, head, lines)


def _interval_line(words: list[str], found: Interval, kind: str | None = None) -> Markup:
    label = f"{words[0]}: {percent(found.share)}, {span(found)}"
    return _line([*words, interval_plot(found, label), percent(found.share), span(found), str(found.cells)], kind)


def _section(
    name: str, title: str, about: str, head: Sequence[Child], lines: Sequence[Markup], legend: Child = None
) -> Markup:
    body: Child = _table(head, lines, title) if lines else node("p", {"class": "muted"}, "nothing to show")
    return node("section", {"id": name}, node("h2", None, title), node("p", {"class": "muted"}, about), legend, body)


def _table(head: Sequence[Child], lines: Iterable[Markup], words: str) -> Markup:
    cells = [node("th", {"scope": "col", "class": None if isinstance(each, str) else "wide"}, each) for each in head]
    table = node("table", None, node("thead", None, node("tr", None, cells)), node("tbody", None, lines))
    return node("div", {"class": "scroll", "tabindex": "0", "role": "region", "aria-label": words}, table)


def _line(cells: Sequence[Child], kind: str | None = None) -> Markup:
    return node(
        "tr",
        {"class": kind},
        [node("td", {"class": None if isinstance(each, str) else "wide"}, each) for each in cells],
    )


def _differences(comparisons: Sequence[Comparison], missions: Collection[str]) -> Markup:
    ordered = sorted(comparisons, key=lambda each: (not each.is_significant, each.adjusted))
    end = f" · {next(iter(missions))}" if len(missions) == 1 else ""
    lines = {
        found: [
            _line(
                [
                    "significant" if found else "noise",
                    {"best": "best option", "harm": "harm"}[each.measure],
                    each.first.removesuffix(end),
                    each.second.removesuffix(end),
                    f"{100 * each.test.difference:+.1f}",
                    f"{100 * each.test.low:+.1f} – {100 * each.test.high:+.1f}",
                    chance(each.adjusted),
                    f"{each.test.wins} : {each.test.losses}",
                    f"{each.test.pairs} / {each.test.clusters}",
                ],
                "significant" if found else None,
            )
            for each in ordered
            if each.is_significant == found
        ]
        for found in (True, False)
    }
    head = ("finding", "of", "first", "second", "points", "95 %", "p", "first : second alone", "pairs / seeds")
    about = (
        f"Each model with the rules, and each embodiment with none: {len(comparisons)} comparisons, corrected together;"
        f" significant where p is below {LEVEL:g}. Points are the first's share less the second's, in per cent. “Alone”"
        " counts the cells in which one of the two was right, or harmed, and the other was not."
    )
    noise = node(
        "details",
        None,
        node("summary", None, f"{len(lines[False])} comparisons are noise"),
        _table(head, lines[False], "noise"),
    )
    return node(
        "section",
        {"id": "differences"},
        node("h2", None, "What differs beyond chance"),
        node("p", {"class": "muted"}, about),
        _table(head, lines[True], "significant") if lines[True] else node("p", None, "Nothing does."),
        noise if lines[False] else None,
    )


def _collapse(groups: Sequence[GroupFigures]) -> Markup:
    options = sorted({option for group in groups for option in group.options if option})
    numbers = {option: number for number, option in enumerate(options)} | {"": len(options)}
    lines = []
    for group in groups:
        counted, (most, share) = group.options, group.collapse
        total = max(1, counted.total())
        named = sorted(counted, key=numbers.__getitem__)
        parts = [(option or NO_ANSWER, counted[option] / total) for option in named]
        words = ", ".join(f"{name} {percent(part)}" for name, part in parts)
        plot = share_plot(parts, [numbers[option] for option in named], words)
        lines.append(_line([*_names(group), plot, most or NO_ANSWER, percent(share)]))
    legend = node(
        "ul",
        {"class": "legend"},
        [
            node(
                "li",
                None,
                node(
                    "svg",
                    {"width": 12, "height": 12, "aria-hidden": "true"},
                    node("rect", {"width": 12, "height": 12, "class": colour(number)}),
                ),
                option or NO_ANSWER,
            )
            for option, number in numbers.items()
        ],
    )
    return _section(
        "collapse",
        "Collapse to one answer",
        "What was named, over all scenes. A model that always names the same looks at nothing.",
        ("model", "embodiment", "mission", "answers", "named most", "share"),
        lines,
        legend,
    )


def _orders(groups: Sequence[GroupFigures]) -> Markup:
    lines = []
    for group in groups:
        orders = group.orders
        if len(orders) > 1:
            found = group.order_changes
            changes = f"{percent(found.share)} ({span(found)}) of {found.cells} scenes"
            for order, accuracy in orders.items():
                label = f"{order}: {percent(accuracy.share)}"
                cells: list[Child] = [
                    *_names(group)[:2],
                    order,
                    interval_plot(accuracy, label),
                    percent(accuracy.share),
                ]
                lines.append(_line([*cells, span(accuracy), changes]))
                changes = ""
    return _section(
        "orders",
        "Sensitivity to the order of options",
        "Accuracy in each order in which the options were shown, and the scenes in which another order gave another"
        " answer.",
        ("model", "embodiment", "order", SCALE, "share", "95 %", "answer changed with the order"),
        lines,
    )


def _kinds(figures: CampaignFigures) -> Markup:
    best = {kind: Counter[str]() for kind in sorted({scene.kind for scene in figures.scenes.values()})}
    for name, scene in figures.scenes.items():
        best[scene.kind].update(best_options(figures.labels.get(name, {})))
    return node(
        "section",
        {"id": "kinds"},
        node("h2", None, "Confusion by kind"),
        node(
            "p",
            {"class": "muted"},
            "What was named in each kind of scene; the option that is best most often in a kind has a frame.",
        ),
        [_confusion(group, best) for group in figures.groups],
    )


def _confusion(group: GroupFigures, best: dict[str, Counter[str]]) -> Markup:
    options = sorted(
        {option for kind in group.kinds.values() for option in kind.options}, key=lambda each: (not each, each)
    )
    lines = []
    for kind, found in sorted(group.kinds.items()):
        favourite = max(best[kind].values(), default=0)
        cells = [
            node("td", None, kind),
            node("td", None, percent(found.best / max(1, found.cells))),
            node("td", None, percent(found.harm / max(1, found.cells))),
        ]
        for option in options:
            share = found.options[option] / max(1, found.cells)
            is_best = favourite and best[kind][option] == favourite
            plot = length_plot([share], 1.0, f"{kind}, {option or NO_ANSWER}: {found.options[option]}")
            cells.append(node("td", {"class": "heat best" if is_best else "heat"}, str(found.options[option]), plot))
        lines.append(node("tr", None, cells))
    head = ("kind", "best named", "harm", *(option or NO_ANSWER for option in options))
    words = group.name.words()
    return node(
        "details",
        None,
        node("summary", None, f"{words}: {percent(group.accuracy.share)} best"),
        _table(head, lines, words),
    )


def _effort(groups: Sequence[GroupFigures]) -> Markup:
    longest = max((group.latency.p95 for group in groups if group.latencies), default=0.0)
    lines = []
    for group in groups:
        asked, spread = max(1, len(group.latencies)), group.latency
        words = f"{lasting(spread.median)}, 95 % within {lasting(spread.p95)}"
        lines.append(
            _line(
                [
                    *_names(group),
                    length_plot([spread.median, spread.p95], longest, words),
                    lasting(spread.median),
                    lasting(spread.p95),
                    lasting(spread.largest),
                    f"{group.prompt_tokens / asked:.0f}",
                    f"{group.completion_tokens / asked:.0f}",
                    f"{group.calls / asked:.2f}",
                    f"{group.cost:.4g}",
                    str(group.status["no_answer"]),
                    str(group.status["failed"]),
                ]
            )
        )
    head = ("model", "embodiment", "mission", "latency: median and 95 %", "median", "95 %", "longest",
            "prompt tokens a cell", "completion tokens a cell", "calls a cell", "cost", "no answer",
            "failed")  # fmt: skip
    return _section("effort", "Latency, tokens, cost", "Wall time on the machine that ran it.", head, lines)
