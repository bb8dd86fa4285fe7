# SPDX-License-Identifier: Apache-2.0
"""What a client asks of a mission, read from JSON that anybody may have sent.

Rule: what comes in is data. It is bounded, each word is known, and what is wrong is reported, never raised.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rai_missions.errors import DefinitionError, suggestion
from rai_missions.event import Origin
from rai_missions.mission.json_reader import parse_json
from rai_missions.plain_data import printable
from rai_missions.redaction import Redaction, cut, redacted, shown
from rai_missions.runtime.requests import GOOD_FOR_S
from rai_missions.states.control import HOLDERS

__all__ = (
    "LONGEST",
    "ClientOrder",
    "OrderReply",
    "ReplyCallback",
    "from_ros",
    "ignore_reply",
    "lasts",
    "mapping_in",
    "overdue",
    "read_order",
    "untaken",
    "who",
)

LONGEST = 65_536
"""Characters of an order; longer ones are not read."""
LONGEST_ID = 128
LASTING = frozenset({"e_stop", "cancel", "post"})
"""Orders that are carried out however late they are taken."""
LONGEST_NAME = 64
SOFTWARE = frozenset(HOLDERS) - {"operator"}
"""Names under which the software of a robot gives orders."""


class OrderReply(NamedTuple):
    """What became of an order."""

    success: bool
    why: str = ""
    """Why not; empty, or a remark, where it was carried out."""
    id: str = ""
    dropped: bool = False
    """The run never learned of it."""


class ClientOrder(NamedTuple):
    """What a client wants of a mission, or of its run."""

    command: str
    """One of `WORDS`."""
    by: str = "operator"
    """Who wants it by their own word, for people; it grants nothing."""
    id: str = ""
    """The client's own; its reply carries it."""
    arguments: Mapping[str, Any] = {}
    to: str = ""
    question: int = 0
    run: str = ""
    """Whose question it is, where the client gives it: another run asks questions of the same numbers."""
    option: str = ""
    parameters: Mapping[str, Any] = {}
    event: str = ""
    data: Mapping[str, Any] = {}
    role: Origin = "person"
    """Whose it is, set by the door through which it came."""


WORDS: Mapping[str, Mapping[str, tuple[type, bool]]] = {
    "start": {"arguments": (dict, False)},
    "pause": {},
    "resume": {},
    "cancel": {},
    "e_stop": {},
    "control": {"to": (str, True)},
    "answer": {"question": (int, True), "run": (str, False), "option": (str, True), "parameters": (dict, False)},
    "post": {"event": (str, True), "data": (dict, False)},
}
"""Order → its words, the type of each, and whether it must be there."""
CALLED = {dict: "an object", str: "text", int: "a whole number"}


def read_order(text: Any) -> ClientOrder | OrderReply:
    """An order from its JSON, or why it is none; the reply carries the order's id where that could be read."""
    given = mapping_in(text, "an order")
    if isinstance(given, str):
        return OrderReply(False, given)
    name = given.get("id", "")
    if not isinstance(name, str | int) or isinstance(name, bool) or len(str(name)) > LONGEST_ID:
        return OrderReply(False, f"id: {shown(name)} is no text of {LONGEST_ID} characters at the most")
    why = _fault(given)
    if why:
        return OrderReply(False, why, str(name))
    words = {word: item for word, item in given.items() if word not in ("id", "by", "command")}
    return ClientOrder(given["command"], who(given.get("by", "")), str(name), **words)


def mapping_in(text: Any, what: str) -> dict[str, Any] | str:
    """The object that a text holds in JSON, or why it holds none; an empty text holds an empty one."""
    if not isinstance(text, str):
        return f"{what} is JSON text, not {shown(text)}"
    if len(text) > LONGEST:
        return f"{what} of {len(text)} characters is not read; {LONGEST} are the most"
    try:
        given = parse_json(Redaction().known(text).encode("utf-8", "replace")) if text.strip() else {}
    except DefinitionError as error:
        return cut(f"{what} is not understood: {error.faults[0]}", 300)
    return given if isinstance(given, dict) else f"{what} is a JSON object, not {shown(given)}"


def who(given: Any) -> str:
    """The name under which a client appears in the journal: one short line, `operator` where none is given."""
    text = given if isinstance(given, str) else ""
    return cut(printable(redacted(text), " "), LONGEST_NAME).strip() or "operator"


def from_ros(order: ClientOrder) -> ClientOrder:
    """An order that came over ROS, where any node may speak: the operator's, but from the software of the robot.

    Software is known by its name, which lowers what it may; no name raises it.
    """
    return order._replace(role="software" if order.by in SOFTWARE else "operator")


def lasts(order: ClientOrder) -> bool:
    """Whether an order is carried out however late it is taken: it ends something, or reports what has happened."""
    return order.command in LASTING or (order.command == "control" and order.to == "nobody")


def overdue(order: ClientOrder, waited_s: float) -> OrderReply:
    """The reply to an order that the run was too busy to take in time."""
    why = f"the run did not get to it for {waited_s:.0f} s, and it was dropped; look again, and give it again"
    return OrderReply(False, why, order.id, dropped=True)


def untaken(order: ClientOrder) -> str:
    """The reply to an order that the run has not taken yet."""
    then = "it will as soon as it can" if lasts(order) else f"unless it does within {GOOD_FOR_S:g} s, it is dropped"
    return f"the run has not taken it yet; {then}, and what became of it is reported then"


def ignore_reply(_reply: OrderReply) -> None:
    """No one asks what became of an order."""


def _fault(given: Mapping[str, Any]) -> str:
    command = given.get("command")
    if not isinstance(command, str) or command not in WORDS:
        return f"command: {shown(command)} is none{suggestion(str(command), WORDS)}"
    if not isinstance(given.get("by", ""), str):
        return f"by: {shown(given['by'])} is no text"
    words = WORDS[command]
    for word, value in given.items():
        if word in ("id", "by", "command"):
            continue
        if word not in words:
            return f"'{command}' has no word {shown(word)}{suggestion(str(word), ('id', 'by', *words))}"
        kind = words[word][0]
        if not isinstance(value, kind) or isinstance(value, bool):
            return f"{word}: {shown(value)} is not {CALLED[kind]}"
    missing = [word for word, (_, needed) in words.items() if needed and word not in given]
    return f"'{command}' needs the word '{missing[0]}'" if missing else ""


ReplyCallback = Callable[[OrderReply], None]
"""Receives once what became of an order; from any thread."""
