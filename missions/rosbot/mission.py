# SPDX-License-Identifier: Apache-2.0
"""The patrol in Python: the twin of `mission.json`."""

from __future__ import annotations

from rai_missions import After, EventSpec, Guard, Image, Key, Keys, Mission, On, Publish, Set, When
from rai_missions.states import Action, Compound, Decision, Each, Final, History, Option, State

TROUBLE = ("failed", "unverified", "timed_out", "rejected")
WAYPOINTS = [
    {"x": 1.8, "y": 6.9, "yaw": 1.57, "frame": "map"},
    {"x": 7.2, "y": 6.6, "yaw": 0.0, "frame": "map"},
    {"x": 8.7, "y": 3.2, "yaw": 0.0, "frame": "map"},
    {"x": 6.2, "y": 0.9, "yaw": -1.57, "frame": "map"},
]

k = Keys(
    waypoints=Key(list, source="argument", about="poses on the map, one after the other", initial=WAYPOINTS),
    waypoint=Key("pose", source="mission", frame="map", about="where it is going"),
    pose=Key("pose", source="robot", max_age_s=5, frame="map", about="where the localization reports it is"),
    battery=Key(float, source="robot", max_age_s=10, about="0 is empty, 1 is full"),
    supply=Key(int, source="robot", max_age_s=10, about="1 charging, 4 full, 2 neither: power_supply_status"),
    ahead_m=Key(float, source="robot", max_age_s=2, optional=True, about="how far the lidar sees straight ahead"),
    camera=Key(Image, source="robot", max_age_s=2, optional=True),
    failures=Key(int, source="mission", initial=0, about="how often it could not reach this waypoint"),
    waits=Key(int, source="mission", initial=0, about="how often it waited for this waypoint's way"),
    skipped=Key(int, source="mission", initial=0, about="waypoints that were left out"),
)

RESET = [Set(k.failures, 0), Set(k.waits, 0)]
CHARGING = k.supply.is_in([1, 4])


def dock(about: str, *succeeded: tuple[Guard | None, str]) -> Action:
    """Drive to the dock; where that leads, under which guard each."""
    transitions = [On("succeeded", to=to, when=when) for when, to in succeeded]
    return Action(
        "dock",
        about=about,
        achieved=CHARGING,
        settle_s=3,
        timeout_s=300,
        control="autonomy",
        transitions=[*transitions, On(*TROUBLE, to="stranded")],
    )


def mission() -> Mission:
    going = Action(
        "navigate",
        about="the navigation drives, plans again and recovers by itself",
        goal={"pose": k.waypoint},
        timeout_s=180,
        achieved=k.pose.near(k.waypoint, within_m=0.4),
        settle_s=1,
        control="autonomy",
        transitions=[On("succeeded", to="visited", do=RESET), On(*TROUBLE, to="deciding", do=[Set(k.failures, add=1)])],
    )
    deciding = Decision(
        "The robot cannot reach its waypoint. What should it do?",
        evidence=[k.waypoint, k.pose, k.ahead_m, k.camera, k.failures, k.waits, k.battery],
        options={
            "retry": Option("try again now", when=k.failures < 4),
            "wait": Option("wait here for 20 s, since what is in the way may go, then try again", when=k.waits < 2),
            "skip": Option("leave this waypoint out and continue to the next"),
            "ask": Option("ask a person, who may clear the way"),
            "abort": Option("go back to the dock and end the patrol"),
        },
        ask=["agent", "rules"],
        attempts=2,
        deadline_s=30,
        fallback="skip",
        control="agent",
        transitions=[
            On("retry", to="going"),
            On("wait", to="waiting"),
            On("skip", to="passed_by"),
            On("ask", to="asking"),
            On("abort", to="giving_up"),
        ],
    )
    asking = Decision(
        "The robot's way is blocked. Is it free now?",
        evidence=[k.waypoint, k.pose, k.camera],
        options={
            "go_on": Option("the way is free: try again", when=k.failures < 8),
            "leave": Option("leave this waypoint out"),
            "stop": Option("go back to the dock and end the patrol"),
        },
        ask=["operator"],
        attempts=3,
        deadline_s=120,
        fallback="leave",
        control="agent",
        entry=[Publish("ask_for_help", {"data": "My way is blocked. Can you clear it, please?"})],
        transitions=[On("go_on", to="going"), On("leave", to="passed_by"), On("stop", to="giving_up")],
    )
    on_the_way = Compound(
        initial="going",
        states={
            "going": going,
            "deciding": deciding,
            "waiting": State(entry=[Set(k.waits, add=1)], transitions=[After(20, to="going")]),
            "asking": asking,
            "resume": History("deep"),
        },
        transitions=[When((k.battery < 0.25) | ~k.battery.fresh, to="docking")],
    )
    patrolling = Each(
        "waypoints",
        item="waypoint",
        initial="on_the_way",
        states={
            "on_the_way": on_the_way,
            "docking": dock(
                "drives to the dock, because the battery runs low or is not received any more", (None, "charging")
            ),
            "charging": State(
                transitions=[
                    When(k.battery >= 0.9, to="resume"),
                    When(~k.battery.fresh, to="stranded"),
                    After(7200, to="stranded"),
                ]
            ),
            "visited": Final("succeeded"),
            "passed_by": Final(
                "succeeded", about="left out, and on to the next", entry=[Set(k.skipped, add=1), *RESET]
            ),
        },
        transitions=[On("succeeded", to="returning")],
    )
    return Mission(
        "rosbot_patrol",
        version="1.0.0",
        about="Look at every waypoint; where the way is blocked, decide what to do; charge when the battery runs low; "
        "end on the dock.",
        keys=k,
        events={"e_stop": EventSpec("someone wants the robot to stop, now")},
        initial="patrolling",
        states={
            "patrolling": patrolling,
            "returning": dock(
                "drives back to the dock; every waypoint has had its turn",
                (k.skipped == 0, "done"),
                (None, "incomplete"),
            ),
            "giving_up": dock("drives back to the dock, with the patrol not finished", (None, "aborted")),
            "done": Final("succeeded", about="every waypoint was visited, and the robot charges", requires=CHARGING),
            "incomplete": Final("failed", about="on the dock, with waypoints left out"),
            "stranded": Final(
                "failed", about="it is stuck somewhere and cannot come to its dock; a person must fetch it"
            ),
            "aborted": Final("aborted", about="ended on the dock before every waypoint had its turn"),
            "stopped": Final("aborted", about="stopped at once, because someone wanted it"),
        },
        transitions=[On("e_stop", to="stopped")],
        invariants={"never_empty": (k.battery > 0.02).or_unknown},
    )
