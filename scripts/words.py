# SPDX-License-Identifier: Apache-2.0
"""Holds the words of `scripts/words.toml` out of documents, docstrings, comments, messages and names.

`python scripts/words.py` shows each finding in the project, or in the paths that it is given.
Exit status: 0 none, 1 some.
"""

from __future__ import annotations

import argparse
import io
import re
import sys
import tokenize
import tomllib
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import cached_property
from pathlib import Path
from typing import Any

__all__ = ("Finding", "Sense", "Word", "WordList", "findings_in", "read_words")

ROOT = Path(__file__).parents[1]
WORDS = "scripts/words.toml"
START, END = r"(?:(?<![A-Za-z])|(?<=[a-z])(?=[A-Z]))", r"(?![a-z])"
"""A word begins and ends at what is no letter, and where a name's next word begins with a capital."""
SPACE = r"[\s#_]+"
"""What separates the words of a phrase: a name's `_` and a comment's next line too."""


@dataclass(frozen=True)
class Sense:
    """A pattern, and the files that it is about: none means every file."""

    pattern: re.Pattern[str]
    paths: tuple[str, ...] = ()

    def concerns(self, path: str) -> bool:
        """Whether a file is one of those it is about."""
        return not self.paths or any(fnmatch(path, each) for each in self.paths)


@dataclass(frozen=True)
class Word(Sense):
    """A word to avoid, and what to write instead."""

    instead: str = ""
    is_name: bool = False
    """Whether it is avoided in Python's names only."""


@dataclass(frozen=True)
class WordList:
    """What `words.toml` holds."""

    words: tuple[Word, ...]
    allowed: tuple[Sense, ...]
    """What the subject needs: the same words in another sense."""
    files: tuple[str, ...]
    skipped: tuple[str, ...]

    @cached_property
    def any_word(self) -> re.Pattern[str]:
        """One pattern for all words, which passes by at once where no word begins with one of their first letters."""
        any_ = "|".join(each.pattern.pattern.removeprefix(START) for each in self.words)
        first = "".join({letter + letter.upper() for letter in re.findall(r"(?<![a-z\\])[a-z]", any_)})
        return re.compile(f"{START}(?=[{first}])(?:{any_})")

    def paths(self, root: Path) -> Iterator[str]:
        """The files of a project that are read, in order."""
        found = {path.relative_to(root).as_posix() for each in self.files for path in root.glob(each) if path.is_file()}
        yield from sorted(each for each in found if not any(fnmatch(each, skipped) for skipped in self.skipped))


@dataclass(frozen=True, order=True)
class Finding:
    """A word to avoid, where it was found."""

    path: str
    line: int
    word: str
    instead: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: '{self.word}'; write: {self.instead}"


def read_words(text: str) -> WordList:
    """The list that a TOML text holds."""
    data: dict[str, Any] = tomllib.loads(text)
    return WordList(
        tuple(
            Word(**_sense(each), instead=each["instead"], is_name=each.get("is_name", False)) for each in data["word"]
        ),
        tuple(Sense(**_sense(each)) for each in data["allowed"]),
        tuple(data["files"]),
        tuple(data["skipped"]),
    )


def findings_in(path: str, text: str, words: WordList) -> list[Finding]:
    """What is found in one file, by line."""
    matches = list(words.any_word.finditer(text))
    if not matches:
        return []
    right = [each.span() for sense in words.allowed if sense.concerns(path) for each in sense.pattern.finditer(text)]
    starts = [0, *(each.end() for each in re.finditer("\n", text))]
    names = _names(text, starts) if path.endswith(".py") and any(each.is_name for each in words.words) else set()
    found = []
    for match in matches:
        if any(start <= match.start() and match.end() <= end for start, end in right):
            continue
        for each in words.words:
            is_one = each.concerns(path) and each.pattern.match(text, match.start())
            if is_one and (not each.is_name or match.start() in names):
                found.append(Finding(path, bisect_right(starts, match.start()), match.group(), each.instead))
                break
    return found


def _sense(data: dict[str, Any]) -> dict[str, Any]:
    pattern = START + f"(?i:{data['pattern']})".replace(" ", SPACE) + END
    return {"pattern": re.compile(pattern), "paths": tuple(data.get("paths", ()))}


def _names(text: str, starts: list[int]) -> set[int]:
    """Where the letters of Python's names are in a text."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    names = (each for each in tokens if each.type == tokenize.NAME)
    return {starts[each.start[0] - 1] + at for each in names for at in range(each.start[1], each.end[1])}


def main() -> int:
    """Check; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="*", help="files or folders; by default all of the project")
    args = parser.parse_args()
    words = read_words((ROOT / WORDS).read_text())
    places = tuple(Path(each).resolve().relative_to(ROOT).as_posix() for each in args.paths)
    paths = [
        each for each in words.paths(ROOT) if not places or any(f"{each}/".startswith(f"{one}/") for one in places)
    ]
    found = [one for each in paths for one in findings_in(each, (ROOT / each).read_text(), words)]
    print(*found, f"{len(found)} words to avoid in {len(paths)} files", sep="\n")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
