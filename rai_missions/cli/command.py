# SPDX-License-Identifier: Apache-2.0
"""A command of the command line: a typed function, whose parameters are the arguments and whose docstring is the help.

Rule: the file of a command imports what its parser needs; what the command does is imported when it runs.
"""

from __future__ import annotations

import argparse
import math
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import NoneType
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

__all__ = (
    "PAGE_PORT",
    "Argument",
    "Command",
    "GuardsFile",
    "JournalFile",
    "MissionFile",
    "Parser",
    "ProfileFile",
    "RobotFile",
    "command",
    "read_speed",
)

PAGE_PORT = "8765"
"""Where the live page is served, if no other port is given."""
NUMBERS: Mapping[Any, str] = {int: "whole number, such as 3", float: "number, such as 2.5"}
SECTION = re.compile(r"^(Args|Exit status|Example):\n", re.MULTILINE)
PARAMETER = re.compile(r"^(\w+): ", re.MULTILINE)


class Argument(NamedTuple):
    """How a parameter is given on the command line, where its type leaves it open: `Annotated[str, Argument(…)]`."""

    metavar: str | None = None
    short: str = ""
    """A second name: `-o`."""
    bare: str | None = None
    """The value of an option that is given without one."""
    takes_rest: bool = False
    """All that follows the option belongs to it."""
    files: tuple[str, ...] = ()
    """The files that a shell completes, as patterns."""
    is_positional: bool = False
    """A field of a `NamedTuple` that is given without its name; of a function, the parameters before `*` are."""
    parse: Callable[[str], Any] | None = None
    """Reads the text instead of the type; raises `argparse.ArgumentTypeError`."""

    def takes(self, file: str) -> bool:
        """Whether a file has an ending of its own."""
        return any(file.endswith(pattern[1:]) for pattern in self.files if pattern != "*")


MissionFile = Annotated[str, Argument("MISSION", files=("*.json", "*.py"))]
ProfileFile = Annotated[str, Argument("PROFILE", files=("*.json",))]
RobotFile = Annotated[str, Argument("ROBOT", files=("*.json", "*.py"))]
JournalFile = Annotated[str, Argument("JOURNAL", files=("*.journal", "*.mcap"))]
GuardsFile = Annotated[str, Argument("FILE.py", files=("*.py",))]


class Parser(argparse.ArgumentParser):
    """A parser whose help fills paragraphs, and leaves those with indented lines as they are."""

    def __init__(self, **words: Any) -> None:
        super().__init__(formatter_class=_Formatter, **words)


class _Formatter(argparse.HelpFormatter):
    def _fill_text(self, text: str, width: int, indent: str) -> str:
        blocks = text.split("\n\n")
        return "\n\n".join(block if "\n " in block else textwrap.fill(block, width) for block in blocks)


class Parameter(NamedTuple):
    """A parameter of a command."""

    name: str
    kind: Any
    argument: Argument
    help: str
    is_required: bool
    default: Any = None

    @property
    def flag(self) -> str:
        """The option's name on the command line."""
        return self.name if self.argument.is_positional else f"--{self.name.rstrip('_').replace('_', '-')}"

    @property
    def flags(self) -> list[str]:
        """The option's names on the command line; none where it is given without a name."""
        return [] if self.argument.is_positional else [*filter(None, [self.argument.short]), self.flag]

    @property
    def has_one_value(self) -> bool:
        """Whether it is an option with one value."""
        return not self.argument.is_positional and self.kind is not bool and get_origin(self.kind) is not tuple

    @property
    def usage(self) -> str:
        """As it is typed: `FILE`, `[FILE]` where it may be left out, `--option VALUE`."""
        value = self.argument.metavar or self.name.upper()
        if self.argument.is_positional:
            return value if self.is_required else f"[{value}]"
        return self.flag if self.kind is bool or self.argument.bare is not None else f"{self.flag} {value}"

    def add_to(self, parser: argparse.ArgumentParser) -> argparse.Action:
        """Have a parser read it."""
        words: dict[str, Any] = {"metavar": self.argument.metavar, "default": argparse.SUPPRESS, "dest": self.name}
        if self.kind is bool:
            words = {"action": "store_true", "default": argparse.SUPPRESS, "dest": self.name}
        elif get_origin(self.kind) is Literal:
            words["choices"] = get_args(self.kind)
        elif get_origin(self.kind) is tuple:
            words |= {"nargs": argparse.REMAINDER} if self.argument.takes_rest else {"action": "append"}
            words |= {"type": _named(str)} if self.argument.files else {}
        else:
            words["type"] = self.argument.parse or _reader(self.kind, is_file=bool(self.argument.files))
        if self.argument.bare is not None:
            words |= {"nargs": "?", "const": self.argument.bare}
        if self.argument.is_positional:
            words |= {"default": self.default, "nargs": None if self.is_required else "?"}
        elif self.has_one_value:
            words["action"] = "append"  # so that one that is given again is seen
        shown = self.help.replace("%", "%%")
        if self.default not in (None, False, (), ""):
            shown += f" (default: {self.default})"
        return parser.add_argument(*self.flags, help=shown, **words)

    def value(self, given: Any, parser: argparse.ArgumentParser) -> Any:
        """The option's value, of what a parser has read; exits with 2 where it has several and may have one."""
        if not isinstance(given, list):
            return given
        if not self.has_one_value:
            return tuple(given)
        if len(given) > 1:
            several = " and ".join(map(repr, given))
            parser.error(f"argument {'/'.join(self.flags)}: {several} are given, and it has one value; give one")
        return given[0]


