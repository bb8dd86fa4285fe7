# SPDX-License-Identifier: Apache-2.0
"""One table of operators: the field, the words, the opposite and the truth of each comparison follow from it."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions import DefinitionError, Key, Keys, Mission, Ref, When
from rai_missions.check import check
from rai_missions.guards import Compare
from rai_missions.guards.compare import OPERATORS, OPPOSITES, ORDERED, holds, truth
from rai_missions.guards.form import Atom
from rai_missions.guards.implication import form, implies
from rai_missions.states import Final, State


def operand(word: str, value: Any = 1) -> Any:
    return [value] if OPERATORS[word].takes_list else value


def test_a_comparison_has_the_fields_of_the_table_and_no_others() -> None:
    words = {name: field.alias for name, field in Compare.model_fields.items() if name != "key"}
    assert words == {each.field: word for word, each in OPERATORS.items()}


@pytest.mark.parametrize("word", OPERATORS)
def test_each_operator_is_written_and_shown_by_its_words(word: str) -> None:
    each = OPERATORS[word]
    guard = Compare("n", **{each.field: operand(word)})
    assert guard.written() == {"key": "n", word: operand(word)}
    assert guard.words() == f"n {each.symbol} 1"
    assert (guard.op, guard.operand) == (word, operand(word))


@pytest.mark.parametrize("word", OPERATORS)
def test_its_opposite_is_true_where_it_is_false(word: str) -> None:
    guard = Compare("n", **{OPERATORS[word].field: operand(word)})
    opposite = form(~guard)
    assert isinstance(opposite, Atom) and opposite.op == OPPOSITES[word]
    assert OPPOSITES[OPPOSITES[word]] == word
    for value in (0, 1, 2.5):
        given = (1,) if OPERATORS[word].takes_list else 1
        assert holds(value, word, given) is not holds(value, opposite.op, given), value
    assert implies(form(guard), form(guard)) and not implies(form(guard), opposite)


@pytest.mark.parametrize("word", OPERATORS)
def test_only_those_with_an_order_are_refused_for_a_key_that_has_none(word: str) -> None:
    k = Keys(flag=Key(bool, source="robot", max_age_s=5))
    guard = Compare(k.flag, **{OPERATORS[word].field: operand(word, value=True)})
    states = {"here": State(transitions=[When(guard, to="done")]), "done": Final("aborted")}
    found = [each.rule for each in check(Mission("m", keys=k, initial="here", states=states))]
    assert ("mismatched-comparison" in found) is (word in ORDERED)


@pytest.mark.parametrize("word", [word for word, each in OPERATORS.items() if each.takes_list])
def test_a_list_is_asked_for_where_an_operator_takes_one(word: str) -> None:
    with pytest.raises(DefinitionError, match=f"'{word}' takes a list of values or a key that holds one, not 1"):
        Compare("n", **{OPERATORS[word].field: 1})
    assert Compare("n", **{OPERATORS[word].field: Ref("others")}).other == "others"
    with pytest.raises(DefinitionError, match=f"'{word}' takes a list of values or a key that holds one, not"):
        Compare("n", **{OPERATORS[word].field: {"a": 1}})


@pytest.mark.parametrize("operand", [[1, 2], [True], [False, 1], ["a"], [], "abc", {"a": 1}, 3])
@pytest.mark.parametrize("value", [1, True, 1.0, "a", "ab"])
def test_a_list_has_what_is_equal_to_one_of_its_items_and_nothing_else_is_a_list(value: Any, operand: Any) -> None:
    """Of the run: true where an item is equal, unknown where there is no list."""
    listed = isinstance(operand, list)
    expected = any(holds(value, "==", item) for item in operand) if listed else None
    assert truth(OPERATORS["in"].apply, value, operand, equality=False) is expected
    assert holds(value, "in", operand) is (expected is True)
    assert holds(value, "not in", operand) is (expected is False)
