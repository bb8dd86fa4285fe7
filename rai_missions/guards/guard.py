# SPDX-License-Identifier: Apache-2.0
"""What a guard is: a condition over what is known, true, false or unknown, written as data and compiled once."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar, NoReturn, TypeAlias

from rai_missions.errors import MissionError, UsageError, in_words, raised_text
from rai_missions.guards.analysis import Distinctions, Sources, TypeFault, Types
from rai_missions.guards.expression import EXAMPLE, WORDS, meant_guard
from rai_missions.guards.form import Atom, Form
from rai_missions.guards.purity import impurity
from rai_missions.guards.view import Site, Test, Truth
from rai_missions.model import HasPath, TaggedModel
from rai_missions.redaction import clipped, shown

__all__ = ("BRACKETS", "DEEP", "Guard", "GuardOrKey", "RaisedBefore", "foreign_truth", "form_of", "made", "text_of")

BRACKETS = "put brackets around comparisons: (k.battery < 0.2) & k.moving"
"""For an author in Python, where `&` and `|` bind before `<`."""
DEEP = 60
"""Guards nested deeper than this are compared for equality only."""


class Guard(TaggedModel, family="guard", group="rai_missions.guards"):
    """A condition as data. `&`, `|` and `~` combine guards; `held_for(2)` wants one to have been true for 2 s.

    All that is special about a kind is in its file. What is not overridden is true of any guard: it is not taken
    apart, unknown while something that it reads is unknown, and rests on nothing that the robot reported.
    """

    meant: ClassVar[Mapping[str, str]] = WORDS
    fades: ClassVar[bool] = True
    """It is unknown while a key that it reads is missing or stale."""
    age_s: ClassVar[float | None] = None
    """The age of its state that it asks for."""
    held_s: ClassVar[float] = 0.0
    """For how long a guard inside it must have been true."""

    def why_unusable(self) -> str:
        """Why its line of words is of no use; empty where it is."""
        line: Any = self.words()
        return "" if isinstance(line, str) else f"'words' gives {shown(line, by=clipped)}, which is no text"

    def type_faults(self, types: Types) -> Iterator[TypeFault]:
        """Why it cannot be evaluated, by the types of what it reads."""
        return iter(())

    def form(self, wanted: bool, depth: int) -> Form:
        """When it is true or, not `wanted`, when it is false, in normal form; see `form_of`."""
        return Atom("other", text_of(self), "" if wanted else "not", None)

    def rests(self, sources: Sources, *, wanted: bool = True) -> bool:
        """Whether it can be true (or, not `wanted`, false) only by what the robot reported."""
        return False

    def noticed(self, *, wanted: bool = True) -> frozenset[str]:
        """The keys whose going stale makes it true (or, not `wanted`, false)."""
        return frozenset()

    def after_jump(self, active: Callable[[str], Truth], *, restarted: bool) -> Truth:
        """The guard's value right after a jump, by the configuration alone; None where facts decide.

        Args:
            active: Whether a state is active then.
            restarted: The state whose transition it guards has just been entered.
        """
        return None

    def looked_into(self) -> str:
        """The key whose fields alone make it true or false; empty where there is none."""
        return ""

    def counts_inside(self, counts: Truth) -> Truth:
        """Which value of the guards inside it counts where this value of its own does; None: each counts."""
        return None

    def distinguish(self, by: Distinctions) -> None:
        """Report to a proof which values make a difference."""
        for path in self.paths():
            by.sample(path)

    def paths(self) -> Iterator[str]:
        """The paths that it reads itself, without those of the guards inside it."""
        return (name for refers, name, _ in self.references() if refers.sort == "path")

    def states(self) -> frozenset[str]:
        """The states that it asks for itself."""
        return frozenset(name for refers, name, _ in self.references() if refers.sort == "state")

    def predicates(self) -> frozenset[str]:
        """The predicates of the user's program that it names itself."""
        return frozenset(name for refers, name, _ in self.references() if refers.sort == "predicate")

    def fading(self) -> Iterator[str]:
        """The keys that make it unknown when they are missing or stale."""
        for guard in self.walk():
            if guard.fades:
                yield from (path.partition(".")[0] for path in guard.paths())

    def compile(self, site: Site) -> Test:
        """A function from a view to true, false or unknown; `site` learns what it depends on."""
        raise NotImplementedError

    def compiled(self, site: Site, counts: Truth = None) -> Test:
        """What `compile` makes, for the engine: a guard of another package is unknown where it raises, with a note.

        Args:
            site: Where it is compiled.
            counts: See `Site.counts`.

        Raises:
            UsageError: That package's `compile` raises.
        """
        site.set_counts(counts)
        if type(self) not in Guard.foreign:
            test = self.compile(site)
            site.set_counts(counts)
            return site.asked(self, test)
        try:
            test = self.compile(site)
        except MissionError:
            raise
        except (Exception, SystemExit) as error:
            whose = f"the guard '{self.word}' of {type(self).__module__}"
            raise UsageError(f"{whose} raised {in_words(error)} as it was compiled") from error
        return lambda view: foreign_truth(lambda: test(view), self.word, view.note)

    def inner(self) -> Iterator[Guard]:
        """The guards it is made of."""
        return (guard for _, guard in self.inside())

    def walk(self) -> Iterator[Guard]:
        """This guard and all the guards inside it, outermost first."""
        yield self
        for guard in self.inner():
            yield from guard.walk()

    def words(self) -> str:
        """The guard in words, in a line."""
        raise NotImplementedError

    def __and__(self, other: Guard) -> Guard:
        if not isinstance(other, Guard):  # a reference; it knows what it means
            return NotImplemented
        return made("all", all=(self, other))

    def __or__(self, other: Guard) -> Guard:
        if not isinstance(other, Guard):
            return NotImplemented
        return made("any", any=(self, other))

    def __invert__(self) -> Guard:
        return made("not", guard=self)

    def held_for(self, seconds: float) -> Guard:
        """True once this has been true for so long without a break."""
        return made("held", held=self, for_s=seconds)

    @classmethod
    def admit(cls, kind: type[Any]) -> str:
        return super().admit(kind) or _lack(kind) or impurity(kind)

    @classmethod
    def choose(cls, data: Mapping[str, Any]) -> str:
        """`{"key": …, "in": […]}` is a comparison, and so with `goal`, though `in` alone asks for a state."""
        return next((word for word in ("key", "goal") if word in data), "") or super().choose(data)

    @classmethod
    def remedy(cls, data: Any) -> str:
        """The guard that an expression in text most likely means, or an example of one."""
        meant = meant_guard(data) if isinstance(data, str) else None
        if meant is None:
            return f"; write it like {json.dumps(EXAMPLE)}"
        return f"; write {json.dumps(meant, ensure_ascii=False)}"

    @classmethod
    def read(cls, data: Any) -> Any:
        """In Python a bare reference means `== true`."""
        return super().read({"key": path, "==": True} if (path := getattr(data, "__path__", None)) else data)

    @property
    def or_unknown(self) -> Guard:
        """True where this is true or unknown."""
        return made("possible", possible=self)

    def __uncompared(self, other: object) -> NoReturn:
        raise TypeError(f"a guard is compared with nothing; {BRACKETS}")

    __lt__ = __le__ = __gt__ = __ge__ = __uncompared

    def __uncombined(self, other: object) -> NoReturn:
        raise TypeError(f"{other!r} is no guard; {BRACKETS}")

    __rand__ = __ror__ = __uncombined

    def __bool__(self) -> bool:
        raise TypeError("a guard has no truth of its own; combine guards with & | ~, not with and, or, not")


