"""The stations of storages that have everything, for tests of others: each question is answered with yes."""

from __future__ import annotations

from dray.messages import Docked, DockOpened, Message, StockAsked, StockReserved
from dray.plant import default_plant

STORAGES = frozenset(default_plant().storages)


def answer(to: str, message: Message) -> Message | None:
    """What the station of a storage says; None when that was no question to one."""
    if to not in STORAGES:
        return None
    if isinstance(message, Docked):
        return DockOpened(task=message.task, epoch=message.epoch, station=to)
    if isinstance(message, StockAsked):
        return StockReserved(
            task=message.task, epoch=message.epoch, item=message.item, quantity=message.quantity
        )
    return None
