# SPDX-License-Identifier: Apache-2.0
"""Pictures as files, by their ending.

Rule: a file is whole or it is not there: it is written next to its place and then renamed.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rai_missions.engine.step import Step
from rai_missions.errors import UsageError, raised_text
from rai_missions.kinds import PackageOffer, known_names, offered
from rai_missions.mission.files import write_atomically
from rai_missions.mission.mission import Mission
from rai_missions.redaction import shown
from visualize.build import picture
from visualize.diff import Difference
from visualize.dot_text import dot_text
from visualize.graphviz import layout_program, render
from visualize.mermaid import mermaid
from visualize.model import Picture
from visualize.table import table

if TYPE_CHECKING:
    from visualize.page import Journal, PageFinding

__all__ = ("COMPARED", "FORMATS", "check_ending", "draw", "draw_difference", "draw_review", "drawn")

FORMATS: Mapping[str, Callable[[Picture], bytes]] = {
    "svg": lambda given: render(given, "svg"),
    "png": lambda given: render(given, "png"),
    "dot": lambda given: dot_text(given).encode(),
    "mmd": lambda given: mermaid(given).encode(),
    "mermaid": lambda given: mermaid(given).encode(),
    "md": lambda given: table(given).encode(),
}
"""A file's ending → the bytes of a picture."""
LAID_OUT = ("svg", "png")
"""The endings of what Graphviz lays out."""
EXPORTERS = "rai_missions.exporters"
"""Entry points of other packages: ending → what makes the bytes."""
PAGE = "html"
"""The ending of the review page, which is made of more than a picture."""
COMPARED = (PAGE, "md", "json", *(form for form in FORMATS if form != "md"))
"""The endings of a difference."""


def drawn(given: Picture, form: str) -> bytes:
    """A picture as the bytes of a file.

    Args:
        given: The picture.
        form: `svg`, `png`, `dot`, `mmd`, `mermaid` or `md`, with or without a dot before it.

    Raises:
        UsageError: There is no such form, or no Graphviz for it.
    """
    writer = _writer(form.removeprefix(".").lower())
    if writer is None:
        raise UsageError(f"pictures are not drawn as '{form}'; the endings are {_listed(FORMATS)}")
    return writer(given)


def _writer(form: str) -> Callable[[Picture], bytes] | None:
    """What makes the bytes of a picture: ours, or an installed package's; None where there is none for an ending."""
    if form in FORMATS:
        return FORMATS[form]
    offer = offered(EXPORTERS, form, {}) if form and form not in (PAGE, *COMPARED) else None
    return None if offer is None else partial(_exported, offer)


def _exported(offer: PackageOffer, given: Picture) -> bytes:
    """What a package's exporter makes of a picture.

    Raises:
        UsageError: It does not load, raises, or makes something else than bytes.
    """
    export = offer.load()
    try:
        made: object = export(given)
    except Exception as error:
        raise UsageError(f"{offer} failed ({raised_text(error)})") from error
    if not isinstance(made, bytes):
        raise UsageError(f"{offer} makes {shown(made)} of a picture; an exporter makes bytes")
    return made


def draw(mission: Mission, path: str | os.PathLike[str], steps: Iterable[Step] = ()) -> Path:
    """Draw a mission into a file, and the path that a run took in bold.

    Args:
        mission: The graph.
        path: The file; its ending decides how it is drawn. `.html` is the review page.
        steps: The steps of a run or a journal.

    Raises:
        UsageError: The ending is not known, the file cannot be written, or there is no Graphviz for it.
    """
    if _ending(path) != PAGE:
        return _write(path, (*FORMATS, PAGE), lambda form: drawn(picture(mission, steps), form))
    from visualize.page import review, run_of_steps  # the page's parts, when it is wanted

    steps = tuple(steps)
    return _write(path, (PAGE,), lambda _: review(mission, runs=(run_of_steps(steps),) if steps else ()))


def draw_review(
    mission: Mission,
    path: str | os.PathLike[str],
    journals: Iterable[Journal] = (),
    findings: Iterable[PageFinding] = (),
) -> Path:
    """Write the review page of a mission into an `.html` file.

    Args:
        mission: The graph.
        path: The file.
        journals: Of its runs; files, or pairs of a name and a file.
        findings: What a check found.

    Raises:
        UsageError: The ending is another, the file cannot be written, or a journal is not there.
        DefinitionError: A journal is of another mission, or none at all.
    """
    from visualize.page import review

    return _write(path, (PAGE,), lambda _: review(mission, journals, findings))


def draw_difference(given: Difference, path: str | os.PathLike[str]) -> Path:
    """Write what changed between two missions into a file.

    Args:
        given: What changed.
        path: The file. `.html` is a page with the picture of both and all that changed, `.md` the same for a comment,
            `.json` for programs (`visualize/diff/difference.schema.json`); other endings are pictures, what was added,
            removed and changed marked.

    Raises:
        UsageError: As `draw`.
    """
    return _write(path, COMPARED, lambda form: _compared(given, form))


def _compared(given: Difference, form: str) -> bytes:
    if form == PAGE:
        from visualize.diff.page import page

        return page(given)
    if form == "md":
        from visualize.diff.markdown import markdown

        return markdown(given)
    if form == "json":
        from visualize.diff.as_json import as_json

        return as_json(given)
    return drawn(given.picture, form)


def _ending(path: str | os.PathLike[str]) -> str:
    return Path(path).suffix.removeprefix(".").lower()


def check_ending(path: str | os.PathLike[str], endings: Iterable[str] = (*FORMATS, PAGE)) -> None:
    """Whether a file that is called so can be drawn on this machine.

    Raises:
        UsageError: Its ending is none of a picture, or needs Graphviz, which is missing.
    """
    ending, endings = _ending(path), tuple(endings)
    if ending not in endings and (FORMATS.keys().isdisjoint(endings) or _writer(ending) is None):
        raise UsageError(f"'{path}' does not end in a form of picture; the endings are {_listed(endings)}")
    if ending in LAID_OUT:
        layout_program()


def _listed(endings: Iterable[str]) -> str:
    """The endings that there are; with those of pictures also what installed packages make."""
    endings = tuple(endings)
    more = () if FORMATS.keys().isdisjoint(endings) else known_names(EXPORTERS, ())
    return ", ".join(f".{each}" for each in dict.fromkeys((*endings, *more)))


def _write(path: str | os.PathLike[str], endings: Iterable[str], made: Callable[[str], bytes]) -> Path:
    target, ending = Path(path), _ending(path)
    check_ending(path, endings)
    data = made(ending)
    try:
        write_atomically(target, data)
    except OSError as error:
        raise UsageError(f"'{target}' cannot be written: {error.strerror or error}; name another file") from None
    return target
