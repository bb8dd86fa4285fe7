# SPDX-License-Identifier: Apache-2.0
"""The report of a campaign: figures with intervals, what differs beyond chance, and every wrong answer, as a page.

Rule: what is shown is data. Texts become markup through `markup` alone, or text nodes in the browser; nothing runs.

Imports `campaign`, and the modules of the root.
"""

from visualize.campaign_page.markdown import markdown
from visualize.campaign_page.page import report_page

__all__ = ("markdown", "report_page")
