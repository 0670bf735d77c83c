"""Liveliness tokens: who is there, and in which of its lives.

    {plant}/alive/{agent}/{life}/{seal}

The life is the agent's incarnation, from its journal, and no time: whatever clocks do, a restart is later than the
life that it replaces. With certificates the last chunk is the agent's signature over its name and its life, and
brings its certificate along; so nobody can say that another agent lives on elsewhere. A token that is said again by
somebody else says nothing new: the latest life counts.
"""

from __future__ import annotations

import contextlib
import re
import secrets
from collections.abc import Callable
from dataclasses import dataclass

from dray.adapters.security.seals import Seals
from dray.errors import SealError

UNSIGNED = "a token that is not signed by its agent"

NO_LIFE = 0
"""Of whoever keeps no journal, a tool that only looks: it replaces nobody."""

_LIFE = re.compile(r"[0-9]{1,16}")
"""As long as a `Count` may be."""

_NONCE_BYTES = 8
"""Of a token without certificates: enough for two lives with one number never to be the same."""


@dataclass(frozen=True, slots=True)
class Token:
    """One life of an agent that is there, or was.

    Attributes:
        agent: whose.
        life: see `dray.ports.Bus.join`.
        seal: says that it was the agent who has said so; without certificates something that no other token has.
        certificate: the agent's, in DER; empty without certificates.
    """

    agent: str
    life: int
    seal: str
    certificate: bytes = b""

    def replaces(self, other: Token) -> bool:
        """Whether this is a later life of the same agent.

        Two lives with one number come from a journal that was copied. One of them has to go; which one, both sides
        say alike.
        """
        return self.life != NO_LIFE and (self.life, self.seal) > (other.life, other.seal)


class Tokens:
    """All tokens of one sort in a plant. On any thread.

    Args:
        under: the path under which they are.
        seals: by which agents are known; None on a bus without certificates.
        refuse: told the reason why a token says nothing.
    """

    def __init__(self, under: str, seals: Seals | None, refuse: Callable[[str], None]) -> None:
        self._under, self._seals, self._refuse = under, seals, refuse
        self.everybody = f"{under}/*/*/*"
        """Matches all of them."""

    def of(self, agent: str, life: int) -> Token:
        """The token of an agent of this process, in this life."""
        if self._seals is None:
            return Token(agent, life, secrets.token_hex(_NONCE_BYTES))
        return Token(agent, life, self._seals.vouch(self._words(agent, life)))

    def key(self, token: Token) -> str:
        """The key that says it."""
        return f"{self._words(token.agent, token.life)}/{token.seal}"

    def all_of(self, agent: str) -> str:
        """Matches those of one agent."""
        return f"{self._under}/{agent}/*/*"

    def read(self, key: str) -> Token | None:
        """What a key on `everybody` says; None, and refused, when it says nothing."""
        agent, life, seal = key.rsplit("/", 3)[1:]
        if _LIFE.fullmatch(life):
            with contextlib.suppress(SealError):
                return Token(agent, int(life), seal, self._certificate(agent, int(life), seal))
        self._refuse(UNSIGNED)
        return None

    def brings_news(self, key: str) -> bool:
        """Whether a key on `everybody` brings a certificate by which its agent is not known yet.

        An agent may declare any number of tokens: what is known already costs others no signature.
        """
        agent, _, seal = key.rsplit("/", 3)[1:]
        try:
            return self._seals is not None and not self._seals.is_met_by(seal, agent)
        except SealError:
            self._refuse(UNSIGNED)
            return False

    def _certificate(self, agent: str, life: int, seal: str) -> bytes:
        """The certificate of the agent, who has said that this life is there; on a plain bus everybody is believed.

        Raises:
            SealError: it has not.
        """
        if self._seals is None:
            return b""
        return self._seals.examine_voucher(seal, agent, self._words(agent, life))

    def _words(self, agent: str, life: int) -> str:
        return f"{self._under}/{agent}/{life}"
