# SPDX-License-Identifier: Apache-2.0
"""`python -m rai_missions`: the command `rai-missions`, where its folder is on no PATH."""

from __future__ import annotations

import sys

from rai_missions.cli.main import main

__all__ = ()

sys.exit(main())
