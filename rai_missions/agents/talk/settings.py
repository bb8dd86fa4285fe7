# SPDX-License-Identifier: Apache-2.0
"""From a profile's `conversation` to the settings of a dialogue."""

from __future__ import annotations

from collections.abc import Mapping

from rai_missions.conversation import Settings, permissions
from rai_missions.conversation.settings import LatePolicy
from rai_missions.profile import ConversationPolicy

__all__ = ("settings_of",)

LATE: Mapping[str, LatePolicy] = {"queue": "queue", "last": "keep_last", "interrupt": "interrupt"}


def settings_of(policy: ConversationPolicy | None) -> Settings:
    """The settings of a robot's dialogue; those of no profile where it states none."""
    policy = policy or ConversationPolicy()
    return Settings(
        language=policy.language,
        may=permissions(policy.may),
        requests=policy.requests,
        late=LATE[policy.while_answering],
    )
