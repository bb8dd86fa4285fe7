# SPDX-License-Identifier: Apache-2.0
"""A reading among places: it may be near each of them and far from the others, wherever they are."""

from __future__ import annotations

from cProfile import Profile
from itertools import product
from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions import Chart, Event
from rai_missions.guards.near import distance
from rai_missions.mission.mission import Mission
from rai_missions.prove import Proof, prove
from rai_missions.prove.analysis.places import Places
from rai_missions.prove.environment.environment import Environment

Json = dict[str, Any]
POSE: Json = {"type": "pose", "source": "robot", "max_age_s": 5, "frame": "map"}
GIVEN: Json = {"type": "pose", "source": "argument", "frame": "map"}
KEPT: Json = {"type": "pose", "frame": "map"}
OVER: Json = {"final": "aborted"}


def near(place: str, reading: str = "pose", within_m: float = 0.5) -> Json:
    return {"near": [reading, place], "within_m": within_m}


def proof_of(keys: Json, *guards: Json, do: list[Json] | None = None, **more: Any) -> Proof:
    """Of a mission that leaves its first state by each of the guards, for a state each."""
    ways = [{"when": guard, "to": f"way_{number}"} for number, guard in enumerate(guards)]
    ends = {f"way_{number}": OVER for number, _ in enumerate(guards)}
    return prove(Mission.model_validate({
        "format": 1, "name": "places", "initial": "here", "blackboard": {"pose": POSE, **keys},
        "states": {"here": {"entry": do or [], "transitions": ways}, **ends}, **more,
    }))  # fmt: skip


@given(within_m=st.lists(st.floats(0.001, 1e4), min_size=1, max_size=3))
def test_a_reading_can_be_near_any_of_its_places_and_far_from_the_others(within_m: list[float]) -> None:
    distances = dict(zip("abc", within_m, strict=False))
    names, places = tuple(distances), Places("pose", distances)
    at = {name: next(places.poses(name, {"frame": "map"})) for name in names}
    found = [
        tuple((metres := distance(reading, at[name])) is not None and metres <= distances[name] for name in names)
        for reading in places.poses("pose", {"frame": "map"})
    ]
    assert sorted(found) == sorted(product((False, True), repeat=len(names)))
    copies = list(places.poses("target", {"frame": "map"}))
    assert copies == [at[name] for name in names]


def test_each_nearness_to_two_arguments_is_explored() -> None:
    one, other = near("home"), near("shelf")
    both, either = {"all": [one, other]}, {"any": [one, other]}
    proof = proof_of({"home": GIVEN, "shelf": GIVEN}, both, {"all": [one, {"not": other}]}, other, {"not": either})
    assert (proof.sampled, proof.never) == ((), ())


@pytest.mark.parametrize("keys", [
    {"home": GIVEN, "shelf": GIVEN},
    {"home": {**KEPT, "initial": {"x": 0.0, "y": 0.0, "frame": "map"}},
     "shelf": {**KEPT, "initial": {"x": 9.0, "y": 0.0, "frame": "map"}}},
], ids=["arguments", "constants"])  # fmt: skip
def test_places_may_have_distances_of_their_own(keys: Json) -> None:
    home, shelf = near("home"), near("shelf", within_m=2)
    proof = proof_of(keys, {"all": [home, {"not": shelf}]}, shelf, {"not": {"any": [home, shelf]}})
    assert (proof.sampled, proof.never) == ((), ())


def test_a_copy_is_asked_for_by_the_distance_of_its_places() -> None:
    keys, do = {"target": KEPT, "home": GIVEN, "shelf": GIVEN}, [{"set": "target", "from": "home"}]
    assert "pose" in proof_of(keys, near("target"), near("shelf", within_m=2), do=do).sampled
    assert "pose" in proof_of(keys, near("target"), near("home", within_m=2), do=do).sampled


def test_a_delivery_between_two_places_is_proved() -> None:
    drive: Json = {"action": "drive", "timeout_s": 60}
    proof = prove(Mission.model_validate({
        "format": 1, "name": "delivery", "initial": "going",
        "blackboard": {"pose": POSE, "home": GIVEN, "shelf": GIVEN},
        "states": {
            "going": {**drive, "achieved": near("shelf"), "transitions": [{"on": "succeeded", "to": "coming"}]},
            "coming": {**drive, "achieved": near("home"), "transitions": [{"on": "succeeded", "to": "done"}]},
            "done": {"final": "succeeded", "requires": near("home")}},
    }))  # fmt: skip
    assert (proof.verdict, proof.sampled) == ("proved", ())


