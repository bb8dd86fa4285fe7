# SPDX-License-Identifier: Apache-2.0
"""What a type checker notifies the authors of Python missions; `make check` runs mypy on this, strictly."""

from __future__ import annotations

from typing import assert_type

import rai_missions
from rai_missions import (
    After,
    CallEffect,
    Chart,
    DefinitionError,
    Event,
    Fault,
    Held,
    Image,
    In,
    Key,
    Keys,
    Mission,
    On,
    Ref,
    Runner,
    Set,
    Step,
    When,
    answer,
    dump,
    event,
    load,
)
from rai_missions.guards import Guard
from rai_missions.states import (
    Action,
    Call,
    Compound,
    Decision,
    Each,
    Final,
    History,
    Include,
    Option,
    Parallel,
    State,
    Transition,
    Tree,
    tree,
)

k = Keys(battery=Key(float, source="robot", max_age_s=10), moving=Key(bool), camera=Key(Image, source="robot"))

assert_type(k.battery, Ref)
assert_type(k.obstacle.height_m, Ref)
assert_type(k["battery"], Ref)
assert_type(event.distance_m, Ref)
assert_type(answer.alley, Ref)
assert_type(k.battery < 0.15, Guard)
assert_type(k.battery == 0.15, Guard)
assert_type(~k.moving, Guard)
assert_type(k.battery.fresh, Guard)
assert_type(k.moving & k.moving, Guard)
assert_type((k.battery < 0.15) | ~k.battery.fresh, Guard)
assert_type((k.battery < 0.15) & k.moving, Guard)
assert_type(k.moving | In("a"), Guard)
assert_type(k.here.near(k.home, within_m=0.5), Guard)
assert_type(Held(k.moving, 2) & In("a"), Guard)
assert_type(On("a", "b", to="c", when=k.moving, do=[Set(k.moving, True), CallEffect("horn")]), Transition)
assert_type(When(k.moving, to=["a", "b"]), Transition)
assert_type(After(5, to="a", do=Set(k.moving, False)), Transition)

assert_type(k.moving.is_true & ~k.moving.is_false, Guard)
assert_type(k.moving.held_for(2) & k.moving.or_unknown, Guard)
assert_type(Action("go", goal={"to": k.here}, achieved=k.moving, entry=Set(k.moving, True)), Action)
assert_type(tree.Action("go", timeout_s=3), tree.Action)
assert_type(Tree(tree.Sequence([tree.Check(k.moving), tree.Retry(tree.Call("horn"), 3), tree.Wait(1)])), Tree)
assert_type(Each(k.places, item=k.here, initial="a", states={"a": State()}), Each)
assert_type(Parallel({"a": Call("horn"), "b": Include("dock.json", with_={"n": k.battery})}), Parallel)

Action()  # type: ignore[call-arg]
Action("go", "home")  # type: ignore[call-arg, arg-type]
Action("go", timeout=3)  # type: ignore[call-arg]
Action("go", timeout_s="3")  # type: ignore[arg-type]
Action("go", achieved=True)  # type: ignore[arg-type]
State(control="robot")  # type: ignore[arg-type]
State(transitions=[Option("a")])  # type: ignore[list-item]
Final("done")  # type: ignore[arg-type]
History("deeep")  # type: ignore[arg-type]
Key(float, source="sensor")  # type: ignore[arg-type]
Decision("What?")  # type: ignore[call-arg]
Decision("What?", options={"go": "on"})  # type: ignore[dict-item]
Mission("small", initial="a", states={"a": State()}, kyes=k)  # type: ignore[call-arg]
tree.Sequence([State()])  # type: ignore[list-item]
tree.Check(True)  # type: ignore[arg-type]
On("a", too="b")  # type: ignore[call-arg]
_ = (k.battery < 0.15) & 3  # type: ignore[operator]
On(3)  # type: ignore[arg-type]
On("a", do=[k.moving])  # type: ignore[list-item]
When("moving")  # type: ignore[arg-type]
After("5")  # type: ignore[arg-type]
Keys(battery=float)  # type: ignore[arg-type]
k.here.near(k.home)  # type: ignore[call-arg]


def mission() -> Mission:
    """As an author writes one."""
    return Mission(
        "small",
        keys=k,
        events=["anomaly"],
        initial="working",
        states={
            "working": Compound(
                initial="driving",
                states={
                    "driving": Action("drive", timeout_s=900, achieved=k.moving, goal={"at": k.battery}),
                    "resume": History("deep"),
                },
                transitions=[On("anomaly", to="asking")],
            ),
            "asking": Decision("What now?", evidence=[k.camera], options={"go": Option("on", when=k.moving)}),
            "done": Final("succeeded", requires=k.moving),
        },
    )


def files(mission: Mission) -> None:
    assert_type(load("mission.json"), Mission)
    assert_type(load("mission.py", python=False), Mission)
    assert_type(dump(mission), str)
    assert_type(mission.states["working"], State)
    assert_type(mission.invariants["safe"], Guard)
    assert_type(mission.states["working"].transitions, tuple[Transition, ...])
    assert_type(mission.blackboard, dict[str, Key])


def faults(error: DefinitionError) -> None:
    assert_type(error.faults, tuple[Fault, ...])
    assert_type(error.faults[0].place, str)


def runs(mission: Mission) -> None:
    chart = Chart(mission)
    assert_type(chart.start(at=0.0), Step)
    assert_type(chart.send(Event("anomaly", at=3.2, data={})), Step)
    assert_type(chart.active, frozenset[str])
    assert_type(rai_missions.Runner, type[Runner])
    rai_missions.Chrat  # type: ignore[attr-defined]  # noqa: B018
