# SPDX-License-Identifier: Apache-2.0
"""Missions for robots in which rules own the state and models only answer questions."""
