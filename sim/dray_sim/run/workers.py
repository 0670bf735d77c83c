"""Processes that work for another one, and end with it however it ends."""

from __future__ import annotations

import multiprocessing
import os
import threading
from multiprocessing.connection import wait


def end_with_parent() -> None:
    """To be called in a process of a pool: it ends when the one that has started it is gone.

    A pool asks its processes to end when its own process ends gracefully. One that is killed asks nobody, and its
    processes would wait for work for ever.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_follow, args=(parent.sentinel,), daemon=True).start()


def _follow(parent: int) -> None:
    wait([parent])
    os._exit(1)
