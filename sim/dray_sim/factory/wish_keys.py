"""Keys of simulated vehicles: as safe as real ones against agents without them, and a hundred times cheaper."""

from __future__ import annotations

from hashlib import sha256

from msgspec.structs import replace

from dray.messages import PlaceWished
from dray.messages.floor.traffic import wished_words
from dray.protocol.traffic.driving.wishes import Sign


class WishKeys:
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

        def sign(wish: PlaceWished) -> PlaceWished:
            return replace(wish, key=public, signature=_signature(secret, atv, wish))

        return sign

    def is_signed(self, atv: str, wish: PlaceWished) -> bool:
        """Whether a vehicle's wish is signed by the key that it names, or names none."""
        if not wish.key:
            return True
        secret = self._secrets.get(wish.key)
        return secret is not None and _signature(secret, atv, wish) == wish.signature


def _signature(secret: bytes, atv: str, wish: PlaceWished) -> bytes:
    return sha256(secret + wished_words(atv, wish)).digest()
