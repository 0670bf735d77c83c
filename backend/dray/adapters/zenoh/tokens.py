"""Liveliness tokens: the present agents, with their lives.

    {plant}/alive/{agent}/{life}/{seal}

The life is the agent's incarnation from its journal, not a time: whatever clocks do, a restart is later than the life that it
replaces. With certificates the last chunk contains the agent's signature over its name and its life, and its certificate. So no
process can claim that another agent lives elsewhere. A replayed token has no effect, because the latest life counts.
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
"""The life of a tool without a journal, which only listens: it replaces no other life."""

_LIFE = re.compile(r"[0-9]{1,16}")
"""As long as a `Count` may be."""

_NONCE_BYTES = 8
"""Length of the nonce without certificates: it distinguishes two lives with one number."""


@dataclass(frozen=True, slots=True)
class Token:
    """A present or past life of an agent.

    Attributes:
        agent: its id.
        life: see `dray.ports.Bus.join`.
        seal: proves the agent's authorship; without certificates a unique text.
        certificate: the agent's, in DER; empty without certificates.
    """

    agent: str
    life: int
    seal: str
    certificate: bytes = b""

    def replaces(self, other: Token) -> bool:
        """Whether this is a later life of the same agent.

        Two lives with one number come from a copied journal. One of them must leave, and both sides choose
        the same one.
        """
        return self.life != NO_LIFE and (self.life, self.seal) > (other.life, other.seal)


class Tokens:
    """All tokens of one sort in a plant. Thread-safe.

    Args:
        under: the path above them.
        seals: the known agents; None on a bus without certificates.
        refuse: called with the reason for an invalid token.
    """

    def __init__(self, under: str, seals: Seals | None, refuse: Callable[[str], None]) -> None:
        self._under, self._seals, self._refuse = under, seals, refuse
        self.everybody = f"{under}/*/*/*"
        """The pattern of all tokens."""

    def of(self, agent: str, life: int) -> Token:
        """The token of an agent of this process, in this life."""
        if self._seals is None:
            return Token(agent, life, secrets.token_hex(_NONCE_BYTES))
        return Token(agent, life, self._seals.vouch(self._words(agent, life)))

    def pair_of(self, agent: str, life: int) -> tuple[Token, Token]:
        """Two tokens of an agent of this process in this life, as `of`. The second one sorts later."""
        earlier, later = sorted((self.of(agent, life), self.of(agent, life)), key=lambda token: token.seal)
        return earlier, later

    def key(self, token: Token) -> str:
        """A token's key."""
        return f"{self._words(token.agent, token.life)}/{token.seal}"

    def all_of(self, agent: str) -> str:
        """The pattern of one agent's tokens."""
        return f"{self._under}/{agent}/*/*"

    def agent_of(self, key: str) -> str:
        """The agent that a key names; empty for none, as a pattern. A pattern passes rules that deny an agent's own keys."""
        return self._chunks(key)[0]

    def read(self, key: str) -> Token | None:
        """The token of a key; None, and refused, when it is invalid."""
        agent, life, seal = self._chunks(key)
        if _LIFE.fullmatch(life):
            with contextlib.suppress(SealError):
                return Token(agent, int(life), seal, self._certificate(agent, int(life), seal))
        self._refuse(UNSIGNED)
        return None

    def brings_news(self, key: str) -> bool:
        """Whether a key contains a new certificate of its agent.

        An agent may declare any number of tokens: known ones cost others no verification.
        """
        agent, _, seal = self._chunks(key)
        try:
            return self._seals is not None and not self._seals.is_met_by(seal, agent)
        except SealError:
            self._refuse(UNSIGNED)
            return False

    def _chunks(self, key: str) -> tuple[str, str, str]:
        """Agent, life and seal; empty for a key of another form: tokens on patterns match, too."""
        under, *chunks = key.rsplit("/", 3)
        if under != self._under or len(chunks) != 3 or "*" in key:
            return "", "", ""
        agent, life, seal = chunks
        return agent, life, seal

    def _certificate(self, agent: str, life: int, seal: str) -> bytes:
        """The agent's certificate, by its signature of this life; on a plain bus every token is believed.

        Raises:
            SealError: the signature is not the agent's.
        """
        if self._seals is None:
            return b""
        return self._seals.examine_voucher(seal, agent, self._words(agent, life))

    def _words(self, agent: str, life: int) -> str:
        return f"{self._under}/{agent}/{life}"
