"""The plant in which agents are tested, and its keys."""

from __future__ import annotations

from dray.messages.keys import Keys
from dray.plant import load_plant

PLANT = load_plant("single-track")

KEYS = Keys(PLANT.id)


SOME_TIME_S = 1e6
"""When a paper vehicle says to be done: later than any test lasts, so that it is no bid for the impossible."""
