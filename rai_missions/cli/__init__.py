# SPDX-License-Identifier: Apache-2.0
"""The command line: parsers, output for people and programs, exit statuses. Imports everything; nothing imports it."""

__all__ = ()