class Command:
    """A command: called as its function is, or read from the words of a command line.

    Args:
        function: Takes the arguments as parameters, or one `NamedTuple` of them; returns the exit status.
        draws: It draws on the terminal or prints a file as it is, and so prints control characters too.
        only_reads: It reads files and prints what it finds: no robot and no model has anything to end after it.
    """

    def __init__(self, function: Callable[..., int], *, draws: bool = False, only_reads: bool = False) -> None:
        self.name, self._function = function.__name__.rstrip("_"), function
        self.draws, self.only_reads = draws, only_reads
        self._sections = _sections(function)
        self.summary, _, self._details = self._sections[""].strip().partition("\n\n")

    def __call__(self, *arguments: Any, **words: Any) -> int:
        """Do it; returns the exit status."""
        return self._function(*arguments, **words)

    def texts(self) -> dict[str, Any]:
        """The help around the arguments."""
        status, example = (
            textwrap.dedent(self._sections.get(title, "")).strip() for title in ("Exit status", "Example")
        )
        after = [f"exit status: {' '.join(status.split())}" if status else ""]
        after += [f"example:\n{textwrap.indent(example, '  ')}" if example else ""]
        about = " ".join(self._details.split())
        return {"description": f"{self.summary}\n\n{about}".strip(), "epilog": "\n\n".join(filter(None, after))}

    def read(self, words: Sequence[str]) -> dict[str, Any]:
        """What the words of a command line give to the function; exits with 2 where they are at fault."""
        parser = Parser(prog=f"rai-missions {self.name}", **self.texts())
        self.configure(parser)
        namespace, unknown = parser.parse_known_intermixed_args(words)
        if unknown:
            parser.error(f"unrecognized arguments: {' '.join(unknown)}{self._meant(unknown[0])}")
        made = {each.name: each for each in self.parameters()}
        given = {name: made[name].value(value, parser) for name, value in vars(namespace).items()}
        options = self._options()
        return given if options is None else {"options": options(**given)}

    def _meant(self, unknown: str) -> str:
        """The option that is meant by a word that is none, or the options that take a file of its ending."""
        if unknown.startswith("-"):
            from rai_missions.errors import suggestion

            return suggestion(unknown.partition("=")[0], [each.flag for each in self.parameters()])
        takers = [each.flag for each in self.parameters() if each.flags and each.argument.takes(unknown)]
        return f"; write {' or '.join(f'{flag} {unknown}' for flag in takers)}" if takers else ""

    def configure(self, parser: argparse.ArgumentParser, complete: Callable[..., object] | None = None) -> None:
        """Have a parser read its arguments.

        Args:
            parser: The parser.
            complete: What a shell completes, given patterns of files.
        """
        for parameter in self.parameters():
            action = parameter.add_to(parser)
            if complete is not None and (files := parameter.argument.files):
                action.complete = complete(*files)  # type: ignore[attr-defined]

    def parameters(self) -> list[Parameter]:
        """What it takes, in order."""
        source: Any = self._options() or self._function
        hints = {name: hint for name, hint in get_type_hints(source, include_extras=True).items() if name != "return"}
        ahead, defaults = _defaults(source, list(hints))
        _, *pairs = PARAMETER.split(textwrap.dedent(_sections(source)["Args"]))
        helps = {name: " ".join(text.split()) for name, text in zip(pairs[::2], pairs[1::2], strict=True)}
        made = []
        for number, (name, hint) in enumerate(hints.items()):
            kind, argument = _read_hint(hint)
            argument = argument._replace(is_positional=argument.is_positional or number < ahead)
            made.append(Parameter(name, kind, argument, helps[name], name not in defaults, defaults.get(name)))
        return made

    def usage_with(self, flag: str) -> str:
        """`rai-missions run [MISSION] --talk`: what to type for this option; empty where there is none of that name."""
        parameters = self.parameters()
        ahead = [each.usage for each in parameters if each.argument.is_positional]
        usages = [each.usage for each in parameters if each.flag == flag and not each.argument.is_positional]
        return " ".join(["rai-missions", self.name, *ahead, *usages]) if usages else ""

    def _options(self) -> Any:
        """The `NamedTuple` that the function takes; None where it takes the arguments themselves."""
        return get_type_hints(self._function).get("options")


