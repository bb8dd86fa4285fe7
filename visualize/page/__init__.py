# SPDX-License-Identifier: Apache-2.0
"""The review page: a mission, what may happen in it and what did, as one HTML file that needs nothing else.

Rule: what is shown is data. It is in the page as JSON, is put on the screen as text alone, and nothing of it runs.

Imports `engine`, `guards`, `journal`, `mission`, `model` and `states`, and the modules of the root.
"""

from visualize.page.chart_data import chart_data
from visualize.page.data import Journal, PageFinding, review, review_data
from visualize.page.html import document
from visualize.page.runs import Run, read_run, run_data, run_of_steps

__all__ = (
    "Journal",
    "PageFinding",
    "Run",
    "chart_data",
    "document",
    "read_run",
    "review",
    "review_data",
    "run_data",
    "run_of_steps",
)
