# SPDX-License-Identifier: Apache-2.0
"""A chat model that takes its time, for what must not wait for one."""

from __future__ import annotations

import threading

from langchain_core.messages import BaseMessage

from rai_missions.answerers.test_models import DoubleModel

__all__ = ("SlowModel",)


class SlowModel(DoubleModel):
    """Answers with a sentence after so many seconds."""

    wait_s: float

    def reply_to(self, messages: list[BaseMessage]) -> str:
        threading.Event().wait(self.wait_s)
        return "Mice like cheese."
