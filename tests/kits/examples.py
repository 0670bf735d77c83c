"""How many examples Hypothesis tries: all of them in `make campaign`, which runs every test that Hypothesis leads, else a part."""

from __future__ import annotations

import os

ALL = os.environ.get("DRAY_TEST_EXAMPLES") == "all"

SHARE = 5


def examples(count: int) -> int:
    """That many in `make campaign`, else a fifth of them."""
    return count if ALL else max(1, count // SHARE)
