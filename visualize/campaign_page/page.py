# SPDX-License-Identifier: Apache-2.0
"""The report of a campaign as one HTML file: figures as markup, wrong answers as data for a script.

Rule: the page asks no address for anything, and its figures are there without a script.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rai_missions.campaign.report.comparisons import Comparison
from rai_missions.campaign.report.figures import CampaignFigures
from rai_missions.campaign.report.scene_pictures import ScenePicture
from rai_missions.campaign.report.wrong_answers import WrongAnswers
from rai_missions.redaction import cut
from visualize.campaign_page.answers import answers_data
from visualize.campaign_page.markup import Markup, node, written
from visualize.campaign_page.sections import sections
from visualize.page.html import assembled, asset, bundle

__all__ = ("report_page",)

ASSETS = Path(__file__).parent / "assets"
META = 4_000
"""Characters of one note about the campaign."""


def report_page(
    figures: CampaignFigures,
    comparisons: Sequence[Comparison],
    wrong: WrongAnswers,
    pictures: Mapping[str, tuple[ScenePicture, ...]],
    meta: Mapping[str, Any],
    *,
    name: str,
) -> bytes:
    """The page.

    Args:
        figures: The figures of the store.
        comparisons: What differs beyond chance.
        wrong: The wrong answers.
        pictures: The pictures of their scenes.
        meta: What the store notes about the campaign.
        name: The name of the campaign.
    """
    body = written(
        [node("h1", None, f"Campaign {name}"), *sections(figures, comparisons), *_answers(wrong), _notes(meta)]
    )
    return assembled(
        asset("report.html", ASSETS),
        answers_data(wrong, figures, pictures),
        title=f"campaign {name}",
        style=asset("page.css") + asset("report.css", ASSETS),
        script=bundle(["dom.js"], [asset("report.js", ASSETS)]),
        body=body,
    )


def _answers(wrong: WrongAnswers) -> Iterator[Markup]:
    left_out = [f"{kind}: {shown} of {count}" for kind, (shown, count) in wrong.by_kind.items() if shown < count]
    about = f"{wrong.total} wrong answers" + (
        f"; {len(wrong.shown)} are here, a sample by kind, and all of them are in the CSV ({', '.join(left_out)})"
        if left_out
        else ", all of them here"
    )
    yield node(
        "section",
        {"id": "wrong"},
        node("h2", None, "Wrong answers"),
        node("p", {"class": "muted"}, about + "."),
        node("form", {"id": "filters", "aria-label": "which wrong answers are shown"}),
        node("p", {"id": "found", "role": "status"}),
        node("div", {"id": "answers"}),
        node("button", {"id": "more", "type": "button", "hidden": True}, "show more"),
    )


def _notes(meta: Mapping[str, Any]) -> Markup:
    lines = [
        (node("dt", None, cut(key, 200)), node("dd", None, node("code", None, cut(json.dumps(value), META))))
        for key, value in sorted(meta.items())
    ]
    return node("section", {"id": "notes"}, node("h2", None, "The run"), node("dl", None, lines))
