"""The tables of all states, drawn: `python -m dray.protocol.states > docs/states.md`."""

from __future__ import annotations

import sys
from typing import Any

from dray.protocol.calls import call_state
from dray.protocol.contract_net import auction, task_state
from dray.protocol.machine import documents
from dray.protocol.vehicle.job import job_state
from dray.states import Transitions, diagram

TABLES: dict[str, tuple[str, str, Transitions[Any]]] = {
    "A task": ("contract_net/task_state.py", "as its coordinator knows it", task_state.TRANSITIONS),
    "An auction": ("contract_net/auction.py", "for the contractor of a task", auction.STAGES),
    "A transport job": (
        "vehicle/job/job_state.py",
        "as the vehicle that carries it lives it",
        job_state.TRANSITIONS,
    ),
    "A document of a goal": ("machine/documents.py", "as the machine knows it", documents.TRANSITIONS),
    "A call for help": ("calls/call_state.py", "as its caller knows it", call_state.TRANSITIONS),
}
"""By title: the file, what it is, and the table."""


INTRODUCTION = """\
# States

Drawn from the tables in `backend/dray/protocol`, by which alone a state is changed: what is not drawn here is a fault of ours,
and ends the agent. `python -m dray.protocol.states > docs/states.md` draws it again.
"""


def document() -> str:
    """The text of docs/states.md."""
    parts = [INTRODUCTION]
    for title, (file, what, transitions) in TABLES.items():
        parts.append(f"## {title}\n\n`{file}`: {what}.\n\n```mermaid\n{diagram(transitions)}\n```\n")
    return "\n".join(parts)


if __name__ == "__main__":
    sys.stdout.write(document())
