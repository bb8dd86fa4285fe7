# SPDX-License-Identifier: Apache-2.0
"""A family of written things, each distinguished by a word; other packages may offer kinds of it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, TypeVar

from pydantic import GetCoreSchemaHandler
from pydantic_core import core_schema

from rai_missions.errors import UsageError, article, raised_text, suggestion, uncalled
from rai_missions.kinds import PackageOffer, known_names, offered
from rai_missions.model.fields import NAME, fault
from rai_missions.model.mission_model import MissionModel
from rai_missions.redaction import first_line, shown

__all__ = ("FAMILY", "AnyOf", "TaggedModel")

FAMILY = "x-family"
"""In a JSON Schema, before `schema.py` puts the kinds in its place."""


class TaggedModel(MissionModel):
    """A family of written things, each distinguished by a word that it must have.

    A family derives from `TaggedModel` with `family="guard"`; each kind of it derives from the family and has a word.
    Where the family has a `group`, other packages offer further kinds under it by entry points.
    """

    kinds: ClassVar[dict[str, type[Any]]]
    """The format's own: word → kind."""
    foreign: ClassVar[set[type[Any]]]
    """Kinds of other packages that were imported."""
    word: ClassVar[str] = ""
    family: ClassVar[str] = ""
    group: ClassVar[str] = ""
    """The group of entry points for kinds of other packages; empty where there are none."""

    def __init_subclass__(cls, *, family: str = "", word: str | None = None, group: str = "", **rest: Any) -> None:
        super().__init_subclass__(**rest)
        if family:
            cls.family, cls.kinds, cls.foreign, cls.group = family, {}, set(), group
        if word is None:
            return
        cls.word = word
        if cls.__module__.partition(".")[0] == __name__.partition(".")[0]:
            cls.kinds[word] = cls
        elif word in cls.kinds or not re.match(NAME, word):
            owner = "is a word of the format" if word in cls.kinds else "is no name"
            raise TypeError(f"the {cls.family} '{word}' of {cls.__module__}: '{word}' {owner}; choose another")
        else:
            cls.foreign.add(cls)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        made = handler(source)
        is_foreign = cls in getattr(cls, "foreign", ())  # the format's own need no look
        return core_schema.no_info_after_validator_function(_usable, made) if is_foreign else made

    def why_unusable(self) -> str:
        """Why what a kind of another package makes of its fields is of no use; empty where it is."""
        return ""

    @classmethod
    def admit(cls, kind: type[Any]) -> str:
        """Why a kind of another package may not be used; empty if it may."""
        return "" if issubclass(kind, cls) else f"it is no {cls.family}"

    @classmethod
    def offer(cls, word: str) -> PackageOffer | None:
        """Which other package offers the kind of a word.

        Raises:
            UsageError: Several do.
        """
        return offered(cls.group, word, {}) if cls.group and word not in cls.kinds else None

    @classmethod
    def kind(cls, word: str) -> type[Any] | None:
        """The kind of a word: the format's own, else that of an installed package.

        Raises:
            PydanticCustomError: The package's does not load, or may not be used.
        """
        if word in cls.kinds:
            return cls.kinds[word]
        try:
            offer = cls.offer(word)
            family: Any = cls
            return None if offer is None else _admitted(family, offer)
        except UsageError as error:
            raise fault("package", str(error)) from None

    @classmethod
    def choose(cls, data: Mapping[str, Any]) -> str:
        """The word of a mapping that names its kind.

        Raises:
            PydanticCustomError: No word or several.
        """
        given = [word for word in cls.kinds if word and word in data]
        given = given or [word for word in map(str, data) if cls.kind(word) is not None]
        if len(given) == 1:
            return given[0]
        if not given and "" in cls.kinds:
            return ""
        if given:
            raise fault(
                "kinds", f"{article(cls.family)} is one thing, this is {len(given)}: {', '.join(given)}; keep one"
            )
        unknown = next((str(word) for word in data), "")
        if meant := next((cls.meant[word] for word in map(str, data) if word in cls.meant), ""):
            raise fault("kind", f"no {cls.family} is written {sorted(map(str, data))}; did you mean '{meant}'?")
        known = cls.known_kinds()
        near = suggestion(unknown, known) if unknown else f"; there is: {', '.join(known)}"
        like = "" if near.endswith("?") else cls.remedy(data)
        raise fault("kind", f"no {cls.family} is written {sorted(map(str, data))}{near}{like}")

    @classmethod
    def known_kinds(cls) -> tuple[str, ...]:
        """The words of its kinds, the format's own and those of installed packages; none of these is loaded."""
        return known_names(cls.group, filter(None, cls.kinds))

    @classmethod
    def remedy(cls, data: Any) -> str:
        """What to write instead of a value that is no object, for the end of a sentence; empty where it is unknown."""
        return ""

    @classmethod
    def read(cls, data: Any) -> Any:
        """A member of the family from JSON, or the value itself if it is one."""
        if isinstance(data, cls):
            return data
        if not isinstance(data, Mapping):
            given = article(data.family) if isinstance(data, TaggedModel) else shown(data)
            raise fault(
                "object", f"{article(cls.family)} is an object, not {given}{uncalled(data) or cls.remedy(data)}"
            )
        kind = cls.kind(cls.choose(data))
        assert kind is not None
        return kind.model_validate(data)


def _usable(made: TaggedModel) -> TaggedModel:
    """Code of another package that raises, or makes what is of no use, is at fault where it is named."""
    try:
        why = made.why_unusable()
    except Exception as error:  # noqa: BLE001 - it may raise anything
        why = first_line(raised_text(error))
    if why:
        whose = made.offer(made.word) or f"the {made.family} '{made.word}'"
        raise fault("package", f"{whose} cannot be used: {why}")
    return made


@cache
def _admitted(family: Any, offer: PackageOffer) -> Any:
    """The kind that a package offers.

    Raises:
        UsageError: It does not load, or may not be used.
    """
    kind = offer.load()
    why: str = family.admit(kind) if isinstance(kind, type) else f"it is no {family.family}"
    why = why or ("" if offer.name == kind.word else f"its word is '{kind.word}'")
    if why:
        raise UsageError(f"{offer} cannot be used: {why}")
    return kind


class _OfFamily:
    """Reads, writes and describes any member of a family; pydantic need not know the family itself for this.

    Args:
        family: The family.
    """

    def __init__(self, family: type[TaggedModel]) -> None:
        self._family = family

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        written = core_schema.plain_serializer_function_ser_schema(lambda item: item.written())
        return core_schema.no_info_plain_validator_function(self._family.read, serialization=written)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        return {FAMILY: self._family.__name__}


Member = TypeVar("Member", bound=TaggedModel)

if TYPE_CHECKING:
    AnyOf = Annotated[Member, "one of a family's kinds"]
    """`AnyOf[Guard]`: the field type for any member of a family."""
else:

    class AnyOf:
        """`AnyOf[Guard]`: the field type for any member of a family."""

        def __class_getitem__(cls, family: type[TaggedModel]) -> Any:
            return Annotated[family, _OfFamily(family)]