def _reader(kind: Any, *, is_file: bool) -> Any:
    """What reads a word as a value of a type."""
    if is_file:
        return _named(kind)
    return partial(_number, kind) if kind in NUMBERS else kind


def _number(kind: type[int | float], text: str) -> float:
    try:
        number = kind(text)
    except ValueError:
        number = math.nan
    if math.isnan(number):
        raise argparse.ArgumentTypeError(f"{text!r} is no {NUMBERS[kind]}")
    return number


def read_speed(text: str) -> float:
    """Simulated seconds to one of the wall: a positive number, or infinity for `max`."""
    try:
        found = math.inf if text == "max" else float(text)
    except ValueError:
        found = math.nan
    if not found > 0 or (math.isinf(found) and text != "max"):
        raise argparse.ArgumentTypeError(f"'{text}' is no speed; give a positive number such as 5, or max")
    return found


def _named(kind: Any) -> Callable[[str], Any]:
    """Reads the name of a file, which is never empty: a variable of a shell that is not set must not go unnoticed."""

    def read(text: str) -> Any:
        if not text:
            raise argparse.ArgumentTypeError("the name of the file is empty; is a variable of the shell not set?")
        return kind(text)

    return read


def command(*, draws: bool = False, only_reads: bool = False) -> Callable[[Callable[..., int]], Command]:
    """Make a function a command."""
    return lambda function: Command(function, draws=draws, only_reads=only_reads)


def _sections(source: Any) -> dict[str, str]:
    """Title → text, of a docstring; what is ahead of the first title has none."""
    first, _, rest = (source.__doc__ or "").partition("\n")
    head, *found = SECTION.split(f"{first}\n{textwrap.dedent(rest)}")
    return {"": head, **dict(zip(found[::2], found[1::2], strict=True))}


def _defaults(source: Any, names: Sequence[str]) -> tuple[int, Mapping[str, Any]]:
    """How many parameters are ahead of `*`, and the defaults of those that have one."""
    if hasattr(source, "_field_defaults"):
        return 0, source._field_defaults
    ahead, last = source.__code__.co_argcount, source.__defaults__ or ()
    return ahead, {**dict(zip(names[ahead - len(last) : ahead], last, strict=True)), **(source.__kwdefaults__ or {})}


def _read_hint(hint: Any) -> tuple[Any, Argument]:
    """A type without `None`, and how it is given on the command line."""
    found, argument = hint, Argument()
    while (origin := get_origin(found)) is Annotated or NoneType in get_args(found):
        if origin is Annotated:
            found, argument = found.__origin__, found.__metadata__[0]
        else:
            (found,) = (each for each in get_args(found) if each is not NoneType)
    if origin is tuple and get_origin(each := get_args(found)[0]) is Annotated:
        return found, each.__metadata__[0]
    return found, argument
