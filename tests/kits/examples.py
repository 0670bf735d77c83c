"""How many examples Hypothesis tries: a part in `make test`, all of them in `make test-long`.

Both run every test that Hypothesis leads: `make test-long` asks for its marker.
"""

from __future__ import annotations

import os

ALL = os.environ.get("DRAY_TEST_EXAMPLES") == "all"

SHARE = 5


def examples(count: int) -> int:
    """That many in `make test-long`, a fifth of them in `make test`."""
    return count if ALL else max(1, count // SHARE)
