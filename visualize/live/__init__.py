# SPDX-License-Identifier: Apache-2.0
"""The live page: a run in a browser while it continues, served next to it, and the operator's hands on it.

Rule: the engine waits for no one. It leaves its steps in a queue; what a viewer costs, the server pays.

Imports `engine`, `journal`, `mission` and `states`, and the modules of the root.
"""

from visualize.live.app import OrderSink
from visualize.live.feed import Feed, FollowedRun, RunFeed
from visualize.live.journal_feed import JournalFeed
from visualize.live.scene import RunScene
from visualize.live.server import LivePage, PageAddress
from visualize.live.talk import TalkSink

__all__ = (
    "Feed",
    "FollowedRun",
    "JournalFeed",
    "LivePage",
    "OrderSink",
    "PageAddress",
    "RunFeed",
    "RunScene",
    "TalkSink",
)  # fmt: skip
