"""Proofs: signed requests of vehicles, which show the other replicas that a line was struck out by its own vehicle.

A replica that has missed some versions refuses a table in which a place is no longer its holder's (`witness`), unless the leader
sends the request that gave the place back. So the leader keeps such requests until every replica has copied their effect.

Which request proves more does not follow from its age alone, nor from the grants that its vehicle has seen. A request that was
overtaken on its way names places that its vehicle has given back since. A vehicle that has just started has seen no grant yet.
And after a recovery poll the numbers of grants may begin below those that vehicles saw before. So a request replaces an earlier one
only when it is newer and has seen as much; otherwise both are kept.

They are journalled with the table (`words`, `restore`). A vehicle that has started again meanwhile has seen no grant, and cannot
prove anew what it gave back in its earlier life.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import msgspec

from dray.messages.floor.traffic import AllGivenBack, GivenBack, PlaceRequested

EACH_MAX = 3
"""Maximum proofs under one key: a vehicle that has started again needs two until it has seen a grant."""

IDLE_MAX = 4
"""Maximum keys of one vehicle's name with requests that have struck out nothing. A thief of its certificate makes up any number."""


class Proof(msgspec.Struct, frozen=True):
    """One vehicle's request under one key."""

    request: PlaceRequested
    version: int
    """The first version of the table without the lines that it has struck out."""
    oldest: int
    """The lowest grant number of these lines; 0 when it is unknown. A replica that has no such line needs no proof."""
    struck: bool
    """Whether it has struck out any lines of the leader's table. If not, it may still be missing elsewhere."""


class Proofs:
    """The proofs that one leader keeps."""

    def __init__(self) -> None:
        self._of: dict[tuple[str, bytes], list[Proof]] = {}
        """Vehicle and mark of the key -> its proofs, oldest first."""

    def note(self, atv: str, request: PlaceRequested, version: int, *, struck: bool, oldest: int) -> None:
        """Keep a request.

        Args:
            atv: the vehicle.
            request: what it has said.
            version: of the table that was written last.
            struck: whether it has struck lines out since.
            oldest: the lowest grant number of these lines; 0 when it is unknown.
        """
        if not request.mark or not request.seen:
            # Nobody can examine it, or it gives nothing back.
            return
        one = atv, request.mark
        known = self._of.get(one, [])
        if not struck and any(_age(request) <= _age(proof.request) for proof in known):
            return
        if not struck and not known and self._idle(atv) >= IDLE_MAX:
            return
        proof, kept = Proof(request, version + struck, oldest if struck else 0, struck), list[Proof]()
        for before in known:
            if _age(request) > _age(before.request) and request.seen >= before.request.seen:
                proof = Proof(
                    request,
                    max(proof.version, before.version),
                    min(proof.oldest, before.oldest),
                    struck or before.struck,
                )
            else:
                kept.append(before)
        self._of[one] = [*kept[: EACH_MAX - 1], proof]

    def needed(self, has: int, may_have: int) -> Iterator[tuple[str, PlaceRequested]]:
        """Vehicle and request of all proofs that a replica needs.

        Args:
            has: the version that the replica has copied under this epoch; -1 for none.
            may_have: the highest grant number of the lines that it may have.
        """
        for (atv, _), proofs in self._of.items():
            yield from ((atv, proof.request) for proof in proofs if _is_needed(proof, has, may_have))

    def drop(self, replicas: Sequence[tuple[int, int]]) -> None:
        """Forget what no replica needs any more, by what each has and may have (see `needed`)."""
        left = {
            one: [proof for proof in proofs if any(_is_needed(proof, *has) for has in replicas)]
            for one, proofs in self._of.items()
        }
        self._of = {one: proofs for one, proofs in left.items() if proofs}

    def words(self) -> AllGivenBack:
        """The requests that have struck out lines, for the journal."""
        return tuple(
            GivenBack(atv=atv, request=msgspec.structs.replace(proof.request, avoid=()))
            for (atv, _), proofs in self._of.items()
            for proof in proofs
            if proof.struck
        )

    def restore(self, words: Iterable[GivenBack], version: int) -> None:
        """Continue with the requests of an earlier run, whose table had this version."""
        for word in words:
            proof = Proof(word.request, version, 0, struck=True)
            self._of.setdefault((word.atv, word.request.mark), []).append(proof)

    def _idle(self, atv: str) -> int:
        return sum(name == atv and not _has_struck(proofs) for (name, _), proofs in self._of.items())


def _has_struck(proofs: Iterable[Proof]) -> bool:
    return any(proof.struck for proof in proofs)


def _is_needed(proof: Proof, has: int, may_have: int) -> bool:
    return proof.version > has and proof.oldest <= may_have


def _age(request: PlaceRequested) -> tuple[int, int]:
    return request.life, request.seq
