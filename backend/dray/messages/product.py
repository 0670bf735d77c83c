"""The data that making and carrying a product needs; they travel with its orders and goals (paper, 4.1)."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, Part, Text

Pieces = Annotated[int, Meta(ge=1, le=10**6)]
"""Pieces in a container or in one line of a bill."""

CycleSeconds = Annotated[float, Meta(ge=0.001, le=1e7)]
"""Time for one piece: at most four months."""

BILL_MAX = 100
"""Maximum lines of one bill: a machine has a buffer for each."""

MACHINES_MAX = 200
"""Maximum machines in one definition."""


DOCUMENTS_MAX = 8
"""Maximum documents of one product: CAD, CAM programs for its kinds of machines, an instruction. They travel with every goal."""

DOCUMENTS_TOLD = 16
"""Maximum documents in one heartbeat: those of the most urgent goals."""

Address = Annotated[str, Meta(pattern=r"^https?://[^\s]{1,248}(?!\n)$", max_length=256)]

MediaType = Annotated[str, Meta(pattern=r"^[A-Za-z0-9][\w.+-]{0,47}/[\w.+-]{1,80}(?!\n)$", max_length=128)]

Sha256 = Annotated[str, Meta(pattern=r"^[0-9a-f]{64}(?!\n)$")]


class BillLine(Part, frozen=True):
    """The pieces of a material, or of a part, in one piece of the product."""

    material: Id
    quantity: Pieces


class MachineCycle(Part, frozen=True):
    """A machine that can make the product, and its time for one piece."""

    machine: Id
    cycle_s: CycleSeconds


class Document(Part, frozen=True):
    """A document for making a product: a CAD file, a CAM program, an instruction."""

    name: Annotated[str, Meta(min_length=1, max_length=80)]
    address: Address
    """The address from which it is fetched."""
    media_type: MediaType
    sha256: Sha256
    """Checksum of its content: a machine uses no other content."""


class DocumentState(StrEnum):
    """The state of a document at a machine."""

    UNREAD = "unread"
    READING = "reading"
    """It is being fetched."""
    VERIFIED = "verified"
    """Its checksum is right: it may be used."""
    DIFFERS = "differs"
    """The content at its address has another checksum."""
    UNREACHABLE = "unreachable"
    """It cannot be fetched."""


class DocumentBrief(Part, frozen=True, omit_defaults=True):
    """A document of a goal's product, as a machine reports it."""

    product: Id
    document: Document
    state: DocumentState
    detail: Text = ""
    """The reason why it cannot be used, if it cannot."""


class ProductDefinition(Part, frozen=True, omit_defaults=True):
    """A product at one revision.

    A goal contains it, so that a machine needs no table of products, and keeps the revision with which it was given out. Pieces of
    two revisions are interchangeable; otherwise they are two products.
    """

    lot: Pieces
    """Pieces in one container on the way to the delivery warehouse."""
    ability: Id
    """What a vehicle must be able to carry."""
    bill: Annotated[tuple[BillLine, ...], Meta(min_length=1, max_length=BILL_MAX)]
    """The materials of one piece; each has one line."""
    name: Text = ""
    revision: Count = 1
    """Grows with every change of the master data."""
    machines: Annotated[tuple[MachineCycle, ...], Meta(max_length=MACHINES_MAX)] = ()
    """Machines that can make it beside those that say so themselves; a machine's own cycle time comes first."""
    documents: Annotated[tuple[Document, ...], Meta(max_length=DOCUMENTS_MAX)] = ()
    """The documents for making it; no piece is begun before the machine has verified all of them."""


class PartDefinition(Part, frozen=True):
    """A part and its definition, for an order of a product that contains it."""

    part: Id
    definition: ProductDefinition
