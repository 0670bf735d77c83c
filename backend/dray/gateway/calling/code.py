"""The QR code of a call key's page, which hangs at its place."""

from __future__ import annotations

from io import BytesIO

import segno

QUIET_MODULES = 4
"""Light modules around the code, as ISO/IEC 18004 asks."""


def drawn(address: str) -> bytes:
    """An address as a QR code: an SVG image without a size of its own, black on white.

    A seventh of it may be dirty (error correction M).

    Args:
        address: 2,331 bytes at most.
    """
    image = BytesIO()
    code = segno.make_qr(address, error="m", boost_error=False)
    code.save(image, kind="svg", border=QUIET_MODULES, dark="#000", light="#fff", omitsize=True)
    return image.getvalue()
