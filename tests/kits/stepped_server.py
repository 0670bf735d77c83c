"""Starts `dray up` whose time passes only when a test says so, as often as it is asked to, and imports all of that once.

Usage: python stepped_server.py

A line of JSON says what is to be started: `{"options": [of dray up], "cwd": a folder, "env": the environment, "output": a pipe's path}`. It
is answered by the number of the new process, whose output goes into that pipe. `{"wait": number}` is answered by its exit code once it
has ended. The end of the input is the end.

A fork takes over one thread of several, and no event loop: so this process has one thread and no loop. What was started ends as any
interpreter does, with its threads and all that is to be done at its end.
"""

from __future__ import annotations

import gc
import json
import os
import sys
from pathlib import Path
from typing import Any

# `dray up` imports these when it starts.
import alembic.command  # noqa: F401
import stepped_up

import dray.cli.commands.plant
import dray.cli.commands.simulation.up
import dray.cli.simulation.customers  # noqa: F401
from dray.shapes import prepare_shapes

Asked = dict[str, Any]


def serve() -> Asked | None:
    """Start what is asked for until the input ends; returns in each new process what that one is to be."""
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as answers:
        for line in sys.stdin:
            asked: Asked = json.loads(line)
            if "wait" in asked:
                _, status = os.waitpid(asked["wait"], 0)
                answer = os.waitstatus_to_exitcode(status)
            else:
                output = os.open(asked["output"], os.O_WRONLY)
                assert len(list(Path("/proc/self/task").iterdir())) == 1
                answer = os.fork()
                if not answer:
                    _say_into(output)
                    return asked
                os.close(output)
            answers.write(f"{answer}\n")
            answers.flush()
    return None


def _say_into(output: int) -> None:
    """Let this process read nothing, and write there."""
    nothing = os.open(os.devnull, os.O_RDONLY)
    for given, standard in ((nothing, 0), (output, 1), (output, 2)):
        os.dup2(given, standard)
    os.close(nothing)
    os.close(output)


def main() -> None:
    """Serve, and be `dray up` in each process that is forked."""
    prepare_shapes()
    gc.freeze()
    asked = serve()
    if asked is not None:
        os.environ.clear()
        os.environ.update(asked["env"])
        os.chdir(asked["cwd"])
        sys.argv[1:] = asked["options"]
        stepped_up.main()


if __name__ == "__main__":
    main()
