"""A product as written by people, and its form in the plant."""

from __future__ import annotations

from typing import Annotated

import msgspec
from pydantic import BaseModel, ConfigDict, Field, field_validator
from pydantic_core import PydanticCustomError

from dray.gateway.http.request_bodies import Line, few
from dray.messages import Document
from dray.messages.product import DOCUMENTS_MAX
from dray.plant import BillLine, Product

ID = r"^[A-Za-z][A-Za-z0-9_.-]{0,31}$"

LINES_MAX = 100
"""Maximum lines of a bill; a machine has a buffer for each."""

MACHINES_MAX = 200

Name = Annotated[str, Field(pattern=ID)]

Pieces = Annotated[int, Field(strict=True, ge=1, le=100_000)]

Seconds = Annotated[float, Field(ge=0.1, le=1e6, allow_inf_nan=False)]


class DocumentDraft(BaseModel):
    """A document of a product."""

    model_config = ConfigDict(extra="forbid")

    name: Annotated[Line, Field(max_length=80)]
    address: Annotated[str, Field(pattern=r"^https?://[^\s\"'<>\\]{1,248}$")]
    """Address for machines and people: `http://` or `https://`."""
    media_type: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.+-]{0,47}/[A-Za-z0-9_.+-]{1,80}$")]
    """Such as `application/pdf`."""
    sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
    """SHA-256 of its content, in hexadecimal digits: machines accept nothing else."""


class ProductDraft(BaseModel):
    """A product's new definition."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [{"name": "Gear unit", "lot": 4, "bill": {"shaft": 2}, "machines": {"M1": 36.0}}]
        },
    )

    name: Annotated[Line, Field(max_length=80)]
    lot: Pieces
    """Pieces in one container."""
    bill: Annotated[dict[Name, Pieces], Field(min_length=1, max_length=LINES_MAX), few(LINES_MAX)]
    """Pieces of each material per piece."""
    ability: Name = "tote"
    """Ability that a vehicle needs to carry it."""
    machines: Annotated[dict[Name, Seconds], Field(max_length=MACHINES_MAX), few(MACHINES_MAX)] = Field(
        default_factory=dict
    )
    """Seconds per piece, by capable machine. Machines set up for it in the plant file are optional."""
    documents: Annotated[list[DocumentDraft], Field(max_length=DOCUMENTS_MAX)] = Field(default_factory=list)
    """Documents for its makers: a machine verifies all before it begins a piece."""

    @field_validator("documents")
    @classmethod
    def _once(cls, documents: list[DocumentDraft]) -> list[DocumentDraft]:
        names = [document.name for document in documents]
        if len(set(names)) < len(names):
            raise PydanticCustomError("document_twice", "two documents have the same name")
        return documents

    def product(self, id_: str) -> Product:
        """The product as the plant has it."""
        bill = tuple(BillLine(material, quantity) for material, quantity in self.bill.items())
        return Product(id=id_, name=self.name, lot=self.lot, bill=bill, ability=self.ability)


class Wanted(msgspec.Struct, frozen=True):
    """A product to define, and the revision that it replaces."""

    product: Product
    machines: dict[str, float]
    documents: tuple[Document, ...]
    before: int | None
    """None for a new product."""


def wanted(id_: str, draft: ProductDraft, before: int | None) -> Wanted:
    """The definition that a draft asks for."""
    documents = tuple(Document(**document.model_dump()) for document in draft.documents)
    return Wanted(draft.product(id_), draft.machines, documents, before)
