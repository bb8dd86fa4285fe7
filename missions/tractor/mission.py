# SPDX-License-Identifier: Apache-2.0
"""The tractor's mission in Python: the twin of `mission.json`."""

from __future__ import annotations

from rai_missions import After, CallEffect, EventSpec, Image, In, Key, Keys, Mission, On, Say, Set, When
from rai_missions.states import Action, Call, Compound, Decision, Final, History, Option, State, Tree, tree

TROUBLE = ("failed", "unverified", "timed_out")

k = Keys(
    alleys=Key(
        int, source="argument", initial=6, about="how many alleys are to be driven, with those that were driven before"
    ),
    alleys_driven=Key(int, source="robot", max_age_s=5, about="alleys driven from end to end, by pose"),
    at_home=Key(bool, source="robot", max_age_s=5, about="it is where it set out"),
    autonomy_state=Key(
        str, source="robot", max_age_s=5, about="the word in which the autonomy stack reports what it does"
    ),
    battery=Key(float, source="robot", max_age_s=10, about="0 is empty, 1 is full"),
    camera=Key(Image, source="robot", max_age_s=1),
    obstacle=Key(
        dict,
        source="robot",
        max_age_s=0.5,
        optional=True,
        fields={
            "kind": str,
            "distance_m": float,
            "height_m": float,
            "living": bool,
            "solid_max_m": float,
            "sure": float,
        },
        about="what the detector sees in the alley",
    ),
    passed=Key(
        bool,
        source="robot",
        max_age_s=5,
        optional=True,
        about="the tractor is past the last obstacle, which lies where it lay",
    ),
    touched_living=Key(bool, source="robot", max_age_s=5, about="a person or an animal was touched"),
    crossings=Key(int, source="mission", initial=0, about="attempts to get past this obstacle"),
    signals=Key(int, source="mission", initial=0, about="how often the tractor signalled at this obstacle"),
    unfinished=Key(bool, source="mission", initial=False, about="alleys are left that cannot be driven"),
)

NOTHING_HARD = k.obstacle.solid_max_m < 0.04
LOW_WOOD = (k.obstacle.solid_max_m < 0.25) & k.obstacle.kind.is_in(["branch", "log"]) & (k.obstacle.sure >= 0.7)
MOVING = ["REVERSING", "CHANGING_PATH", "DRIVING"]
HALT = CallEffect("halt")
GIVE_UP = Set(k.unfinished, True)


