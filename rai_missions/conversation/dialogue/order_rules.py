# SPDX-License-Identifier: Apache-2.0
"""Orders, judged like proposals: permitted for the role, possible now, and whether a person must confirm them."""

from __future__ import annotations

from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.language.run_words import state_of_run
from rai_missions.conversation.outputs import Mapper
from rai_missions.conversation.settings import Settings
from rai_missions.conversation.view import StatusView
from rai_missions.engine.modes import next_mode
from rai_missions.event import Role

__all__ = (
    "OLD_S", "TWO_NEEDED", "binding", "forbidden", "is_request", "may", "must_confirm", "where_to_order", "why_not_now",
    "why_not_permitted",
)  # fmt: skip

TWO_NEEDED = frozenset({"start", "resume", "cancel"})
"""The spoken orders that two recognisers must agree on; so must they on the confirming yes."""
IN_ANY_MODE = frozenset({"cancel", "answer"})
"""Orders that mean the same in each mode of a run that is under way: a pause or resume meanwhile leaves them valid."""
OLD_S = 10.0
"""An order of so long ago does not count; the clocks of two machines differ by less."""
CONFIRMED = frozenset({"start", "cancel"})


def may(role: Role, what: str, settings: Settings) -> bool:
    """Whether a role has a permission, by its name; a role that is not listed may do nothing."""
    return what in settings.may.get(role, frozenset())


def forbidden(sense: Sense, role: Role, settings: Settings) -> str:
    """The first of its orders that a role may not give; empty where it may give all."""
    return next((each.name for each in sense.orders if not may(role, each.name, settings)), "")


def why_not_permitted(order: str, role: Role, channel: str, settings: Settings, language: Language) -> str:
    """The refusal, and where the order can be given."""
    where = where_to_order(settings, language)
    return language.text(
        "not_permitted",
        channel=language.word("channels", channel),
        role=language.word("roles", role),
        order=language.word("order_names", order),
        where=where,
    )


def where_to_order(settings: Settings, language: Language) -> str:
    """The channels at which an operator is met, in words."""
    return language.listed([language.word("operator_channels", each) for each in settings.answer_at], "or")


def is_request(sense: Sense, view: StatusView) -> bool:
    """Whether it is a start that has to wait for the end of the mission that runs."""
    return sense.name == "start" and view.is_alive and not view.is_before_start


def why_not_now(sense: Sense, view: StatusView, language: Language) -> str:
    """Why an order is not possible in this moment, in words; empty where it is."""
    if not _is_possible(sense, view):
        return language.text(f"why_not_{sense.name}", state=state_of_run(view, language))
    if sense.name == "answer" and view.offer(sense.question, sense.option) is None:
        return language.text("bad_option", given=spoken(sense.option), question="").strip()
    return ""


def _is_possible(sense: Sense, view: StatusView) -> bool:
    """Whether the mode of the run lets an order be carried out; a run that has not begun has nothing to pause."""
    if sense.name == "stop":
        return True
    if sense.name == "start":
        return _can_start(sense, view)
    if sense.name == "answer":
        return bool(view.questions) and view.is_alive
    is_held_back = sense.name == "pause" and view.awaits_start and view.mode == "ready"
    return next_mode(view.mode, sense.name) is not None and not is_held_back


def _can_start(sense: Sense, view: StatusView) -> bool:
    if view.mission_named(sense.mission) is None:
        return False
    return not view.is_alive or (view.is_before_start and sense.mission == view.mission)


def must_confirm(sense: Sense, view: StatusView, *, mapper: Mapper, agreeing: int | None) -> bool:
    """Whether the order is read back before it counts; of several, all where one is.

    Args:
        sense: The order.
        view: The run.
        mapper: What read the sentence.
        agreeing: Of a spoken one, how many recognisers agree on it; None for a typed one.
    """
    return mapper != "grammar" or any(_must_confirm(each, view, agreeing) for each in sense.orders)


def _must_confirm(sense: Sense, view: StatusView, agreeing: int | None) -> bool:
    if sense.is_partial or sense.name in CONFIRMED:
        return True
    if sense.name != "answer":
        return False
    return (sense.question, sense.option) in view.confirm or (agreeing is not None and agreeing < 2)


def binding(sense: Sense, view: StatusView) -> tuple[object, ...]:
    """What a confirmation rests on: where it differs later, what was read back is void."""
    is_open = sense.name != "answer" or view.question(sense.question) is not None
    is_any = sense.name in IN_ANY_MODE or is_request(sense, view)
    mode = "any" if is_any and next_mode(view.mode, "cancel") else view.mode
    return view.run, mode, view.mission, is_open
