"""The result of one run, and of many: plain data that passes from process to process."""

from __future__ import annotations

import msgspec


class Outcome(msgspec.Struct, frozen=True):
    """The result of one run."""

    seed: int
    profile: str
    broken: str
    """The violation, in words; empty when everything held."""
    duration_s: float
    """Virtual time."""
    transports: int
    """Handed over."""
    takeovers: int
    restarts: int
    """Agents that were started again."""
    messages: int
    faults: dict[str, int]
    """Number of faults that began, by kind."""
    trace: str = ""
    """The fingerprint of all messages; empty when it was not taken."""
    story: tuple[str, ...] = ()
    """The last events before the violation, line by line; empty without a violation, or when no story was kept."""
    traffic: bool = False
    """Whether vehicles drove with right of way."""

    @property
    def replay(self) -> str:
        """The command that plays this run again."""
        profile = "" if self.profile == "all" else f" --profile {self.profile}"
        return (
            f"dray sim explore --seed {self.seed}{profile}{' --traffic' if self.traffic else ' --no-traffic'}"
        )


class Summary(msgspec.Struct, frozen=True):
    """A search, as far as it came."""

    first: int
    last: int
    """Seeds from the first to before the last were asked for."""
    profile: str
    runs: int
    """Played to their end."""
    interrupted: bool
    violations: tuple[Outcome, ...]
    """The first violations, in the order of their seeds."""
    broken: int
    """All that broke, those too that are not in `violations`."""
    virtual_s: float
    busy_s: float
    """Processor time, of all processes together."""
    jobs: int
    transports: int
    takeovers: int
    restarts: int
    messages: int
    faults: dict[str, int]
    before: int = 0
    """Of `runs`, those that an earlier search has played (`dray_sim.explore.ledger`)."""

    @property
    def rate(self) -> float:
        """Seeds in a minute of one core that does nothing else."""
        return 60.0 * self.runs / self.busy_s if self.busy_s else 0.0
