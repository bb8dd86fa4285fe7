# SPDX-License-Identifier: Apache-2.0
"""What every written thing of a mission is: a frozen model that reads and writes the words of the format.

Rule: all that an author can write is a field of a `MissionModel`; unknown words are refused, nothing is coerced.
Rule: a constructor for authors is declared, with types and no body; what builds is the same for all of them.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping, Sequence
from functools import wraps
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic.fields import FieldInfo

from rai_missions.errors import DefinitionError, suggestion
from rai_missions.model.attribute_docs import attribute_docs, explained
from rai_missions.model.fields import NOT_NULL, alike
from rai_missions.model.references import KeyValue, Reference, found, inside, written_keys
from rai_missions.model.validation_errors import faults_of

__all__ = ("MissionModel", "without_schema")

if TYPE_CHECKING:

    class Model:
        """What ours use of a pydantic model.

        A type checker that saw the real one would make constructors of the fields, with the fields' own types; ours
        take the format's words, references and positions.
        """

        model_config: ClassVar[ConfigDict]
        model_fields: ClassVar[dict[str, FieldInfo]]
        model_fields_set: set[str]
        __private_attributes__: ClassVar[dict[str, Any]]

        def __init__(self, **words: Any) -> None: ...
        @classmethod
        def __pydantic_init_subclass__(cls, **rest: Any) -> None: ...
        @classmethod
        def model_validate(cls, obj: Any, *, context: Any = None) -> Self: ...
        @classmethod
        def model_json_schema(cls, *, ref_template: str = ...) -> dict[str, Any]: ...
        def model_dump(self, **options: Any) -> dict[str, Any]: ...
        def model_dump_json(self, **options: Any) -> str: ...
        def model_copy(self, *, update: Mapping[str, Any] | None = None) -> Self: ...
else:

    class WithHelp(type(BaseModel)):
        """Gives `help()` and `?` the constructor as it is declared, with each of its words explained."""

        def __init__(cls, *made: Any, **rest: Any) -> None:
            super().__init__(*made, **rest)
            # pydantic would evaluate them once more for each class that derives from this one
            for name in cls.__class_vars__ & cls.__annotations__.keys():
                del cls.__annotations__[name]

        @property
        def __doc__(cls) -> str | None:
            own = vars(cls).get("__doc__")
            return explained(own, cls.__init__, cls.meanings()) if own else own

        @property
        def __signature__(cls) -> inspect.Signature:
            signature = inspect.signature(cls.__init__)
            return signature.replace(parameters=list(signature.parameters.values())[1:])

        @__signature__.setter
        def __signature__(cls, made: object) -> None:
            """pydantic's own, which names parameters by aliases, is dropped."""

    class Model(BaseModel, metaclass=WithHelp):
        """A pydantic model."""

        meanings: ClassVar = dict


def without_schema(cls: type, data: Any) -> Any:
    """A validator for the root of a file: `$schema` is for editors."""
    return {word: item for word, item in data.items() if word != "$schema"} if isinstance(data, Mapping) else data


