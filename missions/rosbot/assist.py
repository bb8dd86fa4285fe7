# SPDX-License-Identifier: Apache-2.0
"""The helper in the house in Python: the twin of `assist.json`."""

from __future__ import annotations

from typing import Any

from rai_missions import After, EventSpec, Guard, Image, In, Key, Keys, Mission, On, Publish, Set, When
from rai_missions.states import Action, Compound, Decision, Each, Final, Option, State

TROUBLE = ("failed", "unverified", "timed_out", "rejected")

k = Keys(
    task=Key(str, source="argument", initial="find", about="what to do: go, find, look, wait or come_back"),
    object=Key(
        str, source="argument", initial="cup", about="what to find, by its name: a kind, or a colour and a kind"
    ),
    place=Key(
        str,
        source="argument",
        initial="kitchen",
        about="where: kitchen, living_room, bedroom, study, pantry; house (every room) to find; here to look or wait",
    ),
    wait_s=Key(int, source="argument", initial=30, minimum=1, maximum=3600, about="how many seconds to wait there"),
    things=Key(
        str,
        source="argument",
        initial="ball, book, bottle, bowl, chair, cup, lamp, person, plant",
        about="what it looks for when it looks around",
    ),
    views=Key(list, source="mission", initial=[], about="the poses from which it sees the place, one after the other"),
    view=Key("pose", source="mission", frame="map", about="where it is going"),
    report=Key(
        str, source="mission", initial="", about="what it reports: what it sees, where, and how certain that is"
    ),
    pose=Key("pose", source="robot", max_age_s=5, frame="map", about="where the localization reports it is"),
    battery=Key(float, source="robot", max_age_s=10, about="0 is empty, 1 is full"),
    supply=Key(int, source="robot", max_age_s=10, about="1 charging, 4 full, 2 neither: power_supply_status"),
    ahead_m=Key(float, source="robot", max_age_s=2, optional=True, about="how far the lidar sees straight ahead"),
    camera=Key(Image, source="robot", max_age_s=2, optional=True, about="what the camera sees"),
    sighting=Key(
        dict,
        source="robot",
        max_age_s=1.5,
        optional=True,
        about="the most certain of the things that it looks for and sees now",
        fields={
            "object": str,
            "x": float,
            "y": float,
            "z": float,
            "distance_m": float,
            "certainty": float,
            "agreeing": int,
            "looks": int,
            "room": str,
            "on": str,
            "text": str,
        },
    ),
    seen=Key(
        dict,
        source="robot",
        max_age_s=1.5,
        optional=True,
        about="what most of its looks from here agree on",
        fields={"looks": int, "count": int, "text": str},
    ),
    failures=Key(int, source="mission", initial=0, about="how often it could not get to this view"),
    waits=Key(int, source="mission", initial=0, about="how often it waited for the way to this view"),
    sight_waits=Key(int, source="mission", initial=0, about="how often it waited for this view to be free"),
    waited_s=Key(int, source="mission", initial=0, about="how many seconds it has waited"),
    skipped=Key(int, source="mission", initial=0, about="views that were left out"),
)


def pose(x: float, y: float, yaw: float) -> dict[str, Any]:
    return {"x": x, "y": y, "yaw": yaw, "frame": "map"}


VIEWS = {
    "kitchen": [pose(3.9, 3.1, -2.16), pose(3.9, 2.3, -1.25)],
    "living_room": [pose(1.6, 6.9, -0.6), pose(2.5, 7.2, 3.14), pose(3.2, 5.3, -0.5)],
    "bedroom": [pose(6.4, 6.6, 0.0), pose(6.6, 6.4, 2.3)],
    "study": [pose(7.0, 3.2, 3.14)],
    "pantry": [pose(8.7, 3.2, -1.57)],
}
EVERY_ROOM = [view for room in ("kitchen", "study", "pantry", "bedroom", "living_room") for view in VIEWS[room]]
RESET = [Set(k.failures, 0), Set(k.waits, 0), Set(k.sight_waits, 0)]
MOST_SIGHT_WAITS = 2
CHARGING = k.supply.is_in([1, 4])
FOUND = (k.sighting.object == k.object) & (k.sighting.certainty >= 0.76)
LOOKED = k.camera.fresh & (k.seen.looks >= 4)
HAS_LOOKED = k.seen.looks >= 3
HIDDEN = (k.sighting.object == "person") | (k.ahead_m < 0.8)
UNSEEN = ~k.sighting.fresh | (k.sighting.object != k.object)


