# SPDX-License-Identifier: Apache-2.0
"""Small missions, each with two regions that one thing connects."""

from __future__ import annotations

from typing import Any

__all__ = ("CONNECTED", "among_others", "mission", "region")

Json = dict[str, Any]
FAILED = ["failed", "timed_out", "rejected"]


def region(name: str, first: list[Json], second: list[Json], **more: Json) -> Json:
    """Two states, `a` and `b`."""
    a, b = {"transitions": first, **more.get("a", {})}, {"transitions": second, **more.get("b", {})}
    return {"initial": f"{name}a", "states": {f"{name}a": a, f"{name}b": b, f"{name}end": {"final": "succeeded"}}}


def mission(left: Json, right: Json, outer: list[Json] | None = None, **words: Any) -> Json:
    """Two regions, and an event that ends all.

    Args:
        left: A region.
        right: A region.
        outer: Transitions around them.
        words: The words of the mission, in place of others.
    """
    back = "over" if "on_cancel" in words else "after"
    clear: Json = {"type": "boolean", "source": "robot", "max_age_s": 3}
    around = [{"on": "succeeded", "to": "over"}, {"on": "failed", "to": back}, *(outer or [])]
    return {
        "format": 1,
        "name": "connected",
        "version": "1.0.0",
        "initial": "work",
        "blackboard": {
            "n": {"type": "integer", "initial": 0},
            "armed": {"type": "boolean", "initial": False},
            **({"clear": clear} if "'clear'" in repr((left, right)) else {}),
        },
        "events": {event: {} for event in ("l", "r", "k", "both", "stop")},
        "states": {
            "work": {"parallel": {"left": left, "right": right}, "transitions": around},
            "after": {"transitions": [{"on": "both", "to": "work"}]},
            "over": {"final": "aborted"},
        },
        "transitions": [{"on": "stop", "to": "over"}],
        **words,
    }


def moves(name: str, event: str, **words: Any) -> Json:
    """There and back by an event."""
    return region(name, [{"on": event, "to": f"{name}b", **words}], [{"on": event, "to": f"{name}a"}])


def onward(name: str, event: str, back: str) -> Json:
    """Two states further by an event, and back by another."""
    third = {"transitions": [{"on": back, "to": f"{name}a"}]}
    two = region(name, [{"on": event, "to": f"{name}b"}], [{"on": event, "to": f"{name}c"}])
    return {**two, "states": {**two["states"], f"{name}c": third}}


def ending(name: str, event: str, **words: Any) -> Json:
    """There, and to the end."""
    return region(name, [{"on": event, "to": f"{name}b"}], [{"on": event, "to": f"{name}end", **words}])


def acting(name: str, action: str, event: str) -> Json:
    """An action, again and again."""
    ends = [{"on": "succeeded", "to": f"{name}b"}, {"on": FAILED, "to": f"{name}b"}]
    return region(name, ends, [{"on": event, "to": f"{name}a"}], a={"action": action, "timeout_s": 3})


def among_others(document: Json) -> Json:
    """The same with a region before and one behind the second, each of which comes to its end."""
    work = document["states"]["work"]
    left, right = work["parallel"].values()
    other = region("x", [{"on": "x", "when": ARMED, "to": "xend"}, {"after_s": 7, "to": "xend"}], [])
    regions = {"left": left, "other": other, "right": right, "last": ending("y", "y")}
    states = {**document["states"], "work": {**work, "parallel": regions}}
    return {**document, "events": {**document["events"], "x": {}, "y": {}}, "states": states}


