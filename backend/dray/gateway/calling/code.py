"""The QR code of a call key's page, shown at its place."""

from __future__ import annotations

from io import BytesIO

import segno

QUIET_MODULES = 4
"""Width of the light border in modules, by ISO/IEC 18004."""


def drawn(address: str) -> bytes:
    """An address as a QR code: an SVG image without fixed size, black on white.

    Up to a seventh of it may be unreadable (error correction M).

    Args:
        address: at most 2,331 bytes.
    """
    image = BytesIO()
    code = segno.make_qr(address, error="m", boost_error=False)
    code.save(image, kind="svg", border=QUIET_MODULES, dark="#000", light="#fff", omitsize=True)
    return image.getvalue()
