"""Keys of simulated vehicles: as safe as real ones against agents without them, and a hundred times cheaper."""

from __future__ import annotations

from hashlib import sha256

from msgspec.structs import replace

from dray.messages import PlaceRequested
from dray.messages.floor.traffic import request_words
from dray.protocol.traffic.driving.place_requests import Sign


class RequestKeys:
    """The keys of one factory. They follow from its seed, and outlive every life of an agent.

    Args:
        seed: of the factory.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._secrets: dict[bytes, bytes] = {}
        """Public key -> the secret of its vehicle."""

    def of(self, whose: str, name: str = "") -> Sign:
        """A signer with a vehicle's key, under its own name or another one."""
        secret = sha256(f"{self._seed} key of {whose}".encode()).digest()
        public = sha256(secret).digest()
        self._secrets[public] = secret
        atv = name or whose

        def sign(request: PlaceRequested) -> PlaceRequested:
            return replace(request, key=public, signature=_signature(secret, atv, request))

        return sign

    def is_signed(self, atv: str, request: PlaceRequested) -> bool:
        """Whether a vehicle's request is signed by the key that it names, or names none."""
        if not request.key:
            return True
        secret = self._secrets.get(request.key)
        return secret is not None and _signature(secret, atv, request) == request.signature


def _signature(secret: bytes, atv: str, request: PlaceRequested) -> bytes:
    return sha256(secret + request_words(atv, request)).digest()