def _lack(kind: type[Guard]) -> str:
    lacks = [f"'{name}'" for name in ("compile", "words") if getattr(kind, name) is getattr(Guard, name)]
    return f"it lacks {' and '.join(lacks)}" if lacks else ""


class RaisedBefore(Exception):
    """What a predicate raised in the run that is replayed; its text is the note of then."""


def foreign_truth(ask: Callable[[], object], word: str, note: Callable[[str], object]) -> Truth:
    """What code of others makes of a guard: unknown, with a note, where it raises or returns no truth."""
    try:
        value = ask()
        if value is None or isinstance(value, bool):
            return value
        raise TypeError(f"it returned {clipped(repr(value), 60)}; give True, False, or None for unknown")
    except RaisedBefore as error:
        note(str(error))
        return None
    except (Exception, SystemExit) as error:  # noqa: BLE001 - the code of a user or of another package
        note(f"guard '{word}' raised {raised_text(error)}")
        return None


GuardOrKey: TypeAlias = Guard | HasPath
"""Where an author writes a guard: one, or a reference to a boolean key, which means `== true`."""


def made(word: str, **words: Any) -> Guard:
    """A guard of the kind that has a word."""
    guard: Guard = Guard.kinds[word](**words)
    return guard


def form_of(guard: Guard, wanted: bool, depth: int) -> Form:
    """When a guard is true or, not `wanted`, when it is false; `depth` is that of the guards around it."""
    if depth > DEEP:
        return Atom("other", f"#{id(guard)}", "" if wanted else "not", None)
    return guard.form(wanted, depth + 1)


def text_of(guard: Guard) -> str:
    """The text of a guard, equal for guards that are written alike; one that is nested too deep equals only itself."""
    if sum(1 for _ in itertools.islice(guard.walk(), DEEP)) == DEEP:
        return f"{id(guard)}"
    return json.dumps(guard.written(), sort_keys=True, default=str)
