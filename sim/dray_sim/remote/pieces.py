"""All pieces of a floor elsewhere, counted at one moment: how the material of many processes is balanced."""

from __future__ import annotations

import msgspec
import zenoh

from dray.adapters.remote_body.questions import ask_until_answered
from dray_sim.bodies.floor import Pieces


def pieces_key(plant: str) -> str:
    """The key of a floor's query for all its pieces."""
    return f"{plant}/floor/@pieces"


async def count_pieces(session: zenoh.Session, plant: str) -> Pieces:
    """Count all pieces of a floor elsewhere.

    Raises:
        UnavailableError: there is no floor.
    """
    answer = await ask_until_answered(session, pieces_key(plant), b"", "the floor")
    return msgspec.msgpack.decode(answer, type=Pieces)