def test_a_target_that_is_set_from_arguments_is_one_of_them() -> None:
    do = [{"set": "target", "from": "home"}]
    target, home, shelf = near("target"), near("home"), near("shelf")
    other_than_home = {"any": [{"all": [target, {"not": home}]}, {"all": [home, {"not": target}]}]}
    keys = {"target": KEPT, "home": GIVEN, "shelf": GIVEN}
    proof = proof_of(keys, other_than_home, {"all": [target, {"not": shelf}]}, {"all": [target, shelf]}, do=do)
    assert (proof.sampled, proof.never) == ((), ("way_0",))


def constant(x: float) -> Json:
    return {**KEPT, "initial": {"x": x, "y": 0.0, "frame": "map"}}


def calls_for(stations: int) -> int:
    """Calls of functions until the exploration of a round trip among stations, with a counter each, may begin."""
    names = [f"station_{number}" for number in range(stations)]
    mission = Mission.model_validate({
        "format": 1, "name": "stations", "initial": names[0],
        "blackboard": {
            "pose": POSE, **{f"at_{name}": constant(3.0 * number) for number, name in enumerate(names)},
            **{f"tries_{name}": {"type": "integer", "initial": 0} for name in names},
        },
        "states": {
            **{name: {"transitions": [{"when": near(f"at_{name}"), "to": to},
                                      {"when": {"key": f"tries_{name}", ">": 3}, "to": "over"}]}
               for name, to in zip(names, [*names[1:], names[0]], strict=True)},
            "over": OVER,
        },
    })  # fmt: skip
    profile = Profile()
    profile.runcall(Environment, mission)
    return sum(each.callcount for each in profile.getstats())


def test_what_is_done_ahead_of_an_exploration_grows_with_the_pairs_of_stations_at_most() -> None:
    assert calls_for(40) < 5 * calls_for(20)


def test_constants_that_lie_apart_are_near_one_at_a_time() -> None:
    both = {"all": [near("home"), near("shelf")]}
    neither = {"not": {"any": [near("home"), near("shelf")]}}
    keys = {"home": constant(0.0), "shelf": constant(3.0)}
    proof = proof_of(keys, both, near("home"), near("shelf"), neither)
    assert (proof.sampled, proof.never) == ((), ("way_0",))


@pytest.mark.parametrize(("keys", "ways"), [
    ({"home": constant(0.0), "shelf": constant(0.8)}, (near("home"), near("shelf"))),
    ({"home": GIVEN, "shelf": GIVEN}, (near("home"), near("home", within_m=2), near("shelf"))),
    ({"home": GIVEN, "shelf": constant(3.0)}, (near("home"), near("shelf"))),
    ({"home": GIVEN, "shelf": GIVEN}, (near("home"), near("shelf"), near("shelf", "home"))),
    ({"home": GIVEN, "cup": POSE}, (near("home"), near("cup"))),
    ({"home": GIVEN, "shelf": GIVEN}, (near("home"), near("shelf"), {"key": "home.x", ">": 1})),
    ({"home": GIVEN, "named": {**KEPT, "source": "answer"}}, (near("home"), near("named"))),
    ({"home": {**GIVEN, "frame": ""}, "shelf": GIVEN}, (near("home"), near("shelf"))),
    (dict.fromkeys(("a", "b", "c", "d"), GIVEN), tuple(near(name) for name in ("a", "b", "c", "d"))),
])  # fmt: skip
def test_what_these_places_do_not_represent_is_named(keys: Json, ways: tuple[Json, ...]) -> None:
    assert "pose" in proof_of(keys, *ways).sampled


def test_a_reading_that_is_kept_or_a_place_that_a_result_brings_is_named() -> None:
    keys = {"home": GIVEN, "last": KEPT}
    assert "pose" in proof_of(keys, near("home"), near("last"), do=[{"set": "last", "from": "pose"}]).sampled
    call: Json = {"call": "find", "timeout_s": 5, "result": {"target": "pose"}}
    proof = prove(Mission.model_validate({
        "format": 1, "name": "places", "initial": "here",
        "blackboard": {"pose": POSE, "home": GIVEN, "target": KEPT},
        "states": {"here": {**call, "transitions": [{"when": near("home"), "to": "over"},
                                                    {"when": near("target"), "to": "over"}]}, "over": OVER},
    }))  # fmt: skip
    assert "pose" in proof.sampled