def look_for(names: Any) -> Publish:
    """Have the object finder look for names; an empty text ends it."""
    return Publish("look_for", message={"data": names})


def room(guard: Guard, views: list[dict[str, Any]]) -> Any:
    return When(guard, to="at_place", do=[Set(k.views, views)])


def dock(about: str, to: str) -> Action:
    return Action(
        "dock",
        about=about,
        achieved=CHARGING,
        settle_s=3,
        timeout_s=300,
        control="autonomy",
        transitions=[On("succeeded", to=to), On(*TROUBLE, to="stranded")],
    )


def choosing() -> State:
    here = k.place == "here"
    return State(
        about="reads the order",
        transitions=[
            When(k.task == "come_back", to="coming_back"),
            When(~k.task.is_in(["go", "find", "look", "wait"]), to="refused"),
            When((k.task == "find") & (k.object == ""), to="refused"),
            When((k.task == "wait") & here, to="waiting"),
            When((k.task == "look") & here, to="looking_around"),
            room(k.place == "kitchen", VIEWS["kitchen"]),
            room(k.place == "living_room", VIEWS["living_room"]),
            room(k.place == "bedroom", VIEWS["bedroom"]),
            room(k.place == "study", VIEWS["study"]),
            room(k.place == "pantry", VIEWS["pantry"]),
            room((k.task == "find") & (k.place == "house"), EVERY_ROOM),
            After(0, to="refused"),
        ],
    )


def on_the_way() -> Compound:
    going = Action(
        "navigate",
        about="the navigation drives, plans again and recovers by itself",
        goal={"pose": k.view},
        timeout_s=180,
        achieved=k.pose.near(k.view, within_m=0.4),
        settle_s=1,
        control="autonomy",
        transitions=[On("succeeded", to="there", do=RESET), On(*TROUBLE, to="blocked", do=[Set(k.failures, add=1)])],
    )
    deciding = Decision(
        "The robot cannot get to where it would look from. What should it do?",
        evidence=[k.view, k.pose, k.ahead_m, k.sighting, k.camera, k.failures, k.waits, k.battery],
        options={
            "retry": Option("try again now", when=k.failures < 3),
            "wait": Option(
                "wait here for 15 s, since who or what is in the way may go, then try again", when=k.failures < 3
            ),
            "skip": Option("leave this view out and continue with the next"),
            "abort": Option("give the task up, and stay here"),
        },
        ask=["agent", "rules"],
        attempts=1,
        deadline_s=30,
        fallback="skip",
        transitions=[
            On("retry", to="going"),
            On("wait", to="giving_way"),
            On("skip", to="left_out"),
            On("abort", to="gave_up"),
        ],
    )
    blocked = Compound(
        about="the navigation gave up; it looks whether a person is in the way",
        entry=[look_for("person")],
        exit=[look_for("")],
        initial="looking_ahead",
        states={
            "looking_ahead": State(about="looks ahead for a moment", transitions=[After(2.5, to="deciding")]),
            "deciding": deciding,
        },
    )
    giving_way = State(
        about="waits until the way may be free", entry=[Set(k.waits, add=1)], transitions=[After(15, to="going")]
    )
    return Compound(initial="going", states={"going": going, "blocked": blocked, "giving_way": giving_way})