class MissionModel(Model):  # noqa: PLW1641 - pydantic gives a frozen model its hash
    """A frozen model with the format's words as aliases; in Python its main words may be given by position."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    meant: ClassVar[Mapping[str, str]] = {}
    """Words that authors write, which the format does not have → the word that it has instead."""
    example: ClassVar[str] = ""
    """How it is written; `%s` is the word in question."""
    positional: ClassVar[tuple[str, ...]] = ()
    """The words that Python authors may give by position, in this order: those that a declared constructor has so."""
    ordered: ClassVar[tuple[str, ...]] = ()
    """The fields that are objects whose order has a meaning."""

    def __init__(self, /, *given: Any, **words: Any) -> None:
        """Make one; the arguments are explained above.

        Raises:
            DefinitionError: With every fault; places begin at this object.
        """
        # By field names (`from_`) or by the format's words. What a class declares as its own has no body.
        kind = type(self)
        if len(given) > len(kind.positional):
            raise TypeError(_too_many(kind, given))
        words = kind.spelled(dict(zip(kind.positional, given, strict=False)) | words)
        aliases = {name: field.alias for name, field in kind.model_fields.items() if field.alias}
        words = {aliases.get(name, name): value for name, value in words.items()}
        for name in [name for name, field in kind.model_fields.items() if field.default is None]:
            if words.get(aliases.get(name, name), ...) is None:  # in Python a default may be written
                del words[aliases.get(name, name)]
        try:
            super().__init__(**words)
        except ValidationError as error:
            is_declared = kind.__init__ is not MissionModel.__init__
            known = list(inspect.signature(kind.__init__).parameters)[1:] if is_declared else ()
            raise DefinitionError(faults_of(error, kind, words, known), _called(kind, given)) from None

    # Else pydantic takes what is inside another model through here too, and JSON could use Python's names.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    def __init_subclass__(cls, **rest: Any) -> None:
        super().__init_subclass__(**rest)
        declared: Any = vars(cls).get("__init__")
        # Not assigned as `cls.__init__`: tools that read the source would take that for every constructor.
        type.__setattr__(cls, "__init__", MissionModel.__init__ if declared is None else _built_as(declared))
        if declared is not None:
            cls.positional = declared.__code__.co_varnames[1 : declared.__code__.co_argcount]

    @classmethod
    def spelled(cls, words: dict[str, Any]) -> dict[str, Any]:
        """The words of the constructor as those of the fields: the same, unless Python groups them otherwise."""
        return words

    @classmethod
    def summary(cls) -> str:
        """What it is, as its source has it: without the words of the constructor, which `__doc__` has too."""
        return inspect.cleandoc(vars(cls).get("__doc__") or "")

    @classmethod
    def meanings(cls) -> Mapping[str, str]:
        """Word of the constructor → what it means: the text below its field."""
        return attribute_docs(cls)

    @classmethod
    def __pydantic_init_subclass__(cls, **rest: Any) -> None:
        """In JSON a word that may be left out has a value, or is left out: null is none."""
        super().__pydantic_init_subclass__(**rest)
        for field in cls.model_fields.values():
            if field.default is None and NOT_NULL not in field.metadata:
                field.metadata.append(NOT_NULL)

    def __eq__(self, other: object) -> bool:
        """Whether both are written alike: 1, 1.0 and true are three values, and order counts where it has a meaning."""
        if type(self) is not type(other) or not alike(self.__dict__, other.__dict__):
            return False
        return all(list(self.__dict__[name]) == list(other.__dict__[name]) for name in self.ordered)

    def __repr_args__(self) -> Iterator[tuple[str | None, Any]]:
        """The words that it was given; those left out would hide them."""
        shown = super().__repr_args__()  # type: ignore[misc]
        return ((name, value) for name, value in shown if name in self.model_fields_set)

    __iter__ = None
    """Else pydantic takes one that is given alone, where a list of them is due, for a list of its words."""

    def __getattr__(self, name: str) -> Any:
        if name in type(self).__private_attributes__:  # pydantic keeps these apart from what is written
            return super().__getattr__(name)  # type: ignore[misc]
        raise AttributeError(_NoSuchAttribute(type(self), name))

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: Any) -> dict[str, Any]:
        """The texts below the fields explain them; pydantic would read them with every import."""
        schema: dict[str, Any] = handler(core_schema)
        if "description" in (described := handler.resolve_ref_schema(schema)):
            described["description"] = cls.summary()
        properties, docs = handler.resolve_ref_schema(schema).get("properties", {}), attribute_docs(cls)
        for name, field in cls.model_fields.items():
            place = field.alias or name
            if name in docs and place in properties:
                properties[place] = {"description": docs[name]} | properties[place]
        return schema

    def references(self, place: str = "") -> Iterator[Reference]:
        """What it refers to itself, each with its JSON pointer: names of states, keys, events, and paths."""
        return found(self, place)

    def writes(self, place: str = "") -> Iterator[KeyValue]:
        """The mission's keys that it writes itself."""
        return written_keys(self, place)

    def inside(self, place: str = "") -> Iterator[tuple[str, Any]]:
        """The written things directly inside it, each with its JSON pointer."""
        return inside(self, place)

    def everything(self) -> Iterator[Any]:
        """Every written thing in it, itself included, outer before inner."""
        yield self
        for _, inner in self.inside():
            yield from inner.everything()

    def model_dump(self, **options: Any) -> dict[str, Any]:
        """As a file has it: the format's words, and none that has its default; `model_validate` reads it back.

        Args:
            options: Those of pydantic.
        """
        return super().model_dump(**{"by_alias": True, "exclude_defaults": True, **options})

    def model_dump_json(self, **options: Any) -> str:
        """As `model_dump`, as text."""
        return super().model_dump_json(**{"by_alias": True, "exclude_defaults": True, **options})

    def written(self) -> dict[str, Any]:
        """As JSON has it: aliases, and no word that has its default."""
        return self.model_dump(mode="json")


def _called(kind: type[MissionModel], given: Sequence[Any]) -> str:
    """A call as a fault names it; where several values were given by position, with their order."""
    return f"{kind.__name__}({', '.join((*kind.positional, '…')) if len(given) > 1 else '…'})"


def _too_many(kind: type[MissionModel], given: Sequence[Any]) -> str:
    takes = ", ".join(kind.positional) or "nothing"
    return f"{kind.__name__} takes by position: {takes}; {len(given)} values were given, write the others by their word"


def _built_as(declared: Any) -> Any:
    """The constructor that builds, with the face of a declared one."""

    @wraps(declared)
    @wraps(MissionModel.__init__)  # for pydantic's mark on it
    def __init__(self: MissionModel, /, *given: Any, **words: Any) -> None:  # noqa: N807 - it is one
        MissionModel.__init__(self, *given, **words)

    return __init__


class _NoSuchAttribute:
    """What is reported of an attribute that a model lacks, in words only when it is read: most are only looked for.

    Args:
        kind: The kind of the model.
        name: The attribute.
    """

    def __init__(self, kind: Any, name: str) -> None:
        self._kind, self._name = kind, name

    def __str__(self) -> str:
        own = {each for part in self._kind.__mro__ if issubclass(part, MissionModel) for each in vars(part)}
        known = [each for each in own | set(self._kind.model_fields) if not each.startswith(("_", "model_"))]
        return f"{self._kind.__name__} has no attribute '{self._name}'{suggestion(self._name, known)}"
