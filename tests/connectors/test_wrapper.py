# SPDX-License-Identifier: Apache-2.0
"""A connector around another is what the one inside is, in every ability and in no other."""

from __future__ import annotations

import inspect
from collections.abc import Callable

from rai_missions.connectors.connector import Connector, SupportsPreconnect, SupportsRawMessages, Surveyor
from rai_missions.connectors.contract import check_connector
from rai_missions.connectors.local import LocalConnector
from rai_missions.connectors.wrapper import ConnectorWrapper


class SurveyingConnector(LocalConnector):
    """Finds out who serves an action."""

    def survey(self, action: str, type_name: str, *, within_s: float, on_result: Callable[[str], None]) -> None:
        on_result(f"{action} within {within_s:g} s")


def test_it_keeps_the_contract_of_connectors() -> None:
    check_connector(lambda: ConnectorWrapper(LocalConnector()))


def test_it_has_the_abilities_of_the_one_inside_and_no_other() -> None:
    wrapper = ConnectorWrapper(SurveyingConnector())
    assert isinstance(wrapper, Connector) and isinstance(wrapper, Surveyor)
    assert not isinstance(wrapper, SupportsPreconnect) and not isinstance(wrapper, SupportsRawMessages)
    received = list[str]()
    wrapper.survey("/go", "", within_s=2.0, on_result=received.append)
    assert received == ["/go within 2 s"]


def test_an_ability_is_found_without_asking_for_attributes_dynamically() -> None:
    """As newer versions of Python look for the members of a protocol."""
    assert inspect.getattr_static(ConnectorWrapper(SurveyingConnector()), "survey", None) is not None
