# SPDX-License-Identifier: Apache-2.0
"""Robot profiles: which topics, services and actions stand behind the names that a mission uses."""

from rai_missions.robot.against import actions_of, missing
from rai_missions.robot.convert import plain
from rai_missions.robot.entries import ActionEntry, ServiceEntry, TopicEntry
from rai_missions.robot.fields import misnamed, unread, unsaid
from rai_missions.robot.load import dump_profile, identity_folder, load_profile, parse_profile
from rai_missions.robot.profile import Robot, Rule, terms
from rai_missions.robot.source import EventSource, Source
from rai_missions.robot.types import lacking

__all__ = (
    "ActionEntry", "EventSource", "Robot", "Rule", "ServiceEntry", "Source", "TopicEntry", "actions_of", "dump_profile",
    "identity_folder", "lacking", "load_profile", "misnamed", "missing", "parse_profile", "plain", "terms",
    "unread", "unsaid",
)  # fmt: skip
