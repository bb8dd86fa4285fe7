# SPDX-License-Identifier: Apache-2.0
"""Every fault of a mission at once, before a robot moves: rules over the graph, one file a family.

Imports `guards`, `mission`, `model`, `planning` and `states`, and the modules of the root.
"""

from rai_missions.check.files import CheckedFile, FileFinding, check_file, errors_of, load_whole
from rai_missions.check.finding import Finding, Severity, exit_status, faults_of
from rai_missions.check.rules import RULES, check

__all__ = (
    "RULES", "CheckedFile", "FileFinding", "Finding", "Severity", "check", "check_file", "errors_of",
    "exit_status", "faults_of", "load_whole",
)  # fmt: skip
