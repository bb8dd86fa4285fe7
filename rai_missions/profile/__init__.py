# SPDX-License-Identifier: Apache-2.0
"""Robot profiles: the topics, services and actions of the names that a mission uses.

Imports `check`, `connectors`, `engine`, `guards`, `mission`, `model`, `states` and `worlds`, and the modules of the
root.
"""

from rai_missions.profile.connector_faults import connector_faults, field_faults, middleware_faults
from rai_missions.profile.conversation import GRANTED, ORDERS, ConversationPolicy, OrderName
from rai_missions.profile.convert import plain
from rai_missions.profile.coverage import (
    actions_of,
    commanded_names,
    keys_read,
    missing,
    missing_tools,
    missing_world,
)
from rai_missions.profile.endpoints import Endpoint, endpoints, lacking, wanted
from rai_missions.profile.entries import ActionEntry, ServiceEntry, TopicEntry
from rai_missions.profile.files import (
    dump_profile,
    identity_folder,
    is_program,
    load_profile,
    parse_profile,
    recorded_profile,
)
from rai_missions.profile.legible import legible_profile, load_whole_profile, missing_anyway
from rai_missions.profile.message_fields import absent_field, unknown_fields, why_unreadable
from rai_missions.profile.profile import Robot, Rule, robot_facts
from rai_missions.profile.python_robot import RobotProgram, check_functions, profile_of, read_program
from rai_missions.profile.sources import EventSource, Source

__all__ = (
    "GRANTED",
    "ORDERS",
    "ActionEntry",
    "ConversationPolicy",
    "Endpoint",
    "EventSource",
    "OrderName",
    "Robot",
    "RobotProgram",
    "Rule",
    "ServiceEntry",
    "Source",
    "TopicEntry",
    "absent_field",
    "actions_of",
    "check_functions",
    "commanded_names",
    "connector_faults",
    "dump_profile",
    "endpoints",
    "field_faults",
    "identity_folder",
    "is_program",
    "keys_read",
    "lacking",
    "legible_profile",
    "load_profile",
    "load_whole_profile",
    "middleware_faults",
    "missing",
    "missing_anyway",
    "missing_tools",
    "missing_world",
    "parse_profile",
    "plain",
    "profile_of",
    "read_program",
    "recorded_profile",
    "robot_facts",
    "unknown_fields",
    "wanted",
    "why_unreadable",
)  # fmt: skip
