# SPDX-License-Identifier: Apache-2.0
"""What every written thing of a mission is: a frozen model that reads and writes the words of the format.

Rule: all that an author can write is a field of a `MissionModel`; unknown words are refused, nothing is coerced.
Rule: a constructor for authors is declared, with types and no body; what builds is the same for all of them.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import cache, wraps
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NoReturn, Protocol, Self, TypeAlias, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    PlainValidator,
    Strict,
    ValidationError,
    WithJsonSchema,
)
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError, PydanticKnownError

from rai_missions.errors import DefinitionError, UsageError, suggestion
from rai_missions.kinds import (
    EVENT,
    KEY,
    PATH,
    STATE,
    TIMER,
    KeyValue,
    OneOrMany,
    PackageOffer,
    Reference,
    Refers,
    found,
    inside,
    offered,
    written_keys,
)
from rai_missions.redaction import shown
from rai_missions.validation_errors import faults_of

__all__ = (
    "FAMILY",
    "LISTED",
    "ActionName",
    "AnyOf",
    "Bool",
    "EventName",
    "Format",
    "HasPath",
    "Integer",
    "Json",
    "KeyName",
    "KeyPath",
    "MissionModel",
    "Name",
    "Number",
    "Path",
    "Seconds",
    "ServiceName",
    "StateName",
    "StateNames",
    "TaggedModel",
    "Text",
    "TimerName",
    "TopicName",
    "Value",
    "alike",
    "explained",
    "fault",
    "kind_of",
    "one_or_many",
    "suggestion",
    "without_schema",
)

NAME = r"^[a-z][a-z0-9_]*(/[a-z][a-z0-9_]*)*$"
PATH_PATTERN = r"^[a-z][a-z0-9_]*(/[a-z][a-z0-9_]*)*(\.[A-Za-z_][A-Za-z0-9_]*)*$"


def fault(kind: str, sentence: str) -> PydanticCustomError:
    """A fault of the author, as pydantic wants it raised in a validator; the sentence reaches the author as it is."""
    return PydanticCustomError(kind, "{sentence}", {"sentence": sentence})


def _key_text(value: Any) -> Any:
    """A reference made by `Keys` reads as its path."""
    return getattr(value, "__path__", value) if not isinstance(value, str) else value


def _tuple(value: Any) -> Any:
    if type(value) is str:  # as most are written
        return (value,)
    value = _key_text(value)
    return tuple(value) if isinstance(value, list | tuple) else (value,)


def _shorter(value: tuple[Any, ...]) -> Any:
    return value[0] if len(value) == 1 else list(value)


class _OneOrManySchema(OneOrMany):
    """States in a JSON Schema that a word may be written without its list."""

    def __get_pydantic_json_schema__(self, core_schema: Any, handler: Any) -> dict[str, Any]:
        listed = handler(core_schema)
        return {"anyOf": [listed["items"], listed]}


one_or_many = (BeforeValidator(_tuple), PlainSerializer(_shorter, return_type=Any), _OneOrManySchema())
"""A word or a list of words in JSON, always a tuple here."""

Text = Annotated[str, Strict()]
Name = Annotated[str, Strict(), Field(pattern=NAME), BeforeValidator(_key_text)]
"""Lower case, digits and underscores; `/` only in what an inclusion brought."""
Path = Annotated[str, PATH, Strict(), Field(pattern=PATH_PATTERN), BeforeValidator(_key_text)]
"""A key, or a field within one: `obstacle.height_m`; `event.…` and `answer.…` are of the trigger."""
StateName = Annotated[Name, STATE]
KeyName = Annotated[Name, KEY]
EventName = Annotated[Name, EVENT]
TimerName = Annotated[Name, TIMER]
ActionName = Annotated[Name, Refers("action")]
"""An action of the robot's profile."""
ServiceName = Annotated[Name, Refers("service")]
TopicName = Annotated[Name, Refers("topic")]
StateNames = Annotated[tuple[StateName, ...], Field(min_length=1), *one_or_many]
Bool = Annotated[bool, Strict()]
Integer = Annotated[int, Strict()]
Number = Annotated[int, Strict()] | Annotated[float, Strict(), Field(allow_inf_nan=False)]
Seconds = Annotated[
    float,
    Strict(),
    Field(ge=0, allow_inf_nan=False),
    PlainSerializer(lambda value: int(value) if isinstance(value, float) and value.is_integer() else value),
]


