# SPDX-License-Identifier: Apache-2.0
"""The report of a store as files: HTML, and next to it Markdown and CSV of the same name."""

from __future__ import annotations

from pathlib import Path

from rai_missions.campaign.report.comparisons import within
from rai_missions.campaign.report.figures import figures_of
from rai_missions.campaign.report.scene_pictures import pictures_of
from rai_missions.campaign.report.table import write_table
from rai_missions.campaign.report.wrong_answers import wrong_answers
from rai_missions.campaign.store import ResultStore
from rai_missions.errors import UsageError

__all__ = ("write_report",)


def write_report(store: Path | str, html: Path | str) -> tuple[Path, ...]:
    """Write the report of a store.

    Args:
        store: The file of results; it is not changed.
        html: The page; its neighbours end in `.md` and `.csv`.

    Returns:
        The files.

    Raises:
        UsageError: There are no results at that path, or a file cannot be written.
    """
    from visualize.campaign_page import markdown, report_page

    page = Path(html)
    files = (page, page.with_suffix(".md"), page.with_suffix(".csv"))
    if len(set(files)) < len(files):
        raise UsageError(f"the report {page} has the ending of one of its neighbours; name it .html")
    with ResultStore(store) as results:
        figures, meta = figures_of(results), results.meta
        comparisons, wrong = within(figures.groups), wrong_answers(results, figures)
        pictures = pictures_of(results, (each.cell.scene for each in wrong.shown))
        name = str(meta.get("name") or Path(store).stem)
        try:
            page.write_bytes(report_page(figures, comparisons, wrong, pictures, meta, name=name))
            files[1].write_bytes(markdown(figures, comparisons, name=name))
            write_table(results, figures, files[2])
        except OSError as error:
            raise UsageError(f"the report cannot be written at {page}: {error.strerror}; name another file") from None
    return files
