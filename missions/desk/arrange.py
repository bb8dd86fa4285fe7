# SPDX-License-Identifier: Apache-2.0
"""An arm that arranges what lies on a desk, in Python: the twin of `arrange.json`."""

from __future__ import annotations

from typing import Any

from rai_missions import After, EventSpec, Image, Key, Keys, Mission, On, Publish, Set, When
from rai_missions.guards import Fresh, GoalIs, Held
from rai_missions.planning import goal_schema
from rai_missions.states import Decision, Final, Option, Plan, Read, State, Tree, tree

TROUBLE = ("failed", "timed_out")
MOST_MOVES = 30
MOST_FAILURES = 4

k = Keys(
    request=Key(str, source="argument", initial="stack the cubes", about="what the person wants, in free words"),
    objects=Key(
        dict,
        source="robot",
        max_age_s=1.5,
        about="what the camera sees on the desk, and whether the gripper is empty",
        fields={"things": list, "gripper": str, "unsure": int, "looks": int, "stamp_s": float},
    ),
    gripper=Key(
        dict,
        source="robot",
        max_age_s=1,
        about="how far the gripper is open, and what its fingers feel",
        fields={"width_m": float, "holding": bool, "left_n": float, "right_n": float},
    ),
    camera=Key(Image, source="robot", max_age_s=2, optional=True, about="the desk, seen from the front"),
    sentence=Key(str, source="mission", initial="", about="what is read: the request, or how the person put it again"),
    reading=Key(
        dict,
        source="mission",
        about="what the grammar reads in the request",
        fields={"goal": dict, "question": str, "candidates": list, "reason": str, "about": str, "covers_all": bool},
    ),
    wanted=Key(dict, source="mission", about="the goal: relations between things"),
    proposed=Key(dict, source="mission", about="the goal that a model reads in the request; the person is asked"),
    plan=Key(
        dict,
        source="mission",
        about="the moves that lead from what is seen to the goal, each with what it assumes",
        fields={"moves": list, "next": dict, "reason": str, "about": str, "avoided": list, "aside": dict},
    ),
    place_refused=Key(bool, source="mission", initial=False, about="the last thing was not set down at its place"),
    report=Key(str, source="mission", initial="", about="why it was not done, in a sentence"),
    moves=Key(int, source="mission", initial=0, about="moves that were begun"),
    failures=Key(int, source="mission", initial=0, about="moves, one after the other, that did not end as planned"),
)

REACHED = GoalIs(k.wanted, over=k.objects)
REPORT = Publish("report", message={"data": k.report})


def understanding() -> dict[str, State]:
    """From the request to a goal: the grammar, a model, the person."""
    proposal = {"type": "object", "properties": {"goal": goal_schema()}, "required": ["goal"]}
    asked = GoalIs("answer.goal", is_="said", in_=k.sentence, over=k.objects)
    feasible = GoalIs("answer.goal", over=k.objects, is_="feasible")
    return {
        "looking_first": State(
            about="the camera looks until the things are known",
            entry=[Set(k.sentence, from_=k.request)],
            transitions=[
                When((k.objects.looks >= 10) & Held(k.objects.unsure == 0, for_s=1), to="reading"),
                After(20, to="blind"),
            ],
        ),
        "reading": Read(
            k.sentence,
            over=k.objects,
            into=k.reading,
            about="by rule: a goal, a question to the person, or a refusal",
            transitions=[
                On("succeeded", to="judging", do=[Set(k.wanted, from_=k.reading.goal)]),
                On("unclear", to="asking_model"),
                On("refused", to="refused", do=[Set(k.report, from_=k.reading.about)]),
                On("rejected", to="blind"),
            ],
        ),
        "asking_model": Decision(
            "What does the person want to be so on the desk? Answer with a goal over the things that are seen.",
            about="the grammar reads the request in more than one way, or in none",
            evidence=[k.sentence, k.reading, k.objects, k.camera],
            options={
                "propose": Option(
                    "the request means this goal; the person is asked whether it does", parameters=proposal
                ),
                "ask": Option("it is not clear, or nothing that an arm should do at a desk"),
            },
            ask=["agent"],
            attempts=1,
            deadline_s=30,
            fallback="ask",
            transitions=[
                On("propose", when=asked & feasible, to="confirming", do=[Set(k.proposed, from_="answer.goal")]),
                On("propose", "ask", to="asking"),
            ],
        ),
        "confirming": Decision(
            "Is this what you want?",
            about="what a model reads counts only once the person confirms it",
            evidence=[k.sentence, k.proposed],
            options={"yes": Option("yes, do that"), "no": Option("no")},
            ask=["operator"],
            deadline_s=60,
            fallback="no",
            transitions=[On("yes", to="judging", do=[Set(k.wanted, from_=k.proposed)]), On("no", to="asking")],
        ),
        "asking": Decision(
            "What should be so on the desk? I am not sure what was meant.",
            about="the person puts it in other words, or leaves it",
            evidence=[k.sentence, k.reading],
            options={
                "say": Option(
                    "which one was meant ('the second', 'the green one'), or the request in other words",
                    parameters={
                        "type": "object",
                        "properties": {"request": {"type": "string", "maxLength": 500}},
                        "required": ["request"],
                    },
                ),
                "leave": Option("leave the desk as it is"),
            },
            ask=["operator"],
            deadline_s=120,
            fallback="leave",
            transitions=[
                On("say", to="reading", do=[Set(k.sentence, from_="answer.request")]),
                On("leave", to="not_understood"),
            ],
        ),
    }


