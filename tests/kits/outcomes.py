"""What is known of a test before its teardown begins."""

from __future__ import annotations

import pytest

HAS_FAILED = pytest.StashKey[bool]()
"""Whether its setup or its call has failed."""
