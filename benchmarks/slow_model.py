# SPDX-License-Identifier: Apache-2.0
"""A chat model that takes its time, for what must not wait for one."""

from __future__ import annotations

import threading

from langchain_core.callbacks import CallbackManagerForLLMRun
from langchain_core.language_models import BaseChatModel
from langchain_core.messages import AIMessage, BaseMessage
from langchain_core.outputs import ChatGeneration, ChatResult

__all__ = ("SlowModel",)


class SlowModel(BaseChatModel):
    """Answers with a sentence after so many seconds."""

    wait_s: float

    @property
    def _llm_type(self) -> str:
        return "slow"

    def _generate(
        self, messages: list[BaseMessage], stop: list[str] | None = None,
        run_manager: CallbackManagerForLLMRun | None = None, **words: object,
    ) -> ChatResult:  # fmt: skip
        threading.Event().wait(self.wait_s)
        return ChatResult(generations=[ChatGeneration(message=AIMessage("Mice like cheese."))])
