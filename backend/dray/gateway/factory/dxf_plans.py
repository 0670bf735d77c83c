"""Floor plans in DXF as pictures: runs `dray plant picture` in a bounded process.

A plan is untrusted input.
"""

from __future__ import annotations

import asyncio
import sys
import zlib
from http import HTTPStatus
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec

from dray.errors import DrayError
from dray.gateway.factory.plant_drafts import NoteView
from dray.gateway.http.bounded_process import run_bounded
from dray.gateway.http.problems import Problem
from dray.plant.exchange.dxf import MAX_BYTES

MOST_S = 60.0
"""Maximum wall seconds per plan; one of ten megabytes takes some ten."""

MOST_MEMORY = 2 * 1024**3
"""Maximum bytes of memory per plan."""

GZIP = b"\x1f\x8b"

TAIL_CHARS = 300
"""Maximum characters quoted of a failed process's output."""


class NoPlan(DrayError):
    """A plan that cannot be converted; the text says why."""


class Picture(msgspec.Struct, frozen=True, kw_only=True):
    """The result for a plan."""

    width_m: float
    height_m: float
    notes: tuple[NoteView, ...] = ()
    svg: bytes = b""


class DxfPlans:
    """Makes one picture at a time.

    Args:
        command: the program to start, before the arguments of `dray plant picture`.
        most_s: maximum wall seconds per plan.
    """

    def __init__(
        self,
        command: tuple[str, ...] = (sys.executable, "-m", "dray", "plant", "picture"),
        most_s: float = MOST_S,
    ) -> None:
        self._command, self._most_s = command, most_s
        self._one = asyncio.Lock()

    async def picture(self, content: bytes) -> Picture:
        """The picture of a DXF file, plain or gzipped.

        Raises:
            NoPlan: it is no plan, or too large.
            Problem: 503, another plan is being read.
        """
        if self._one.locked():
            raise Problem(
                HTTPStatus.SERVICE_UNAVAILABLE,
                "plan-being-read",
                "Another floor plan is being read",
                "try again in some seconds",
                headers={"Retry-After": "5"},
            )
        async with self._one:
            with TemporaryDirectory(prefix="dray-plan-") as folder:
                return await self._read(Path(folder), await asyncio.to_thread(unpacked, content))

    async def _read(self, folder: Path, content: bytes) -> Picture:
        plan, picture, report = folder / "plan.dxf", folder / "plan.svg", folder / "plan.json"
        await asyncio.to_thread(plan.write_bytes, content)
        command = (*self._command, str(plan), "--out", str(picture), "--json", str(report))
        try:
            code, said = await run_bounded(command, self._most_s, MOST_MEMORY)
        except TimeoutError:
            raise NoPlan(
                f"it took longer than {self._most_s:g} s to read: hide layers, and save it again"
            ) from None
        if code:
            words = " ".join(said.split()).replace(f"{folder}/", "").removeprefix("dray: ")
            raise NoPlan(words[-TAIL_CHARS:] or "reading it failed")
        told = msgspec.json.decode(await asyncio.to_thread(report.read_bytes), type=Picture)
        return msgspec.structs.replace(told, svg=await asyncio.to_thread(picture.read_bytes))


def unpacked(content: bytes) -> bytes:
    """Unpack gzip; other content is returned unchanged.

    Raises:
        NoPlan: it is broken, or larger than allowed.
    """
    if not content.startswith(GZIP):
        return content
    unpacking = zlib.decompressobj(wbits=31)
    try:
        found = unpacking.decompress(content, MAX_BYTES)
    except zlib.error as error:
        raise NoPlan(f"it is packed badly: {error}") from None
    if unpacking.unconsumed_tail:
        raise NoPlan(f"unpacked it has more than {MAX_BYTES} bytes: hide layers, and save it again")
    if not unpacking.eof:
        raise NoPlan("it is packed badly: its end is missing")
    return found
