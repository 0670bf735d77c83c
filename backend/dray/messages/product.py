"""What is to be known of a product to make and carry it: it travels with the orders and goals that ask for it (paper, 4.1)."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, Part, Text

Pieces = Annotated[int, Meta(ge=1, le=10**6)]
"""Of a container or of one line of a bill: none is larger."""

CycleSeconds = Annotated[float, Meta(ge=0.001, le=1e7)]
"""For one piece: none takes longer than four months."""

BILL_MAX = 100
"""Lines of one bill: a machine has a buffer for each."""

MACHINES_MAX = 200
"""Machines that one definition names."""


class BillLine(Part, frozen=True):
    """So many pieces of a material go into one piece of the product."""

    material: Id
    quantity: Pieces


class MachineCycle(Part, frozen=True):
    """A machine that can make the product, and how long it takes for one piece."""

    machine: Id
    cycle_s: CycleSeconds


class ProductDefinition(Part, frozen=True, omit_defaults=True):
    """A product at one revision.

    Whoever has a goal needs no table of products for it, and a goal keeps the revision with which it was given out. Pieces
    of two revisions of a product replace one another; what does not is another product.
    """

    lot: Pieces
    """In one container on the way to the delivery warehouse."""
    ability: Id
    """What a vehicle must be able to carry."""
    bill: Annotated[tuple[BillLine, ...], Meta(min_length=1, max_length=BILL_MAX)]
    """What one piece takes; a material stands in it once."""
    name: Text = ""
    revision: Count = 1
    """Grows with every change of the master data."""
    machines: Annotated[tuple[MachineCycle, ...], Meta(max_length=MACHINES_MAX)] = ()
    """Those that can make it though they do not say so themselves; a machine's own word on its time comes first."""
