# SPDX-License-Identifier: Apache-2.0
"""Missions whose work is one tree of 18 to 23 nodes, as their authors write them; `bench_prove` proves them.

`FETCH`: two branches side by side, retries, guards and a decision. `INSPECT`: a watch over the battery next to the
work. `DELIVER`: one thing after the other, with fallbacks and a decision.
"""

from __future__ import annotations

from typing import Any

__all__ = ("DELIVER", "TREE_MISSIONS")


def around(name: str, blackboard: dict[str, Any], tree: dict[str, Any]) -> dict[str, Any]:
    """A mission that does one tree, and what is around it: a low battery, an e-stop, a door that a person opens."""
    return {
        "format": 1,
        "name": name,
        "version": "1.0.0",
        "blackboard": {
            "battery": {"type": "number", "source": "robot", "max_age_s": 10},
            "done": {"type": "boolean", "source": "robot", "max_age_s": 5},
            **blackboard,
        },
        "events": {"stop": {}},
        "initial": "working",
        "states": {
            "working": {
                "tree": tree,
                "timeout_s": 600,
                "transitions": [
                    {
                        "when": {"any": [{"key": "battery", "<": 0.2}, {"not": {"fresh": "battery"}}]},
                        "to": "home",
                    },
                    {"on": "succeeded", "to": "finished"},
                    {"on": ["failed", "timed_out"], "to": "home"},
                ],
            },
            "home": {
                "action": "go_home",
                "timeout_s": 120,
                "transitions": [{"on": ["succeeded", "failed", "rejected", "timed_out"], "to": "given_up"}],
            },
            "finished": {"final": "succeeded", "requires": {"key": "done", "==": True}, "settle_s": 2},
            "given_up": {"final": "aborted"},
        },
        "transitions": [{"on": "stop", "to": "given_up"}],
    }


FETCH = around(
    "fetch",
    {
        "holding": {"type": "boolean", "source": "robot", "max_age_s": 2},
        "blocked": {"type": "boolean", "source": "robot", "max_age_s": 2},
        "tries": {"type": "integer", "initial": 0},
    },
    {
        "sequence": [
            {
                "parallel": [
                    {"retry": 2, "child": {"timeout": 60, "child": {"action": "drive", "goal": {"to": "shelf"}}}},
                    {
                        "sequence": [
                            {"call": "open_gripper", "timeout_s": 3},
                            {
                                "selector": [
                                    {"retry": 2, "child": {"action": "raise_arm", "timeout_s": 20}},
                                    {"action": "home_arm", "timeout_s": 30},
                                ],
                                "memory": True,
                            },
                        ]
                    },
                ]
            },
            {
                "selector": [
                    {
                        "sequence": [
                            {"check": {"key": "blocked", "==": False}},
                            {
                                "retry": 3,
                                "child": {
                                    "action": "pick",
                                    "timeout_s": 20,
                                    "achieved": {"key": "holding", "==": True},
                                },
                            },
                        ]
                    },
                    {
                        "decision": {
                            "question": "The part cannot be picked. What now?",
                            "options": {
                                "push": {"about": "push what blocks it away", "when": {"key": "tries", "<": 2}},
                                "leave": {"about": "leave it"},
                            },
                            "ask": ["agent"],
                            "deadline_s": 20,
                            "fallback": "leave",
                        },
                        "then": {
                            "push": {
                                "sequence": [
                                    {"set": "tries", "add": 1},
                                    {"action": "push", "timeout_s": 10},
                                    {"action": "pick", "timeout_s": 20, "achieved": {"key": "holding", "==": True}},
                                ]
                            },
                        },
                    },
                ]
            },
            {"timeout": 90, "child": {"action": "drive", "goal": {"to": "table"}}},
        ]
    },
)

INSPECT = around(
    "inspect",
    {
        "at_site": {"type": "boolean", "source": "robot", "max_age_s": 2},
        "clear": {"type": "boolean", "source": "robot", "max_age_s": 1},
        "photos": {"type": "integer", "initial": 0},
    },
    {
        "parallel": [
            {
                "sequence": [
                    {
                        "selector": [
                            {"check": {"key": "at_site", "==": True}},
                            {"retry": 2, "child": {"action": "drive", "timeout_s": 120}},
                        ]
                    },
                    {"eternal_guard": {"key": "clear", "==": True}, "child": {"action": "raise_mast", "timeout_s": 40}},
                    {
                        "repeat": 2,
                        "child": {
                            "sequence": [
                                {"retry": 2, "child": {"call": "take_photo", "timeout_s": 5}},
                                {"set": "photos", "add": 1},
                            ]
                        },
                    },
                    {"action": "lower_mast", "timeout_s": 40},
                ]
            },
            {
                "sequence": [
                    {"call": "lights_on", "timeout_s": 2},
                    {"call": "record", "timeout_s": 300},
                    {"call": "lights_off", "timeout_s": 2},
                ]
            },
        ],
        "policy": [0],
    },
)
DELIVER = around(
    "deliver",
    {
        "loaded": {"type": "boolean", "source": "robot", "max_age_s": 2},
        "door": {"type": "string", "source": "robot", "max_age_s": 2},
        "detours": {"type": "integer", "initial": 0},
    },
    {
        "sequence": [
            {
                "selector": [
                    {"check": {"key": "loaded", "==": True}},
                    {
                        "retry": 2,
                        "child": {"action": "load", "timeout_s": 60, "achieved": {"key": "loaded", "==": True}},
                    },
                ],
                "memory": True,
            },
            {
                "selector": [
                    {
                        "sequence": [
                            {"check": {"key": "door", "==": "open"}},
                            {"timeout": 60, "child": {"action": "pass_door"}},
                        ]
                    },
                    {"sequence": [{"call": "open_door", "timeout_s": 10}, {"action": "pass_door", "timeout_s": 60}]},
                    {
                        "decision": {
                            "question": "The door stays shut. What now?",
                            "options": {
                                "detour": {"about": "take the long way", "when": {"key": "detours", "<": 1}},
                                "ask": {"about": "ask a person for help"},
                                "give_up": {"about": "go home"},
                            },
                            "ask": ["agent", "operator"],
                            "deadline_s": 30,
                            "fallback": "give_up",
                        },
                        "then": {
                            "detour": {
                                "sequence": [
                                    {"set": "detours", "add": 1},
                                    {"action": "long_way", "timeout_s": 300},
                                ]
                            },
                            "ask": {
                                "sequence": [
                                    {"call": "page", "timeout_s": 5},
                                    {"action": "pass_door", "timeout_s": 300},
                                ]
                            },
                            "give_up": {"check": {"key": "loaded", "==": False}},
                        },
                    },
                ],
                "memory": True,
            },
            {"retry": 2, "child": {"action": "unload", "timeout_s": 60, "achieved": {"key": "loaded", "==": False}}},
        ]
    },
)
TREE_MISSIONS = {each["name"]: each for each in (FETCH, INSPECT, DELIVER)}
"""Name → a mission."""
