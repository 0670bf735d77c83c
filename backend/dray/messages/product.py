"""What is to be known of a product to make and carry it: it travels with the orders and goals that ask for it (paper, 4.1)."""

from __future__ import annotations

from enum import StrEnum
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


DOCUMENTS_MAX = 8
"""Documents of one product: CAD, CAM programs for its kinds of machines, an instruction. They travel with every goal."""

DOCUMENTS_TOLD = 16
"""Documents that one heartbeat tells of: those of the most urgent goals."""

Address = Annotated[str, Meta(pattern=r"^https?://[^\s]{1,248}(?!\n)$", max_length=256)]

MediaType = Annotated[str, Meta(pattern=r"^[A-Za-z0-9][\w.+-]{0,47}/[\w.+-]{1,80}(?!\n)$", max_length=128)]

Sha256 = Annotated[str, Meta(pattern=r"^[0-9a-f]{64}(?!\n)$")]


class BillLine(Part, frozen=True):
    """So many pieces of a material, or of a part, go into one piece of the product."""

    material: Id
    quantity: Pieces


class MachineCycle(Part, frozen=True):
    """A machine that can make the product, and how long it takes for one piece."""

    machine: Id
    cycle_s: CycleSeconds


class Document(Part, frozen=True):
    """What a machine or a person needs to make a product: a CAD file, a CAM program, an instruction."""

    name: Annotated[str, Meta(min_length=1, max_length=80)]
    address: Address
    """Where it is fetched."""
    media_type: MediaType
    sha256: Sha256
    """Of its content: a machine uses nothing else."""


class DocumentState(StrEnum):
    """How far a machine is with a document."""

    UNREAD = "unread"
    READING = "reading"
    """It is being fetched."""
    VERIFIED = "verified"
    """Its checksum is right: it may be used."""
    DIFFERS = "differs"
    """What lies at its address has another checksum."""
    UNREACHABLE = "unreachable"
    """It cannot be fetched."""


class DocumentBrief(Part, frozen=True, omit_defaults=True):
    """A document of a goal's product, as a machine tells of it."""

    product: Id
    document: Document
    state: DocumentState
    detail: Text = ""
    """What was found, of one that cannot be used."""


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
    documents: Annotated[tuple[Document, ...], Meta(max_length=DOCUMENTS_MAX)] = ()
    """What whoever makes it needs to know; no piece is begun before the machine has verified all of them."""


class PartDefinition(Part, frozen=True):
    """A part, and how it is made, for an order of a product that is made of it."""

    part: Id
    definition: ProductDefinition
