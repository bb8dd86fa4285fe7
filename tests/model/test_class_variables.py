# SPDX-License-Identifier: Apache-2.0
"""What a kind has as a class, and no author writes."""

from __future__ import annotations

from typing import Any, ClassVar  # noqa: F401 - ClassVar: by name, in annotations

import pytest
from pydantic import ValidationError

from rai_missions.model import MissionModel

evaluated: list[str] = []


def noted(name: str) -> type:
    """The type of a class variable, whose annotation is being evaluated."""
    evaluated.append(name)
    return int


def kind(base: type, annotations: dict[str, str], **values: Any) -> Any:
    """A class of a model, as a file would define it."""
    return type(base)("Kind", (base,), {"__module__": __name__, "__annotations__": annotations, **values})


def test_a_class_variable_is_evaluated_once_however_many_classes_derive_from_it() -> None:
    family = kind(MissionModel, {"rank": "ClassVar[noted('rank')]", "many": "int"}, rank=1)
    kinds = [kind(family, {"own": "ClassVar[noted('own')]"}, rank=2, own=number) for number in range(3)]
    further = kind(kinds[-1], {"name": "str"}, rank=3)
    assert evaluated == ["rank", "own", "own", "own"]
    assert [each.rank for each in (family, *kinds, further)] == [1, 2, 2, 2, 3]
    assert list(further.model_fields) == ["many", "name"]
    made = further.model_validate({"many": 4, "name": "bin"})
    assert (made.many, made.name, made.rank, made.own) == (4, "bin", 3, 2)
    with pytest.raises(ValidationError, match="rank"):
        further.model_validate({"many": 4, "name": "bin", "rank": 5})