def at_place() -> Each:
    return Each(
        "views",
        item="view",
        about="drives from view to view of the place",
        initial="on_the_way",
        states={
            "on_the_way": on_the_way(),
            "there": State(
                about="it is where it wanted to be",
                transitions=[
                    When(k.task == "find", to="searching"),
                    When(k.task == "look", to="looking_around"),
                    When(k.task == "wait", to="waiting"),
                    When(k.task == "go", to="arrived"),
                ],
            ),
            "searching": State(
                about="looks for the object from here",
                entry=[look_for(k.object)],
                exit=[look_for("")],
                transitions=[
                    When(FOUND, to="found", do=[Set(k.report, from_=k.sighting.text)]),
                    After(5, when=HAS_LOOKED & UNSEEN, to="looking_for_people"),
                    After(10, when=HAS_LOOKED, to="looking_for_people"),
                    After(10, to="blind"),
                ],
            ),
            "looking_for_people": State(
                about="who or what is right ahead may hide the object; is a person there, or anything so near?",
                entry=[look_for("person")],
                exit=[look_for("")],
                transitions=[
                    When(HIDDEN & (k.sight_waits < MOST_SIGHT_WAITS), to="giving_sight"),
                    After(2.5, to="not_here"),
                ],
            ),
            "giving_sight": State(
                about="waits until the view may be free, then looks again",
                entry=[Set(k.sight_waits, add=1)],
                transitions=[After(8, to="searching")],
            ),
            "not_here": Final("succeeded", about="not seen from here, and on to the next view"),
            "left_out": Final(
                "succeeded", about="left out, and on to the next view", entry=[Set(k.skipped, add=1), *RESET]
            ),
        },
        transitions=[
            On("succeeded", when=k.task != "find", to="out_of_reach"),
            On("succeeded", when=k.skipped > 0, to="not_reached"),
            On("succeeded", to="not_found"),
        ],
    )


def ends() -> dict[str, Final]:
    there = k.pose.near(k.view, within_m=0.4)
    return {
        "found": Final(
            "succeeded", about="it sees the object now, within range, and several looks agree", requires=FOUND
        ),
        "looked": Final("succeeded", about="it looked around, and reports what it sees", requires=LOOKED),
        "arrived": Final("succeeded", about="it is at the place", requires=there),
        "waited": Final("succeeded", about="it waited as long as it was asked to", requires=k.waited_s >= k.wait_s),
        "back": Final("succeeded", about="it is on its dock and charges", requires=CHARGING),
        "not_found": Final("failed", about="it looked from every view, and did not see the object"),
        "not_reached": Final(
            "failed", about="it could not get to every view, and did not see the object from the others"
        ),
        "out_of_reach": Final("failed", about="it could not get to the place"),
        "blind": Final("failed", about="it got no picture, or no detections from it"),
        "refused": Final("failed", about="there is no such task or place, or no object to find"),
        "stranded": Final("failed", about="it is stuck somewhere and cannot come to its dock; a person must fetch it"),
        "gave_up": Final("aborted", about="it gave the task up, and stays where it is"),
        "low_battery": Final("aborted", about="it is on its dock, because its battery was low; the task is not done"),
        "stopped": Final("aborted", about="stopped at once, because someone wanted it"),
    }


def mission() -> Mission:
    looking_around = State(
        about="looks at what is there",
        entry=[look_for(k.things)],
        exit=[look_for("")],
        transitions=[When(LOOKED, to="looked", do=[Set(k.report, from_=k.seen.text)]), After(10, to="blind")],
    )
    waiting = Action(
        "wait",
        about="waits as long as it was asked to",
        goal={"time": k.wait_s},
        result={"waited_s": "waited_s"},
        timeout_s=3700,
        transitions=[On("succeeded", to="waited"), On("failed", "timed_out", "rejected", to="gave_up")],
    )
    low = (k.battery < 0.2) | ~k.battery.fresh
    return Mission(
        "rosbot_assist",
        version="1.1.0",
        about="Do one thing in the house for a person: go to a place, find an object and report where it is, look "
        "around and report what is there, wait, or come back to the dock.",
        keys=k,
        events={"e_stop": EventSpec("someone wants the robot to stop, now")},
        initial="choosing",
        states={
            "choosing": choosing(),
            "at_place": at_place(),
            "looking_around": looking_around,
            "waiting": waiting,
            "coming_back": dock("drives to its dock", "back"),
            "recharging": dock(
                "drives to its dock, because the battery runs low or is not received any more", "low_battery"
            ),
            **ends(),
        },
        transitions=[
            On("e_stop", to="stopped"),
            When(~In("recharging") & ~In("coming_back") & low, to="recharging"),
        ],
        invariants={"never_empty": (k.battery > 0.02).or_unknown},
    )