def arranging() -> dict[str, State]:
    """One move after the other, and a look after each."""
    move: dict[str, Any] = {"object": k.plan.next.object}
    return {
        "judging": State(
            about="is it so, can it be so?",
            transitions=[
                When(~k.objects.fresh, to="sightless"),
                When(REACHED, to="settling"),
                When((k.moves >= MOST_MOVES) | (k.failures >= MOST_FAILURES), to="gave_up"),
                When(~REACHED, to="planning"),
                After(10, to="planning"),
            ],
        ),
        "settling": State(
            about="it is as wanted; does it stay so for a moment?",
            transitions=[
                When(Held(REACHED, for_s=1.2) & (k.reading.covers_all == True), to="reading_again"),  # noqa: E712
                When(Held(REACHED, for_s=1.2), to="done"),
                When(~REACHED, to="looking", do=[Set(k.failures, add=1)]),
                After(5, to="looking", do=[Set(k.failures, add=1)]),
            ],
        ),
        "reading_again": Read(
            k.sentence,
            over=k.objects,
            into=k.reading,
            about="what was hidden at first, or in the hand, may be meant, too",
            transitions=[
                On("succeeded", to="comparing", do=[Set(k.wanted, from_=k.reading.goal)]),
                On("unclear", when=Fresh(k.plan.aside) & (k.moves == 0), to="asking"),
                On(
                    "unclear",
                    "refused",
                    "rejected",
                    when=k.failures < MOST_FAILURES,
                    to="looking_closer",
                    do=[Set(k.failures, add=1)],
                ),
                On("unclear", "refused", to="impossible", do=[Set(k.report, from_=k.reading.about)]),
                On("rejected", to="blind"),
            ],
        ),
        "looking_closer": State(
            about="what is seen now leaves open what was meant: the camera looks again, and nothing is done until then",
            transitions=[After(1.6, to="reading_again")],
        ),
        "comparing": State(
            about="is it so of all that are seen now?",
            transitions=[
                When(REACHED, to="done"),
                When(~REACHED, to="judging"),
                After(5, to="looking", do=[Set(k.failures, add=1)]),
            ],
        ),
        "sightless": State(
            about="the camera has not measured the things; it may again",
            transitions=[When(Held(k.objects.fresh, for_s=1), to="judging"), After(20, to="blind")],
        ),
        "planning": Plan(
            k.wanted,
            over=k.objects,
            into=k.plan,
            asked=k.sentence,
            refused=k.place_refused,
            about="the moves from what is seen to the goal; a place that the arm refused is left for another",
            transitions=[
                On("succeeded", "failed", when=Fresh(k.plan.aside), to="putting_aside"),
                On("succeeded", when=k.objects.gripper == "holding", to="looking", do=[Set(k.failures, add=1)]),
                On(
                    "succeeded",
                    when=Fresh(k.plan.next),
                    to="moving",
                    do=[Set(k.moves, add=1)],
                ),
                On("succeeded", to="looking", do=[Set(k.failures, add=1)]),
                On("failed", when=k.plan.reason == "unclear", to="looking", do=[Set(k.failures, add=1)]),
                On("failed", when=k.moves == 0, to="refused", do=[Set(k.report, from_=k.plan.about)]),
                On("failed", to="impossible", do=[Set(k.report, from_=k.plan.about)]),
                On("rejected", to="sightless"),
            ],
        ),
        "moving": Tree(
            tree.Sequence(
                [
                    tree.Retry(
                        tree.Sequence(
                            [
                                tree.Action("pick", goal={**move, "pose": k.plan.next.pick}, timeout_s=40),
                                tree.Check(k.gripper.holding == True),  # noqa: E712
                            ]
                        ),
                        2,
                    ),
                    tree.Selector(
                        [
                            tree.Action("place", goal={**move, "pose": k.plan.next.place}, timeout_s=40),
                            tree.Sequence(
                                [
                                    tree.Set(k.place_refused, True),
                                    tree.SuccessIsFailure(
                                        tree.Selector(
                                            [
                                                tree.Action(
                                                    "place", goal={**move, "pose": pose}, timeout_s=40, name=name
                                                )
                                                for name, pose in (
                                                    ("put back", k.plan.next.pick),
                                                    ("put aside", k.plan.next.spare),
                                                )
                                            ],
                                            memory=True,
                                        )
                                    ),
                                ],
                                memory=True,
                            ),
                        ],
                        memory=True,
                    ),
                ]
            ),
            about="the next move of the plan: picked, held, and set down there, or where it was, or where it is free",
            entry=[Set(k.place_refused, False)],
            timeout_s=120,
            transitions=[
                On("succeeded", to="looking", do=[Set(k.failures, 0)]),
                On(*TROUBLE, to="looking", do=[Set(k.failures, add=1)]),
            ],
        ),
        "putting_aside": Tree(
            tree.Sequence(
                [
                    tree.FailureIsSuccess(
                        tree.Action("place", goal={"object": "held", "pose": k.plan.aside}, timeout_s=40)
                    ),
                    tree.Wait(1.6),
                ]
            ),
            about="what is in the hand is set down where it is free, and the camera looks",
            timeout_s=90,
            transitions=[
                On("succeeded", *TROUBLE, when=k.moves == 0, to="reading_again", do=[Set(k.failures, add=1)]),
                On("succeeded", *TROUBLE, to="judging", do=[Set(k.failures, add=1)]),
            ],
        ),
        "looking": State(
            about="the camera looks again, and the plan follows what it sees",
            transitions=[After(1.6, to="judging")],
        ),
    }


def ends() -> dict[str, Final]:
    return {
        "done": Final("succeeded", about="the camera sees that it is as wanted", requires=REACHED),
        "refused": Final("aborted", about="the request cannot be met; nothing was moved", entry=[REPORT]),
        "not_understood": Final("aborted", about="the request was not understood; nothing was moved"),
        "impossible": Final("failed", about="what is wanted cannot be reached any more", entry=[REPORT]),
        "gave_up": Final("failed", about="too many moves did not end as planned"),
        "blind": Final("failed", about="the camera does not see the desk"),
        "stopped": Final("aborted", about="stopped at once, because someone wanted it"),
    }


def mission() -> Mission:
    return Mission(
        "desk_arrange",
        version="1.0.0",
        about="Arrange what lies on a desk as a person asks for in free words: sort, stack, swap, put things on, in or "
        "next to others; and know by the camera whether it is so.",
        keys=k,
        events={"e_stop": EventSpec("someone wants the arm to stop, now")},
        initial="looking_first",
        states={**understanding(), **arranging(), **ends()},
        transitions=[On("e_stop", to="stopped")],
    )
