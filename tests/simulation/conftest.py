"""Lets the tests of all rooms here import what is in `kits`."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "kits"))