def mission() -> Mission:
    return Mission(
        "tractor_orchard",
        version="1.6.0",
        about="Work the alleys; when the autonomy stack stops for an anomaly, decide and carry on.",
        keys=k,
        events={
            "anomaly": EventSpec("the autonomy stack stopped and asks for a decision"),
            "e_stop": EventSpec("someone wants the tractor to stop, now"),
        },
        initial="setting_out",
        states={
            "setting_out": State(
                about="checks that alleys are left to drive",
                transitions=[
                    When((k.alleys_driven >= k.alleys) | ~k.alleys_driven.fresh, to="nothing_to_do"),
                    When(k.alleys_driven < k.alleys, to="working"),
                ],
            ),
            "working": Compound(
                initial="driving",
                control="autonomy",
                states={
                    "driving": Action(
                        "drive_alleys",
                        about="the autonomy stack drives alley after alley",
                        achieved=k.alleys_driven >= k.alleys,
                        timeout_s=900,
                        transitions=[
                            On("anomaly", to="assessing", do=[Set(k.signals, 0), Set(k.crossings, 0)]),
                            On("succeeded", to="done"),
                            On("uncertain", to="looking"),
                            On("rejected", to="looking", do=[Set(k.crossings, add=1)]),
                            On(*TROUBLE, to="returning", do=[GIVE_UP]),
                        ],
                    ),
                    "resume": History("deep"),
                },
            ),
            "assessing": Decision(
                "Something blocks the alley. What should the tractor do?",
                evidence=[k.obstacle, k.camera, k.signals, k.crossings],
                options={
                    "drive_over": Option(
                        "drive on, over the obstacle",
                        when=~k.obstacle.living & (k.crossings < 2) & (NOTHING_HARD | LOW_WOOD),
                    ),
                    "replan": Option("leave this alley, take another, and come back later from the other end"),
                    "signal": Option("sound the horn and flash the lights, wait, then look again", when=k.signals < 3),
                    "abort": Option("stop here for good and call a person"),
                },
                ask=["agent", "operator", "rules"],
                attempts=2,
                deadline_s=20,
                fallback="abort",
                control="agent",
                transitions=[
                    On("drive_over", to="crossing"),
                    On("replan", to="replanning"),
                    On("signal", to="signalling"),
                    On("abort", to="given_up"),
                ],
            ),
            "crossing": Action(
                "cross",
                about="drives over the obstacle, as long as it is not alive",
                achieved=k.passed,
                settle_s=1,
                timeout_s=30,
                control="agent",
                entry=[Set(k.crossings, add=1)],
                transitions=[
                    When(k.obstacle.living, to="assessing"),
                    On("succeeded", to="resume", do=[Set(k.crossings, 0)]),
                    On("uncertain", "rejected", to="looking"),
                    On(*TROUBLE, to="assessing"),
                ],
            ),
            "replanning": Call(
                "replan",
                about="backs out of the alley",
                timeout_s=10,
                control="agent",
                transitions=[
                    On("uncertain", to="looking"),
                    On("succeeded", to="leaving"),
                    On("failed", "timed_out", "rejected", to="returning", do=[GIVE_UP]),
                ],
            ),
            "leaving": State(
                about="the autonomy stack reports whether there is an alley left to take",
                control="agent",
                transitions=[
                    When(k.alleys_driven >= k.alleys, to="done"),
                    When(k.autonomy_state.is_in(MOVING), to="resume"),
                    When((k.autonomy_state == "FINISHED") | ~k.autonomy_state.fresh, to="returning", do=[GIVE_UP]),
                    After(10, to="looking", do=[Set(k.crossings, add=1)]),
                ],
            ),
            "looking": State(
                about="an order was refused, or its outcome is unknown: waits a moment for new readings",
                control="agent",
                transitions=[When(k.alleys_driven >= k.alleys, to="done"), After(3, to="going_on")],
            ),
            "going_on": State(
                about="continues as the readings allow",
                control="agent",
                transitions=[
                    When(
                        (k.crossings >= 2) | (k.autonomy_state == "FINISHED") | ~k.autonomy_state.fresh,
                        to="returning",
                        do=[GIVE_UP],
                    ),
                    When(k.autonomy_state.is_in(MOVING), to="resume"),
                    When(k.obstacle.fresh, to="assessing"),
                    When(k.camera.fresh, to="resume"),
                    When(~k.camera.fresh, to="returning", do=[GIVE_UP]),
                ],
            ),
            "signalling": Tree(
                tree.Sequence([tree.Call("horn", timeout_s=2), tree.Wait(5)]),
                about="sounds the horn and waits; the alley counts as free where a working camera sees nothing",
                timeout_s=10,
                control="agent",
                entry=[Set(k.signals, add=1)],
                transitions=[
                    When((~k.obstacle.fresh).held_for(2) & k.camera.fresh, to="resume"),
                    On("succeeded", "failed", "timed_out", to="assessing"),
                ],
            ),
            "returning": Action(
                "go_home",
                about="drives home, out of everybody's way",
                achieved=k.at_home,
                settle_s=2,
                timeout_s=300,
                control="autonomy",
                transitions=[
                    On("succeeded", when=k.unfinished, to="unfinished_home"),
                    On("succeeded", to="aborted"),
                    On(*TROUBLE, "rejected", to="stranded"),
                ],
            ),
            "done": Final(
                "succeeded", about="every alley is driven", requires=k.alleys_driven >= k.alleys, entry=[HALT]
            ),
            "nothing_to_do": Final(
                "failed",
                about="every alley was driven before, or their count is not received: this run drove none",
            ),
            "unfinished_home": Final("failed", about="came home with alleys left"),
            "stranded": Final(
                "failed",
                about="it is stuck somewhere and cannot come home; a person must fetch it",
                entry=[HALT, Say("I cannot come home. A person must fetch me.")],
            ),
            "given_up": Final(
                "aborted",
                about="stopped in its alley for good; a person is called and must come",
                entry=[HALT, Say("I have stopped here for good. A person must come.")],
            ),
            "aborted": Final("aborted", about="came home before the work was done"),
            "stopped": Final(
                "aborted", about="stopped at once: for an e-stop, or because its touch sensor fell silent", entry=[HALT]
            ),
        },
        transitions=[
            On("e_stop", to="stopped"),
            When(~k.touched_living.fresh, to="stopped"),
            When(~In("returning") & ((k.battery < 0.15) | ~k.battery.fresh), to="returning"),
        ],
        invariants={
            "nobody_is_driven_over": ~(In("crossing") & k.obstacle.living),
            "nothing_living_is_touched": ~k.touched_living,
        },
    )
