# SPDX-License-Identifier: Apache-2.0
"""Measure the prose of the documents: how long the sentences and lines are, and how much is put as a negation.

    python scripts/prose.py                 # hold README, CHANGELOG, docs/ and the missions' READMEs to the limits
    python scripts/prose.py --table [FILE]  # the figures of each page

What counts, per page:

- *Prose* is the Markdown outside code blocks and comments. Inline code counts as one word, a link by its text. Pictures
  are left out.
- *A sentence* ends at `.`, `!` or `?` before a space, or with its paragraph, list item or table cell. Colons and
  semicolons do not end one. Headings are no sentences, nor are table cells of fewer than five words.
- *A negation* is one of NEGATIONS, or a word that ends in `n't`.
- *A line* is a line of the file, code and tables included, in characters.

Pages of fewer than 200 words are held to the length of lines alone: one sentence would decide.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
NEGATIONS = frozenset(
    ("no", "not", "never", "none", "nothing", "nobody", "nowhere", "neither", "nor", "cannot", "without")
)
MOST_NEGATIONS = 10.0
"""Per 1,000 words of a page."""
LONGEST_MEAN = 15.0
"""Words in a page's sentences, on average."""
LONGEST_LINE = 120
"""Characters."""
FEWEST_WORDS = 200
SHORTEST_CELL = 5

NOT_PROSE = re.compile(r"^ *(```+)[^\n]*\n.*?^ *\1 *$|<!--.*?-->|!\[[^\]]*\]\([^)]*\)", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
CODE = re.compile(r"`+([^`]*)`+")
WORD = re.compile(r"[^\W_]+(?:[-'’][^\W_]+)*")
END = re.compile(r"(?<=[.!?])[\"”')*_]*\s+")
RULE = re.compile(r"^\|[-:| ]+\|$")
ITEM = re.compile(r"^\s*(?:[-*]|\d+\.)\s+")


class Prose(NamedTuple):
    """What was measured of one page."""

    words: int
    sentences: int
    sentence_words: int
    """Words inside sentences: those of headings and short cells are left out."""
    negations: int
    long_lines: tuple[int, ...]

    @property
    def mean(self) -> float:
        return self.sentence_words / max(self.sentences, 1)

    @property
    def negations_per_1000(self) -> float:
        return 1000 * self.negations / max(self.words, 1)

    def faults(self) -> Iterator[str]:
        if self.long_lines:
            yield f"longer than {LONGEST_LINE} characters: line {', '.join(map(str, self.long_lines))}"
        if self.words < FEWEST_WORDS:
            return
        if self.mean > LONGEST_MEAN:
            yield f"a sentence has {self.mean:.1f} words on average; at most {LONGEST_MEAN:g}"
        if self.negations_per_1000 > MOST_NEGATIONS:
            yield f"{self.negations_per_1000:.1f} negations per 1,000 words; at most {MOST_NEGATIONS:g}"


def blocks(text: str) -> Iterator[tuple[str, bool]]:
    """The paragraphs, list items, cells and headings of a page, each with whether it may be a sentence."""
    paragraph: list[str] = []
    for raw in [*NOT_PROSE.sub("", text).splitlines(), ""]:
        line = raw.strip().lstrip(">").strip()
        is_new = not line or line.startswith(("|", "#")) or ITEM.match(line)
        if is_new and paragraph:
            yield " ".join(paragraph), True
            paragraph = []
        if line.startswith("#"):
            yield line.lstrip("# "), False
        elif line.startswith("|") and not RULE.match(line):
            for cell in re.split(r"(?<!\\)\|", line.strip("|")):
                yield cell.strip(), len(WORD.findall(cell)) >= SHORTEST_CELL
        elif line and not line.startswith("|"):
            paragraph.append(ITEM.sub("", line))


def measure(text: str) -> Prose:
    words = sentences = sentence_words = negations = 0
    for block, is_sentence in blocks(text):
        plain = LINK.sub(r"\1", CODE.sub("code", block))
        for sentence in END.split(plain):
            found = [word.lower() for word in WORD.findall(sentence)]
            words += len(found)
            negations += sum(word in NEGATIONS or word.replace("’", "'").endswith("n't") for word in found)
            if is_sentence and found:
                sentences += 1
                sentence_words += len(found)
    long = tuple(number for number, line in enumerate(text.splitlines(), 1) if len(line) > LONGEST_LINE)
    return Prose(words, sentences, sentence_words, negations, long)


def pages() -> list[Path]:
    """The pages that are held to the limits; decisions are the records of their day."""
    found = [ROOT / "README.md", ROOT / "CHANGELOG.md", *ROOT.glob("docs/**/*.md"), *ROOT.glob("missions/*/README.md")]
    return sorted(page for page in found if "decisions" not in page.relative_to(ROOT).parent.parts)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--table", action="store_true", help="print the figures of each page")
    parser.add_argument("files", nargs="*", type=Path, help="pages to measure instead of all that are held")
    given = parser.parse_args()
    is_bad = False
    for page in given.files or pages():
        prose = measure(page.read_text(encoding="utf-8"))
        name = page.resolve().relative_to(ROOT)
        if given.table:
            print(
                f"{name!s:34} {prose.words:5} words, {prose.mean:4.1f} a sentence, "
                f"{prose.negations_per_1000:4.1f} negations per 1,000, {len(prose.long_lines):2} long lines"
            )
        for fault in prose.faults():
            is_bad = True
            print(f"{name}: {fault}", file=sys.stderr)
    return int(is_bad)


if __name__ == "__main__":
    sys.exit(main())
