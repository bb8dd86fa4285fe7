# SPDX-License-Identifier: Apache-2.0
"""The process that serves one GGUF file on loopback, until its standard input ends.

Rule: this file is run by its path and imports nothing of the project, so whatever native code does to its process, the
mission's continues; and when the mission's process ends, however it does, this one ends too.

The first line on standard output is JSON: `{"url": "http://127.0.0.1:PORT"}`, or `{"fault": "…"}`.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

__all__ = ("main",)


def main(file: str, threads: int, window: int, longest: int) -> int:
    """Serve `file` with so many threads, a window and a longest answer of so many tokens each."""
    report = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what native code prints must not mix with the report
    os.environ["OMP_WAIT_POLICY"] = "PASSIVE"  # read when the native code is loaded
    try:
        server = served(file, threads, window, longest)
        result = {"url": server.listening_address}
    except Exception as error:  # noqa: BLE001 - whatever it is, it is reported
        result = {"fault": str(error)}
    with report:
        report.write(json.dumps(result) + "\n")
    if "url" in result:
        sys.stdin.buffer.read()
        os._exit(0)  # a server that is taken down while its threads still start may wait for them for ever
    return 0


def served(file: str, threads: int, window: int, longest: int) -> Any:
    import xllamacpp

    wanted = xllamacpp.CommonParams()
    wanted.model.path = file
    wanted.hostnames, wanted.port = ["127.0.0.1"], 0
    wanted.n_ctx, wanted.n_predict, wanted.n_parallel = window, longest, 1
    for cores in (wanted.cpuparams, wanted.cpuparams_batch):
        cores.n_threads, cores.poll = threads, 0  # polling threads starve everybody else on a small machine
    wanted.n_threads_http = 2
    wanted.n_gpu_layers, wanted.fit_params, wanted.warmup = 0, False, False
    wanted.offline, wanted.ui, wanted.endpoint_slots, wanted.verbosity = True, False, False, 0
    return xllamacpp.Server(wanted)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], *map(int, sys.argv[2:5])))