BOTH: Json = {"all": [{"in": "lb"}, {"in": "rc"}]}
AROUND: dict[str, Json] = {
    "by an event": {"on": "k", "when": BOTH}, "without one": {"when": BOTH},
    "by time": {"after_s": 3, "when": {"any": [{"in": "lc"}, {"not": {"in": "rb"}}]}},
    "after a while": {"when": {"held": BOTH, "for_s": 2}},
}  # fmt: skip
"""When a rule around two regions fires → the rule."""
ARMED: Json = {"key": "armed", "==": True}
ARM: list[Json] = [{"set": "armed", "value": True}]
OVER: Json = {"on_cancel": "over"}
CONNECTED: dict[str, Json] = {
    "nothing": mission(moves("l", "l"), moves("r", "r")),
    "a guard that names the other's state": mission(moves("l", "l"), moves("r", "r", when={"in": "lb"})),
    "a rule without an event that does": mission(
        moves("l", "l"), region("r", [{"when": {"in": "lb"}, "to": "rb"}], [{"on": "r", "to": "ra"}])
    ),
    "an event of both": mission(moves("l", "both"), moves("r", "both")),
    "an event that one raises": mission(moves("l", "l", do=[{"raise": "r"}]), moves("r", "r")),
    "a key that one writes and the other waits for": mission(
        moves("l", "l", do=ARM),
        region("r", [{"when": ARMED, "to": "rb"}], [{"on": "r", "to": "ra", "do": [{"set": "armed", "value": False}]}]),
    ),
    "a key that one writes and the other comes to wait for": mission(
        moves("l", "l", do=ARM),
        region("r", [{"on": "r", "to": "rb"}], [{"when": ARMED, "to": "ra", "do": [{"set": "armed", "value": False}]}]),
    ),
    "a key that one writes and the other asks for": mission(moves("l", "l", do=ARM), moves("r", "r", when=ARMED)),
    "a key of the robot": mission(
        region("l", [{"when": {"key": "clear", "==": True}, "to": "lb"}], [{"on": "l", "to": "la"}]),
        region("r", [{"when": {"key": "clear", "==": False}, "to": "rb"}], [{"on": "r", "to": "ra"}]),
    ),
    "a key of the robot that may go stale while the other waits": mission(
        region("l", [{"when": {"not": {"fresh": "clear"}}, "to": "lb"}], [{"on": "l", "to": "la"}]),
        region("r", [{"after_s": 2, "to": "rb"}], [{"on": "r", "to": "ra"}]),
    ),
    "actions that exclude each other": mission(acting("l", "lift", "l"), acting("r", "lift", "r")),
    "their end": mission(ending("l", "l"), ending("r", "r")),
    "their ends, in two ways": mission(
        {
            **(left := ending("l", "l")),
            "states": {
                **left["states"],
                "lb": {"transitions": [{"on": "l", "to": "lend"}, {"on": "k", "to": "lfailed"}]},
                "lfailed": {"final": "failed"},
            },
        },
        {
            **(other := ending("r", "r")),
            "states": {
                **other["states"],
                "rb": {"transitions": [{"on": "r", "to": "rend"}, {"on": "both", "to": "rfailed"}]},
                "rfailed": {"final": "failed"},
            },
        },
        outer=[],
        transitions=[{"on": "stop", "to": "after"}],
    ),
    "their end, and what it requires": mission(
        ending("l", "l", do=ARM),
        {
            **(right := ending("r", "r")),
            "states": {**right["states"], "rend": {"final": "succeeded", "requires": ARMED}},
        },
    ),
    "what each does as it is left": mission(
        region("l", [{"on": "l", "to": "lb"}], [{"on": "l", "to": "la"}], b={"exit": [{"set": "n", "add": 1}]}),
        moves("r", "r"),
        [{"on": "k", "to": "after"}],
        invariants={"few": {"key": "n", "<": 3}},
    ),
    "a rule around them that names a state": mission(
        moves("l", "l"), moves("r", "r"), [{"on": "k", "when": {"in": "lb"}, "to": "after"}]
    ),
    "a rule around them without an event that names a state": mission(
        moves("l", "l"), moves("r", "r", do=ARM), [{"when": {"all": [{"in": "lb"}, ARMED]}, "to": "over"}]
    ),
    **{
        f"a rule around them, {what}, that names both": mission(
            onward("l", "l", "stop"), onward("r", "r", "both"), [{**rule, "to": "after"}]
        )
        for what, rule in AROUND.items()
    },
    "an invariant that names both": mission(
        moves("l", "l"), moves("r", "r"), invariants={"one": {"not": {"all": [{"in": "lb"}, {"in": "rb"}]}}}
    ),
    "an invariant over a state and a key": mission(
        moves("l", "l"), moves("r", "r", do=ARM), invariants={"one": {"not": {"all": [{"in": "lb"}, ARMED]}}}
    ),
    "what may be read later": mission(
        region("l", [{"on": "l", "when": ARMED, "to": "lend"}, {"on": "k", "to": "lend"}], []),
        region("r", [{"on": "r", "do": ARM, "to": "rend"}], []),
        [{"on": "both", "to": "over"}],
    ),
    "what both may read later": mission(
        region("l", [{"on": "l", "when": ARMED, "to": "lb"}, {"on": "k", "to": "lb"}], []),
        region("r", [{"on": "r", "when": ARMED, "to": "rb"}, {"on": "r", "to": "rb"}], []),
        [{"on": "both", "do": ARM}],
        **OVER,
    ),
    "a service that is called like a state of the other": mission(
        moves("l", "l", do=[{"call": "la"}]),
        region("r", [{"on": "r", "to": "rb"}], [{"on": ["r", "call_failed"], "to": "ra"}]),
    ),
    "an event that rules around them raise and handle": mission(
        onward("l", "l", "both"),
        onward("r", "r", "r"),
        [{"on": "k", "do": [{"raise": "l"}, {"raise": "l"}]}, {"on": "l", "do": [{"log": "stays"}]}],
    ),
    "an event that comes later": mission(
        region("l", [{"on": "l", "to": "lb", "do": [{"raise": "k", "after_s": 2}]}], [{"on": "k", "to": "la"}]),
        moves("r", "r"),
    ),
    "an event that a rule around them has come later": mission(
        moves("l", "l"), moves("r", "r"), [{"on": "both", "do": [{"raise": "k", "after_s": 2}]}]
    ),
    "an end that a rule around them takes away": mission(
        region("l", [{"on": "l", "to": "lb"}, {"on": "k", "to": "over"}], []),
        region("r", [{"on": "r", "to": "rb"}, {"on": "both", "to": "over"}], []),
        [{"on": "stop", "do": [{"log": "stays"}]}],
    ),
    "two events that come later under one id": mission(
        region(
            "l",
            [{"on": "l", "to": "lb", "do": [{"raise": "k", "after_s": 2, "id": "x"}]}],
            [{"on": "k", "to": "over"}, {"on": "l", "to": "la"}],
        ),
        region(
            "r",
            [{"on": "r", "to": "rb", "do": [{"raise": "both", "after_s": 2, "id": "x"}]}],
            [{"on": "both", "to": "rend"}, {"on": "r", "to": "ra"}],
        ),
    ),
    "the order in which they began": mission(
        acting("l", "lift", "l"),
        region(
            "r",
            [{"on": "r", "to": "rb"}],
            [{"on": "succeeded", "to": "ra"}, {"on": FAILED, "to": "ra"}],
            b={"action": "look", "timeout_s": 3},
        ),
    ),
}
"""What connects the regions → the mission."""
