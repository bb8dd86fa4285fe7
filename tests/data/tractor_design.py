# SPDX-License-Identifier: Apache-2.0
"""The tractor of the guide, in Python: the twin of `tractor_design.json`."""

from __future__ import annotations

from rai_missions import Image, In, Key, Keys, Mission, On, Set, When
from rai_missions.mission.mission import EventSpec
from rai_missions.states import Action, Call, Compound, Decision, Final, History, Option, Tree, tree

k = Keys(
    alleys=Key(int, source="argument", initial=6),
    alleys_driven=Key(int, source="robot", max_age_s=5),
    at_home=Key(bool, source="robot", max_age_s=5),
    battery=Key(float, source="robot", max_age_s=10),
    camera=Key(Image, source="robot", max_age_s=1),
    obstacle=Key(
        dict,
        source="robot",
        max_age_s=0.5,
        optional=True,
        fields={"kind": str, "distance_m": float, "height_m": float, "living": bool},
    ),
    passed=Key(bool, source="robot", max_age_s=5, optional=True),
    signals=Key(int, source="mission", initial=0),
)


def mission() -> Mission:
    return Mission(
        "tractor_orchard",
        version="1.0.0",
        about="Work the alleys; when the autonomy stack stops for an anomaly, decide and carry on.",
        keys=k,
        events={"anomaly": EventSpec("the autonomy stack stopped and asks for a decision")},
        initial="working",
        states={
            "working": Compound(
                initial="driving",
                control="autonomy",
                states={
                    "driving": Action(
                        "drive_alleys",
                        timeout_s=900,
                        achieved=k.alleys_driven >= k.alleys,
                        transitions=[
                            On("anomaly", to="assessing", do=[Set(k.signals, 0)]),
                            On("succeeded", to="done"),
                        ],
                    ),
                    "resume": History("deep"),
                },
            ),
            "assessing": Decision(
                "Something blocks the alley. What should the tractor do?",
                evidence=[k.obstacle, k.camera],
                options={
                    "drive_over": Option(
                        "drive on, over the obstacle", when=~k.obstacle.living & (k.obstacle.height_m < 0.25)
                    ),
                    "replan": Option("leave this alley and take the next one"),
                    "signal": Option("sound the horn and flash the lights, then look again", when=k.signals < 3),
                    "abort": Option("stop here and call a person"),
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
                    On("abort", to="aborted"),
                ],
            ),
            "crossing": Action(
                "cross",
                control="agent",
                timeout_s=30,
                achieved=k.passed,
                transitions=[
                    When(k.obstacle.living, to="assessing"),
                    On("succeeded", to="resume"),
                    On("failed", "unverified", "timed_out", to="assessing"),
                ],
            ),
            "replanning": Call("replan", control="agent", timeout_s=60, transitions=[On("succeeded", to="resume")]),
            "signalling": Tree(
                tree.Sequence([tree.Call("horn", timeout_s=2), tree.Wait(5)]),
                control="agent",
                timeout_s=10,
                entry=[Set(k.signals, add=1)],
                transitions=[When(~k.obstacle.fresh, to="resume"), On("succeeded", "failed", to="assessing")],
            ),
            "returning": Action(
                "go_home",
                control="autonomy",
                timeout_s=300,
                achieved=k.at_home,
                transitions=[On("succeeded", to="aborted")],
            ),
            "done": Final("succeeded", requires=k.alleys_driven >= k.alleys),
            "aborted": Final("aborted"),
        },
        transitions=[When(~In("returning") & ((k.battery < 0.15) | ~k.battery.fresh), to="returning")],
        invariants={"nobody_is_driven_over": ~(In("crossing") & k.obstacle.living)},
    )
