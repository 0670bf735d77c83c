"""What processes print whose hashes have other seeds: no order of a set may decide anything."""

from __future__ import annotations

import os
import subprocess
import sys

SEEDS = ("0", "4711")


def printed_by_each(script: str, *arguments: str) -> set[str]:
    """What a script prints in one process for each seed, which finds what this one finds; one text if all print the same."""
    return {
        subprocess.run(
            [sys.executable, "-c", script, *arguments],
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(sys.path)},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for seed in SEEDS
    }