def _whole(value: Any) -> Any:
    if type(value) in (bool, float):  # true and 1.0 are equal to 1
        raise PydanticKnownError("literal_error", {"expected": "1"})
    return value


Format = Annotated[Literal[1], BeforeValidator(_whole)]
"""The version of the format of a file."""


def _frozen(value: Any) -> Any:
    """JSON values as they compare: lists as lists, finite numbers only."""
    if isinstance(value, float) and (value != value or value in (float("inf"), float("-inf"))):
        raise fault("finite", f"{value} is not a number that JSON has; give a finite one")
    if isinstance(value, Mapping):
        return {str(_key_text(name)): _frozen(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_frozen(item) for item in value]
    if value is None or isinstance(value, str | int | float):
        return value
    text = _key_text(value)
    if isinstance(text, str):
        return {"from": text}
    raise fault("json", f"{value!r} is not JSON; give text, a number, true, false, a list or an object")


Json = Annotated[Any, AfterValidator(_frozen)]
"""A JSON value; in Python a reference made by `Keys` is read as `{"from": path}`."""


def _not_null(value: Any) -> Any:
    if value is None:
        raise fault("null", "null is no value; leave the word out")
    return value


NOT_NULL = BeforeValidator(_not_null)
"""Of a word that may be left out."""


def _listed(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


LISTED = BeforeValidator(_listed)
"""Of a tuple, which JSON and Python may write as a list; a word alone is none."""


def alike(one: Any, other: Any) -> bool:
    """Whether two values are equal as JSON is written: 1, 1.0 and true are three values."""
    if type(one) is not type(other):
        return False
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(alike(value, other[name]) for name, value in one.items())
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(alike, one, other))
    return bool(one == other)


class HasPath(Protocol):
    """A reference as `Keys`, `event` and `answer` make it: `k.obstacle.height_m`."""

    @property
    def __path__(self) -> str: ...


KeyPath: TypeAlias = str | HasPath
"""Where an author names a key or a field of one: a reference, or its path as text."""
Value: TypeAlias = object
"""What an author writes in a goal, request or message: a JSON value, with references for what a run will know."""


if TYPE_CHECKING:

    class Model:
        """What ours use of a pydantic model.

        A type checker that saw the real one would make constructors of the fields, with the fields' own types; ours
        take the format's words, references and positions.
        """

        model_config: ClassVar[ConfigDict]
        model_fields: ClassVar[dict[str, FieldInfo]]
        model_fields_set: set[str]

        def __init__(self, **words: Any) -> None: ...
        @classmethod
        def __pydantic_init_subclass__(cls, **rest: Any) -> None: ...
        @classmethod
        def model_validate(cls, obj: Any) -> Self: ...
        @classmethod
        def model_json_schema(cls, *, ref_template: str = ...) -> dict[str, Any]: ...
        def model_dump(self, **options: Any) -> dict[str, Any]: ...
        def model_dump_json(self, **options: Any) -> str: ...
        def model_copy(self, *, update: Mapping[str, Any] | None = None) -> Self: ...
else:

    class WithHelp(type(BaseModel)):
        """Gives `help()` and `?` the constructor as it is declared, with each of its words explained."""

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
            known = list(inspect.signature(kind.__init__).parameters)[1:] if "__init__" in vars(kind) else ()
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
        return _attribute_docs(cls)

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

    def __getattr__(self, name: str) -> NoReturn:
        raise AttributeError(_NoSuchAttribute(type(self), name))

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: Any) -> dict[str, Any]:
        """The texts below the fields explain them; pydantic would read them with every import."""
        schema: dict[str, Any] = handler(core_schema)
        if "description" in (described := handler.resolve_ref_schema(schema)):
            described["description"] = cls.summary()
        properties, docs = handler.resolve_ref_schema(schema).get("properties", {}), _attribute_docs(cls)
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
        kind: Of the model.
        name: The attribute.
    """

    def __init__(self, kind: Any, name: str) -> None:
        self._kind, self._name = kind, name

    def __str__(self) -> str:
        own = {each for part in self._kind.__mro__ if issubclass(part, MissionModel) for each in vars(part)}
        known = [each for each in own | set(self._kind.model_fields) if not each.startswith(("_", "model_"))]
        return f"{self._kind.__name__} has no attribute '{self._name}'{suggestion(self._name, known)}"


def explained(doc: str, function: Any, meanings: Mapping[str, str]) -> str:
    """A docstring with the arguments of a function, each with its meaning and its default.

    Args:
        doc: Has no arguments yet.
        function: Whose arguments are explained.
        meanings: Argument → what it means, with its unit.
    """
    lines = []
    for name, parameter in inspect.signature(function).parameters.items():
        if name in meanings:
            default = parameter.default
            shown = "" if default in (parameter.empty, None, (), {}, "") else f" Default: {default!r}."
            lines.append(f"    {name}: " + meanings[name].replace("\n", "\n        ") + shown)
    return "\n".join([inspect.cleandoc(doc), "", "Args:", *lines]) if lines else inspect.cleandoc(doc)


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
        known = ", ".join(word for word in cls.kinds if word)
        if given:
            raise fault("kinds", f"a {cls.family} is one thing, this is {len(given)}: {', '.join(given)}; keep one")
        unknown = next((str(word) for word in data), "")
        if meant := next((cls.meant[word] for word in map(str, data) if word in cls.meant), ""):
            raise fault("kind", f"no {cls.family} is written {sorted(map(str, data))}; did you mean '{meant}'?")
        near = suggestion(unknown, cls.kinds) if unknown else f"; there is: {known}"
        like = "" if near.endswith("?") else cls.remedy(data)
        raise fault("kind", f"no {cls.family} is written {sorted(map(str, data))}{near}{like}")

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
            raise fault("object", f"a {cls.family} is an object, not {shown(data)}{cls.remedy(data)}")
        kind = cls.kind(cls.choose(data))
        assert kind is not None
        return kind.model_validate(data)


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


def kind_of(family: type[TaggedModel]) -> Any:
    """The field type for any member of a family."""
    return Annotated[
        family,
        PlainValidator(family.read),
        PlainSerializer(lambda item: item.written(), return_type=Any),
        WithJsonSchema({FAMILY: family.__name__}),
    ]


Member = TypeVar("Member", bound=TaggedModel)

if TYPE_CHECKING:
    AnyOf = Annotated[Member, "one of a family's kinds"]
    """`AnyOf[Guard]`: the field type for any member of a family."""
else:

    class AnyOf:
        """`AnyOf[Guard]`: the field type for any member of a family."""

        def __class_getitem__(cls, family: type[TaggedModel]) -> Any:
            return kind_of(family)


Docs = Mapping[str, str]


def _attribute_docs(kind: type[Any]) -> dict[str, str]:
    """Attribute → the text below its annotation, those of the classes it derives from included.

    A class whose source is not available, and a class inside a function, has none.
    """
    found: dict[str, str] = {}
    for each in reversed(kind.__mro__):
        found.update(_in_module(each.__module__).get(each.__qualname__, {}) if _annotates(each) else {})
    return found


def _annotates(kind: type[Any]) -> bool:
    """Whether a class itself is annotated; from Python 3.14 on by a function, unless its module postpones that."""
    return "__annotations__" in vars(kind) or getattr(kind, "__annotate__", None) is not None


@cache
def _in_module(name: str) -> Mapping[str, Docs]:
    """Class → attribute → text, of a whole module: to find one class in a source takes as long as to find all."""
    try:
        source = inspect.getsource(sys.modules[name])
    except (KeyError, OSError, TypeError):
        return {}
    return dict(_classes(ast.parse(source).body, ""))


def _classes(body: list[ast.stmt], outside: str) -> Iterator[tuple[str, Docs]]:
    for each in body:
        if isinstance(each, ast.ClassDef):
            yield outside + each.name, dict(_texts(each.body))
            yield from _classes(each.body, f"{outside}{each.name}.")


def _texts(body: list[ast.stmt]) -> Iterator[tuple[str, str]]:
    for attribute, text in pairwise(body):
        if not (isinstance(attribute, ast.AnnAssign) and isinstance(attribute.target, ast.Name)):
            continue
        if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant) and isinstance(text.value.value, str):
            yield attribute.target.id, inspect.cleandoc(text.value.value)
