# SPDX-License-Identifier: Apache-2.0
"""`rai-missions whoami`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from rai_missions.cli.command import Argument, command

if TYPE_CHECKING:
    from pathlib import Path

    from rai_missions.embodiment import Library

__all__ = ("whoami",)


@command()
def whoami(
    subcommand: Literal["build", "ask", "show"],
    folder: Annotated[str, Argument("FOLDER")],
    question: Annotated[str, Argument("QUESTION")] = "",
    *,
    index: Annotated[str | None, Argument("FILE", files=("*",))] = None,
    count: Annotated[int, Argument("N")] = 5,
) -> int:
    """Look up what a robot's own documents state: its identity folder, searched by words and by meaning.

    The folder has a description.md, pictures, a URDF and documents (md, txt, html, pdf, docx). Nothing is fetched from
    the network, and no link is followed out of the folder.

    Args:
        subcommand: build: bring the index up to date; ask: quote what the documents have on a question; show: what the
            folder holds, and what is missing to read or search it.
        folder: The identity folder.
        question: For ask: in free words, in the language of the documents.
        index: The index; without it: a file in the user's cache.
        count: For ask: passages at most, 1 to 20.

    Exit status:
        0 it was done or answered, 1 the documents have no answer, 2 the input is at fault

    Example:
        rai-missions whoami build missions/tractor/identity
    """
    from pathlib import Path

    from rai_missions.embodiment import Library
    from rai_missions.embodiment.library import MOST
    from rai_missions.errors import UsageError

    if (subcommand == "ask") != bool(question.strip()):
        raise UsageError("a QUESTION is for ask, and ask needs one: rai-missions whoami ask FOLDER QUESTION")
    if not 1 <= count <= MOST:
        raise UsageError(f"--count is how many passages are given, 1 to {MOST}, not {count}")
    library = Library(Path(folder), Path(index) if index is not None else None)
    if subcommand == "build":
        return _build(library)
    return _ask(library, question, count) if subcommand == "ask" else _show(library, Path(folder))


def _build(library: Library) -> int:
    import sys

    from rai_missions.cli.inputs import warn
    from rai_missions.embodiment import Identity
    from rai_missions.embodiment.readers import FORMATS
    from rai_missions.errors import DefinitionError, Fault, counted

    report, faults = library.build(), tuple[Fault, ...]()
    try:
        Identity.read(library.folder)
    except DefinitionError as error:
        faults = error.faults
    faults = tuple(dict.fromkeys((*report.faults, *faults)))
    for fault in faults:
        print(f"{library.folder}: {fault}", file=sys.stderr)
    for name in report.read:
        print(f"read {name}")
    if report.others:
        warn(f"not read: {', '.join(report.others[:10])}; documents end in {', '.join(sorted(FORMATS))}")
    read = f"{counted(report.documents, 'document')}, {counted(report.passages, 'passage')}"
    print(f"{read}, {report.embedded} embedded now: {library.index}")
    _warn_of_words_alone(report.has_vectors)
    return 2 if faults else 0


def _ask(library: Library, question: str, count: int) -> int:
    from rai_missions.cli.inputs import warn
    from rai_missions.embodiment.folder import DESCRIPTION

    if library.folder.is_dir() and not (library.folder / DESCRIPTION).exists():
        warn(
            f"{library.folder} has no {DESCRIPTION}, so a run takes it for no identity; all its documents are searched"
        )
    found = library.recall(question, count)
    _warn_of_words_alone(found.is_by_meaning)
    print(found.words())
    return 0 if found.is_answered else 1


def _show(library: Library, folder: Path) -> int:
    from rai_missions.embodiment import Identity
    from rai_missions.embodiment.index import IndexReader
    from rai_missions.embodiment.minilm import why_no_vectors
    from rai_missions.errors import counted

    identity = Identity.read(folder)
    print(identity.words())
    print(f"Pictures: {', '.join(image.ref for image in identity.images) or 'none'}.")
    library.open()
    with IndexReader(library.index) as reader:
        for each in reader.documents():
            print(f"{each.name}: {each.fault or counted(len(reader.passages(each.name)), 'passage')}")
    print(f"Index: {library.index}")
    print(why_no_vectors() or "Searched by words and by meaning.")
    return 0


def _warn_of_words_alone(has_vectors: bool) -> None:
    from rai_missions.cli.inputs import warn
    from rai_missions.embodiment.minilm import why_no_vectors

    warn("" if has_vectors else f"searched by words alone: {why_no_vectors() or 'build the index again'}")
