# SPDX-License-Identifier: Apache-2.0
"""The command line: parsers, output for people and programs, exit statuses.

Imports `agents`, `answerers`, `campaign`, `check`, `connectors`, `conversation`, `embodiment`, `engine`, `gate`,
`journal`, `mission`, `node`, `profile`, `prove`, `recording`, `replay`, `runtime`, `states`, `visualize`, `voice` and
`worlds`, and the modules of the root.
Nothing imports it.
"""

__all__ = ()
