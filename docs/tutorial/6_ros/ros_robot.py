"""The bin robot as a ROS 2 node: services begin and stop what it does, topics report what is so.

`python ros_robot.py` runs until it is interrupted; a second argument such as 5 makes it that much faster.
"""

import sys
import time

import rclpy
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool, Empty, String
from std_srvs.srv import Trigger

speed = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0
now = {"place": "home", "gate": "closed", "out": False}
work = {"does": "", "until": 0.0}

rclpy.init()
node = rclpy.create_node("bin_robot")
place = node.create_publisher(String, "/bin/place", 10)
gate = node.create_publisher(String, "/bin/gate", 10)
out = node.create_publisher(Bool, "/bin/out", 10)
battery = node.create_publisher(BatteryState, "/bin/battery", 10)
blocked = node.create_publisher(Empty, "/bin/blocked", 10)


def begins(what, seconds):
    def begin(request, response):
        work.update(does=what, until=time.monotonic() + seconds / speed)
        response.success = True
        return response

    return begin


def ring(request, response):
    now["gate"], response.success = "open", True
    return response


def tick():
    if work["does"] in ("kerb", "home"):
        if now["place"] in ("home", "kerb") and now["place"] != work["does"]:
            now["place"] = "yard"
        if work["does"] == "kerb" and now["gate"] == "closed":
            work["does"] = ""
            blocked.publish(Empty())
    if work["does"] and time.monotonic() > work["until"]:
        if work["does"] == "lower":
            now["out"] = True
        else:
            now["place"] = work["does"]
        work["does"] = ""
    place.publish(String(data=now["place"]))
    gate.publish(String(data=now["gate"]))
    out.publish(Bool(data=now["out"]))
    battery.publish(BatteryState(percentage=0.9))


for name, what, seconds in (
    ("drive_out", "kerb", 3),
    ("drive_home", "home", 3),
    ("lower", "lower", 1),
    ("stop", "", 0),
):
    node.create_service(Trigger, f"/bin/{name}", begins(what, seconds))
node.create_service(Trigger, "/bin/bell", ring)
node.create_subscription(Bool, "/bin/lamp", lambda message: None, 10)
node.create_timer(0.1, tick)
node.get_logger().info("the bin robot is running; Ctrl-C ends it")
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
