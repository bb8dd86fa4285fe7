# SPDX-License-Identifier: Apache-2.0
"""The errors a caller can meet, by who mends them, and words for what was given, what there is and what installs it.

Also what every package may use before anything else is loaded: its public names, each imported at its first use.

Rule: a refused proposal, an ignored event and a failed action are values, never one of these.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple
from unicodedata import combining, normalize

__all__ = (
    "ConnectorError",
    "DefinitionError",
    "Fault",
    "MissionError",
    "UsageError",
    "article",
    "counted",
    "escaped",
    "file_text",
    "in_words",
    "install_command",
    "irregular",
    "lazy_names",
    "make_folder_of",
    "meant",
    "meant_file",
    "nearest",
    "one_line",
    "pointer",
    "raised_text",
    "steps_of",
    "suggestion",
    "uncalled",
    "unescaped",
    "without_marks",
)


class Fault(NamedTuple):
    """One thing wrong in a mission, profile or journal, and where."""

    place: str
    """JSON pointer (RFC 6901) into the document; empty for the document itself."""
    sentence: str
    """What is wrong, what was given, and what would be right."""
    file: str = ""
    """The file that the place is in, where it is another than that of the other faults."""

    def __str__(self) -> str:
        return f"{self.place or '/'}: {self.sentence}"


class MissionError(Exception):
    """The base of the errors of `rai_missions`; any other exception is a fault of its own."""


class DefinitionError(MissionError):
    """A mission, profile or journal is at fault: all faults at once, for its author to mend.

    Args:
        faults: At least one fault, in document order.
        source: The file the faults are in, if it came from one.
    """

    def __init__(self, faults: Iterable[Fault], source: str = "") -> None:
        self.faults = tuple(faults)
        self.source = source
        lines = (f"{file}: {fault}" if (file := fault.file or source) else str(fault) for fault in self.faults)
        super().__init__("\n".join(lines))

    def __reduce__(self) -> tuple[type[DefinitionError], tuple[tuple[Fault, ...], str]]:
        """Made again of its faults, not of its text, when it is copied or comes out of another process."""
        return type(self), (self.faults, self.source)


class UsageError(MissionError):
    """A call is at fault, for the caller to mend: a name that does not exist, a call at the wrong time."""


class ConnectorError(MissionError):
    """The world outside is at fault: no such server, a message of the wrong shape."""


def nearest(given: str, known: Iterable[str]) -> str:
    """The name that was probably meant: the only one of which it is the beginning, or else a similar one; or empty."""
    import difflib  # heavy, and needed for a fault alone

    names = sorted(set(known))
    longer = [name for name in names if len(given) > 2 and name.startswith(given)]
    close = longer if len(longer) == 1 else difflib.get_close_matches(given, names, n=1, cutoff=0.6)
    return next(iter(close), "")


def counted(number: int, word: str) -> str:
    """`1 scene`, `2 scenes`: a number of things, for a sentence."""
    return f"{number} {word}{'' if number == 1 else 's'}"


def article(word: str) -> str:
    """A word with its article: `an event`, `a state`."""
    return f"{'an' if word[0] in 'aeiou' else 'a'} {word}"


def suggestion(given: str, known: Iterable[str]) -> str:
    """`; did you mean 'x'?`, or the names that there are, for the end of a sentence."""
    known = sorted(set(known))
    if close := nearest(given, known):
        return f"; did you mean '{close}'?"
    shown = ", ".join(known[:12]) + (", …" if len(known) > 12 else "")
    return f"; there is: {shown}" if shown else ""


def meant_file(path: str | os.PathLike[str], *endings: str) -> str:
    """`; did you mean 'x.json'?` for a file that is not there, or what a folder has of its kind."""
    folder, name = os.path.split(path)
    is_folder = os.path.isdir(path)
    try:
        found = os.listdir(path if is_folder else folder or ".")
    except (OSError, ValueError):  # no such folder, closed, or a name that no file can have
        return ""
    names = [each for each in found if each.endswith(endings) and each.isprintable()]
    if is_folder:
        return suggestion("", names)
    close = nearest(name, names)
    return f"; did you mean {os.path.join(folder, close)!r}?" if close else ""


def without_marks(text: str) -> str:
    """A text in small letters, without accents: ö is o and a mark."""
    return "".join(each for each in normalize("NFKD", text.casefold()) if not combining(each))


def uncalled(given: object) -> str:
    """`; write Action(…)` for a class or function where what it makes is due; empty for all else."""
    name = getattr(given, "__name__", "") if callable(given) else ""
    return f"; write {name}(…)" if name.isidentifier() else ""


def meant(error: BaseException) -> str:
    """`; did you mean 'x'?` for a wrong attribute or name in someone's program; empty for any other error.

    Errors that are raised in here have a suggestion of their own.
    """
    frame = _frame_of(error)
    if frame is None or str(frame.f_globals.get("__name__")).partition(".")[0] == __package__:
        return ""
    try:
        if isinstance(error, AttributeError) and error.name:
            given, known = error.name, dir(error.obj)
        elif isinstance(error, NameError) and error.name:
            given, known = error.name, [*frame.f_locals, *frame.f_globals, *frame.f_builtins]
        else:
            return ""
        near = nearest(given, [each for each in known if not each.startswith("_")])
    except Exception:  # noqa: BLE001 - it is asked of objects that may be anybody's
        return ""
    return f"; did you mean '{near}'?" if near else ""


def _frame_of(error: BaseException) -> FrameType | None:
    """Where it was raised."""
    last = error.__traceback__
    while last is not None and last.tb_next is not None:
        last = last.tb_next
    return last.tb_frame if last is not None else None


def in_words(what: object) -> str:
    """The text of an exception, or of anything given as a reason; its type where there is no text."""
    try:
        text = str(what)
    except Exception:  # noqa: BLE001 - it may be anybody's, and raise anything
        text = f"a {type(what).__name__} that cannot be put in words"
    return str.__str__(text)


def raised_text(error: BaseException) -> str:
    """`KeyError: 'x'`: the type of what was raised and its text; the type alone where it has none."""
    name, text = type(error).__name__, in_words(error)
    return f"{name}: {text}" if text else name


def escaped(word: object) -> str:
    """A step of a JSON pointer (RFC 6901)."""
    text = str(word)
    return text if text.isidentifier() else text.replace("~", "~0").replace("/", "~1")


def unescaped(step: str) -> str:
    """What a step of a JSON pointer names."""
    return step.replace("~1", "/").replace("~0", "~")


def steps_of(place: str) -> tuple[str, ...]:
    """The steps of a JSON pointer: what `pointer` was given, as texts."""
    return tuple(map(unescaped, place.split("/")[1:]))


def pointer(steps: Iterable[str | int]) -> str:
    """A JSON pointer (RFC 6901) in one line."""
    return one_line("".join(f"/{escaped(step)}" for step in steps))


def file_text(path: str | os.PathLike[str]) -> str:
    """The name of a file as one line of text, for what is stored, sent or shown.

    Bytes of it that are no UTF-8 are written out, and so is what no line shows.
    """
    return one_line(os.fsencode(path).decode("utf-8", "backslashreplace"))


def one_line(text: str) -> str:
    """A text with what no line shows written as its escape: a line break, half a character, a space of no width."""
    if text.isprintable():
        return text
    return "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in text)


SORTS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a named pipe (FIFO)"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def irregular(path: Path | str) -> str:
    """What there is instead of a regular file, links followed: a folder, a named pipe (FIFO), a socket or a device.

    Empty for a regular file, and where there is nothing or it cannot be known. Nothing is opened or can block.
    """
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return ""
    return next((name for is_so, name in SORTS if is_so(mode)), "")


def make_folder_of(path: Path | str) -> None:
    """Make the folder of a file that is to be written, and those around it, where there are none.

    Raises:
        NotADirectoryError: One of them is a file; the system reports the innermost as one that exists.
        OSError: They cannot be made.
    """
    folder = Path(path).parent
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(folder)) from None


def lazy_names(
    scope: dict[str, Any], rooms: Mapping[str, Iterable[str]]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """The `__getattr__` and `__dir__` (PEP 562) of a package or a module that offers names of others.

    Args:
        scope: Its `globals()`, where a name is kept once it was used.
        rooms: Module below the package → the names that it offers; `Call as CallEffect` has another name here.
    """
    homes = {
        each.rpartition(" as ")[2]: (room, each.partition(" as ")[0]) for room, names in rooms.items() for each in names
    }

    def load(name: str) -> Any:
        if name not in homes:
            near = "" if name.startswith("_") else suggestion(name, {*homes, *scope.get("__all__", ())})
            raise AttributeError(f"module {scope['__name__']!r} has no attribute {name!r}{near}")
        room, own = homes[name]
        return scope.setdefault(name, getattr(import_module(f".{room}", scope["__package__"]), own))

    return load, lambda: sorted({*scope, *homes})


PACKAGE = "rai-missions"


def install_command(extra: str, origin: Mapping[str, Any] | None = None, here: Path | None = None) -> str:
    """The line that installs an extra from where this package came from.

    Args:
        extra: Its name.
        origin: The package's `direct_url.json` (PEP 610); None: as it is here.
        here: The folder in which the line is typed; None: the present one.
    """
    from urllib.parse import urlsplit  # loaded where something is missing
    from urllib.request import url2pathname

    came = _origin() if origin is None else origin
    url = str(came.get("url", ""))
    if "vcs_info" in came:
        return f"pip install '{PACKAGE}[{extra}] @ {came['vcs_info']['vcs']}+{url}@{came['vcs_info']['commit_id']}'"
    if "dir_info" not in came:
        return f"pip install '{PACKAGE}[{extra}]{f' @ {url}' if url else ''}'"
    folder = Path(url2pathname(urlsplit(url).path))
    return f"pip install '{'.' if folder == (here or Path.cwd()) else folder}[{extra}]'"


def _origin() -> Mapping[str, Any]:
    import json
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        found: Mapping[str, Any] = json.loads(distribution(PACKAGE).read_text("direct_url.json") or "{}")
    except PackageNotFoundError:
        return {}
    return found
