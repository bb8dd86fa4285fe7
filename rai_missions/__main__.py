# SPDX-License-Identifier: Apache-2.0
"""`python -m rai_missions`: the command `rai-missions`, where its folder is on no PATH.

Rule: the working directory is on the path of neither, unless this package itself is there; `-m` puts it ahead of all.
"""

from __future__ import annotations

import sys
from pathlib import Path

__all__ = ()

if not sys.flags.safe_path and Path(sys.path[0]) != Path(__file__).parents[1]:
    del sys.path[0]

from rai_missions.cli.main import main

sys.exit(main())
