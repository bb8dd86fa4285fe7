# SPDX-License-Identifier: Apache-2.0
"""The connector to a robot in Python keeps the contract, and what is promised of functions."""

from __future__ import annotations

from rai_missions import PythonRobot
from rai_missions.connectors.python_robot import PythonRobotConnector
from rai_missions.testing import check_connector


def test_it_keeps_the_contract_of_connectors() -> None:
    check_connector(lambda: PythonRobotConnector(PythonRobot("turtle")))