def test_a_place_that_is_an_item_of_a_list_is_named() -> None:
    inner = {"looking": {"transitions": [{"when": near("stop"), "to": "over"}, {"when": near("home"), "to": "over"}]}}
    proof = prove(Mission.model_validate({
        "format": 1, "name": "places", "initial": "here",
        "blackboard": {"pose": POSE, "home": GIVEN, "stop": KEPT, "stops": {"type": "list", "source": "argument"}},
        "states": {"here": {"each": "stops", "as": "stop", "initial": "looking", "states": {**inner, "over": OVER}}},
    }))  # fmt: skip
    assert "pose" in proof.sampled


def drawn_guard(chance: Random, distances: dict[str, float]) -> Json:
    one, other = (near(place, within_m=distances[place]) for place in chance.choices([*distances], k=2))
    return {chance.choice(["all", "any"]): [one, chance.choice([other, {"not": other}])]}


@pytest.mark.parametrize("seed", range(12))
def test_no_run_among_any_places_reaches_what_a_proof_calls_out_of_reach(seed: int) -> None:
    chance = Random(seed)
    names, states = ("a", "b", "c")[: 1 + seed % 3], ("s0", "s1", "s2", "s3")
    is_copied = seed < 8
    copied = dict.fromkeys((*names, "target"), 0.5)
    distances = copied if is_copied else {name: chance.uniform(0.2, 1) for name in names}

    def way() -> Json:
        do = [{"set": "target", "from": chance.choice(names)}] if is_copied and chance.random() < 0.5 else []
        return {"on": "look", "when": drawn_guard(chance, distances), "to": chance.choice([*states, "over"]), "do": do}

    mission = Mission.model_validate({
        "format": 1, "name": "drawn", "initial": "s0", "events": ["look"],
        "blackboard": {"pose": {**POSE, "max_age_s": 1e6}, "target": KEPT, **dict.fromkeys(names, GIVEN)},
        "states": {**{state: {"transitions": [way(), way()]} for state in states}, "over": OVER},
    })  # fmt: skip
    proof = prove(mission)
    assert proof.sampled == ()
    for _ in range(20):
        chart = Chart(mission)
        for key in (*names, "pose"):
            chart.write(key, {"x": chance.uniform(-1, 1), "y": chance.uniform(-1, 1), "frame": "map"}, at=0.0)
        chart.start(0.0)
        for second in range(1, 30):
            chart.write("pose", {"x": chance.uniform(-1, 1), "y": chance.uniform(-1, 1), "frame": "map"}, float(second))
            chart.send(Event("look", second + 0.5))
            assert chart.active.isdisjoint(proof.never), (chart.active, proof.never)


BROUGHT: tuple[tuple[str, Json], ...] = (
    ("found.at", {"found": {"type": "object", "source": "robot"}}),
    ("found.at", {"found": {"type": "object", "source": "robot", "fields": {"at": "object"}}}),
    ("found", {"found": {"type": "object", "source": "robot"}}),
    ("event.at", {}),
)
"""What may be a pose, and the keys that it takes."""


@pytest.mark.parametrize(("place", "keys"), BROUGHT)
@pytest.mark.parametrize("other", [{"home": GIVEN}, {"home": POSE}, {"home": constant(7.0)}])
def test_what_is_brought_with_no_frame_declared_can_be_near_and_far(place: str, keys: Json, other: Json) -> None:
    on: Json = {"on": "seen"} if place.startswith("event") else {}
    guard = near(place, "home")
    proof = prove(Mission.model_validate({
        "format": 1, "name": "places", "initial": "here", "blackboard": {**keys, **other},
        "events": {"seen": {"fields": {"at": "object"}}},
        "states": {"here": {"transitions": [{**on, "when": guard, "to": "near"},
                                            {**on, "when": {"not": guard}, "to": "far"}]},
                   "near": OVER, "far": OVER},
    }))  # fmt: skip
    assert proof.never == ()


@pytest.mark.parametrize(("frame", "is_reached"), [({}, True), ({"frame": "map"}, False)])
def test_poses_of_keys_without_a_frame_may_be_in_different_ones(frame: Json, is_reached: bool) -> None:
    keys = {
        "pose": {"type": "pose", "source": "robot", **frame},
        "home": {"type": "pose", "source": "argument", **frame},
    }
    unknown: Json = {"all": [{"possible": near("home")}, {"possible": {"not": near("home")}}]}
    proof = prove(Mission.model_validate({
        "format": 1, "name": "places", "initial": "here", "blackboard": keys,
        "states": {"here": {"transitions": [{"when": unknown, "to": "odd"}, {"after_s": 1, "to": "over"}]},
                   "odd": OVER, "over": OVER},
    }))  # fmt: skip
    assert ("odd" not in proof.never) == is_reached
