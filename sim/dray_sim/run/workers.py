"""Processes that work for a parent, and end with it in any case."""

from __future__ import annotations

import multiprocessing
import os
import threading
from multiprocessing.connection import wait


def end_with_parent() -> None:
    """End this process of a pool when its parent is gone; called in that process.

    A pool asks its processes to end when its own process ends gracefully. A parent that is killed cannot ask, and its
    processes would wait for work for ever.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_follow, args=(parent.sentinel,), daemon=True).start()


def _follow(parent: int) -> None:
    wait([parent])
    os._exit(1)
