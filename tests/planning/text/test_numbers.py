# SPDX-License-Identifier: Apache-2.0
"""Numbers in digits and words; a language without its tables is refused."""

from __future__ import annotations

import pytest

from rai_missions.errors import UsageError
from rai_missions.planning.text.language_file import word_forms
from rai_missions.planning.text.numbers import number


@pytest.mark.parametrize(
    ("code", "words", "value"),
    [
        ("en", "twenty five", 25), ("en", "one hundred and two", 102), ("en", "minus two", -2), ("en", "2.5", 2.5),
        ("en", "three point five", 3.5), ("en", "two thousand", 2000), ("en", "five five", None),
        ("en", "apples", None),
        ("de", "fünfundzwanzig", 25), ("de", "drei komma fünf", 3.5), ("de", "2,5", 2.5), ("de", "1.500", 1500),
        ("en", "half an", 0.5), ("en", "one and a half", 1.5), ("en", "and a half", None), ("de", "eine halbe", 0.5),
        ("de", "anderthalb", 1.5), ("en", "1,500", 1500), ("en", "9" * 30, None),
    ],
)  # fmt: skip
def test_numbers_are_read_in_words_and_digits(code: str, words: str, value: float | None) -> None:
    assert number(words.split(), word_forms(code)) == value


def test_a_language_without_tables_is_refused_with_the_nearest() -> None:
    with pytest.raises(UsageError, match="no word forms of the language 'dee'; did you mean 'de'"):
        word_forms("dee")
