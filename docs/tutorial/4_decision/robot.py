"""A robot that carries a bin, simulated in a few lines."""

from rai_missions import PythonRobot

RULES = {"asking": [{"when": {"key": "gate", "==": "closed"}, "answer": "ring"}]}

robot = PythonRobot("bin robot, simulated", rules=RULES)
now = {"place": "home", "bin_out": False, "battery": 0.9, "tries": 0, "gate": "closed"}

robot.fact("place", every_s=0.5)(lambda: now["place"])
robot.fact("battery", every_s=2)(lambda: now["battery"])
robot.fact("gate", every_s=0.5)(lambda: now["gate"])
robot.fact("bin_out", every_s=0.5)(lambda: now["bin_out"])
robot.topic("lamp")(lambda message: None)


def drive(to, run):
    now["place"] = "yard"
    for _ in range(6):
        if run.canceled:
            return run.cancel()
        run.sleep(0.5)
        if to == "kerb" and now["gate"] != "open":
            robot.raise_event("blocked")
    now["place"] = to


@robot.action("drive_out", uses=["base"])
def drive_out(goal, run):
    return drive("kerb", run)


@robot.action("drive_home", uses=["base"])
def drive_home(goal, run):
    return drive("home", run)


@robot.action("lower", uses=["arm"])
def lower(goal, run):
    run.sleep(1)
    now["tries"] += 1
    now["bin_out"] = now["tries"] > 1  # the bin sticks once


@robot.service("bell")
def bell(request):
    now["gate"] = "open"
