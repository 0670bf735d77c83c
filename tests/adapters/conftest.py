"""Lets the tests of all rooms here import `zenoh_kit`, `floor_house` and `issued`."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
