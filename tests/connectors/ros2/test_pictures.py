# SPDX-License-Identifier: Apache-2.0
"""A picture is costly: it is made when it leaves for a client that listens, and not before."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.connectors.connector import Message
from rai_missions.connectors.contract import Inbox
from rai_missions.errors import ConnectorError
from rai_missions.image import Image

TYPE = "sensor_msgs/msg/Image"


class Camera:
    """Pictures of one colour, and a note of each that was made."""

    def __init__(self) -> None:
        self.made: list[int] = []

    def message(self, number: int, encoding: str = "rgb8") -> dict[str, Any]:
        def pixels() -> bytes:
            self.made.append(number)
            return bytes([number]) * 12

        header = {"stamp": float(number), "frame_id": "camera"}
        return {"header": header, "height": 2, "width": 2, "encoding": encoding, "step": 6,
                "data": Image(f"camera@{number}", 2, 2, encoding, pixels)}  # fmt: skip


def test_of_the_pictures_that_no_one_saw_only_the_newest_is_made(open_ros: Callable[..., Any]) -> None:
    robot, eye, camera = open_ros(discovery_s=30.0), open_ros(), Camera()
    for number in (1, 2, 3):
        robot.publish("/camera", TYPE, camera.message(number))
    robot.listed("topics")  # answered after all that was asked before
    received: Inbox[Message] = Inbox(30.0)
    eye.subscribe("/camera", TYPE, received)
    received.wait(lambda seen: len(seen) == 1, "the newest picture")
    assert camera.made == [3]
    robot.publish("/camera", TYPE, camera.message(4))
    received.wait(lambda seen: len(seen) == 2, "the next picture")
    assert camera.made == [3, 4]
    assert [each.data["data"].data for each in received.all] == [bytes([3]) * 12, bytes([4]) * 12]


def test_a_picture_that_its_message_cannot_carry_is_reported_and_never_made(
    open_ros: Callable[..., Any],
) -> None:
    robot, camera = open_ros(), Camera()
    with pytest.raises(ConnectorError, match="/camera/data: a picture in 'png' travels as sensor_msgs/msg/Compressed"):
        robot.publish("/camera", TYPE, camera.message(1, "png"))
    with pytest.raises(ConnectorError, match="/camera/hight: sensor_msgs/msg/Image has no such field"):
        robot.publish("/camera", TYPE, {**camera.message(1), "hight": 2})
    assert camera.made == []
