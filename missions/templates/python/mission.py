# SPDX-License-Identifier: Apache-2.0
"""Water the beds of a greenhouse; where a bed is neither dry nor wet, ask what to do."""

from __future__ import annotations

from rai_missions import After, Elapsed, Key, Keys, Log, Mission, On, Say, When
from rai_missions.states import Action, Call, Decision, Each, Final, Option, State, Tree, tree

k = Keys(
    beds=Key(list, source="argument", initial=["herbs", "tomatoes", "beans"], about="in this order"),
    bed=Key(str, initial="", about="the bed that is next"),
    at=Key(str, source="robot", max_age_s=2, about="the bed at which the robot is"),
    moisture=Key(float, source="robot", max_age_s=5, about="of the soil there: 0 is dry, 1 is wet"),
    tank_l=Key(float, source="robot", max_age_s=10, about="litres in the tank"),
    dry=Key(int, source="robot", max_age_s=5, about="beds that are still dry"),
)
TROUBLE = ("failed", "rejected", "timed_out", "unverified")


def mission() -> Mission:
    """The mission that `rai-missions` loads."""
    return Mission(
        "my_mission",
        version="0.1.0",
        about="Water the beds of a greenhouse; where a bed is neither dry nor wet, ask what to do.",
        keys=k,
        initial="watering",
        states={
            "watering": Each(
                k.beds,
                item=k.bed,
                initial="going",
                states={
                    "going": Action(
                        "go_to",
                        goal={"bed": k.bed},
                        timeout_s=60,
                        achieved=k.at == k.bed,
                        settle_s=1,
                        transitions=[On("succeeded", to="measuring")],
                    ),
                    "measuring": State(
                        about="the sensor needs half a second in the soil",
                        transitions=[
                            When(Elapsed(0.5) & (k.moisture < 0.3), to="pouring"),
                            When(Elapsed(0.5) & (k.moisture >= 0.6), to="over"),
                            After(1, to="judging"),
                        ],
                    ),
                    "judging": Decision(
                        "The soil is neither dry nor wet. Should this bed get water?",
                        about="the only place where a model or a person decides",
                        evidence=[k.bed, k.moisture, k.tank_l],
                        options={
                            "water": Option("a litre now", when=(k.moisture < 0.6) & (k.tank_l >= 1)),
                            "leave": Option("no water; it has enough until tomorrow"),
                        },
                        ask=["agent", "rules", "operator"],
                        deadline_s=20,
                        fallback="leave",
                        transitions=[On("water", to="pouring"), On("leave", to="over", do=Log("left as it is"))],
                    ),
                    "pouring": Tree(
                        tree.Sequence(
                            [
                                tree.Selector(
                                    [tree.Check(k.tank_l >= 1), tree.Call("refill", timeout_s=10)], memory=True
                                ),
                                tree.Action("pour", goal={"litres": 1.0}, timeout_s=20),
                            ]
                        ),
                        timeout_s=60,
                        transitions=[On("succeeded", to="over")],
                    ),
                    "over": Final("succeeded"),
                },
                transitions=[On("succeeded", to="tidying"), On(*TROUBLE, to="unfinished", do=Say("Please help me."))],
            ),
            "tidying": Call(
                "close_valve",
                timeout_s=5,
                transitions=[On("succeeded", to="done"), On("failed", "rejected", "timed_out", to="unfinished")],
            ),
            "done": Final("succeeded", requires=k.dry == 0),
            "unfinished": Final("aborted"),
        },
        settle_s=1,
    )
