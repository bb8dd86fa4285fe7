# SPDX-License-Identifier: Apache-2.0
"""A package that is not ours: a guard, an activity, a connector, a world and an exporter, offered by entry points."""

__all__ = ()
