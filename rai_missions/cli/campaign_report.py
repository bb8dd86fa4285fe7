# SPDX-License-Identifier: Apache-2.0
"""The report of a store as files: HTML, and next to it Markdown and CSV of the same name."""

from __future__ import annotations

from pathlib import Path

from rai_missions.campaign.report.comparisons import within
from rai_missions.campaign.report.figures import figures_of
from rai_missions.campaign.report.scene_pictures import pictures_of
from rai_missions.campaign.report.table import COLUMNS, write_table
from rai_missions.campaign.report.wrong_answers import wrong_answers
from rai_missions.campaign.store import ResultStore
from rai_missions.errors import UsageError, irregular, make_folder_of
from rai_missions.redaction import shown

__all__ = ("report_files", "write_report")

BEGINNINGS = {
    ".html": b'<!DOCTYPE html>\n<html lang="en" class="report">',
    ".md": b"### Campaign ",
    ".csv": f"{COLUMNS[0]},".encode(),
}
"""Ending → how such a file of a report begins."""


def report_files(html: Path | str) -> tuple[Path, ...]:
    """The page of a report and its neighbours, where they may be written: they replace an earlier report alone.

    Raises:
        UsageError: The page has another ending, or a file that is no report would be replaced.
    """
    page = Path(html)
    if page.suffix != ".html":
        raise UsageError(
            f"a report is an HTML file with .md and .csv next to it, not {shown(page.name)}; name it .html"
        )
    files = tuple(page.with_suffix(ending) for ending in BEGINNINGS)
    for file in files:
        if sort := irregular(file) or ("" if _is_ours(file) else "no report"):
            raise UsageError(f"{file} is {sort}, and stays as it is; name another file with --report, or delete it")
    return files


def _is_ours(file: Path) -> bool:
    """Whether a report may be put there: no file has content there, or it begins as a report does."""
    beginning = BEGINNINGS[file.suffix]
    try:
        with file.open("rb") as opened:
            return opened.read(len(beginning)) in (b"", beginning)
    except OSError:
        return True  # missing, or what cannot be replaced


def write_report(store: Path | str, html: Path | str) -> tuple[Path, ...]:
    """Write the report of a store.

    Args:
        store: The file of results; it is not changed.
        html: The page; its neighbours end in `.md` and `.csv`.

    Returns:
        The files.

    Raises:
        UsageError: There are no results at that path, or a file cannot be written; as `report_files`.
    """
    from visualize.campaign_page import markdown, report_page

    page, listed, table = files = report_files(html)
    with ResultStore(store) as results:
        figures, meta = figures_of(results), results.meta
        comparisons, wrong = within(figures.groups), wrong_answers(results, figures)
        pictures = pictures_of(results, (each.cell.scene for each in wrong.shown))
        name = str(meta.get("name") or Path(store).stem)
        try:
            make_folder_of(page)
            page.write_bytes(report_page(figures, comparisons, wrong, pictures, meta, name=name))
            listed.write_bytes(markdown(figures, comparisons, name=name))
            write_table(results, figures, table)
        except OSError as error:
            raise UsageError(f"the report cannot be written at {page}: {error.strerror}; name another file") from None
    return files
