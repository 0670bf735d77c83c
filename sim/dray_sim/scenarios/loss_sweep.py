"""How much loss the factory endures: the same demand with 0 to 40 % of all messages lost."""

from __future__ import annotations

from functools import partial

from dray.plant import Plant, default_plant
from dray_sim.faults import LinkTrouble
from dray_sim.run.evidence import Check, Table
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Shift, Stage, play
from dray_sim.scenarios.tally import HEAD, Tally, all_delivered, listed, row, run_out

LOSSES_FRAC = (0.0, 0.05, 0.10, 0.20, 0.30, 0.40)

ENDURED_FRAC = 0.30
"""Largest loss under which the claim must hold. At 40 % an agent is suspected before others have learned the loss."""

SHIFT = Shift(name="loss-sweep", duration_s=2 * 3600.0, load=0.6)

STARVED_FRAC = 0.02

TAKEOVERS_PER_TRANSPORT = 0.05
"""Most takeovers at the worst loss: suspicion learns the loss, so that hardly any living vehicle is replaced."""


async def lose(stage: Stage, loss_frac: float) -> Tally:
    """Let the demand come in while a part of all deliveries is lost, and work it off."""
    if loss_frac:
        stage.faults.begin(LinkTrouble(loss_frac=loss_frac))
    return await run_out(stage)


def sweep(
    seed: int,
    losses_frac: tuple[float, ...] = LOSSES_FRAC,
    shift: Shift = SHIFT,
    plant: Plant | None = None,
) -> Findings:
    """Play the same demand once for every loss, and judge those up to `ENDURED_FRAC`."""
    runs = tuple(
        play(shift, plant or default_plant(), seed, partial(lose, loss_frac=loss_frac))
        for loss_frac in losses_frac
    )
    endured = tuple(
        played for loss_frac, played in zip(losses_frac, runs, strict=True) if loss_frac <= ENDURED_FRAC
    )
    starved = [played.report.starvation_frac for played in endured]
    changed = [played.result.carriers_changed if played.result else -1 for played in endured]
    allowed = [TAKEOVERS_PER_TRANSPORT * played.report.transports for played in endured]
    return Findings(
        runs=runs,
        checks=(
            all_delivered(endured),
            Check(
                "What is lost is said again, and hardly anybody who lives is taken for dead",
                all(0 <= count <= most for count, most in zip(changed, allowed, strict=True)),
                f"carriers changed: {listed(changed)}; at most {TAKEOVERS_PER_TRANSPORT:.0%} of the transports are allowed",
            ),
            Check(
                f"Machines are without material less than {STARVED_FRAC:.0%} of their time",
                max(starved) < STARVED_FRAC,
                ", ".join(f"{frac:.2%}" for frac in starved),
            ),
        ),
        tables=(
            Table(
                "The same demand at each loss",
                ("loss", *HEAD),
                tuple(
                    (f"{loss_frac:.0%}", *row(played))
                    for loss_frac, played in zip(losses_frac, runs, strict=True)
                ),
            ),
        ),
    )


LOSS_SWEEP = Scenario(
    name="loss-sweep",
    shows="The same demand with 0 to 40 % of all messages lost.",
    source="paper, 3.1",
    claim=(
        "Connections may be interrupted for a while. Agents endure it: whatever matters is repeated until it is answered, "
        "so that losses cost time and nothing else."
    ),
    story=(
        f"{SHIFT.duration_s / 3600:g} hours of demand at {SHIFT.load:.0%} load in the default plant, once for each part of "
        "all deliveries that is lost by chance, and then as long as the last order takes. It is judged up to "
        f"{ENDURED_FRAC:.0%}; beyond that the table shows what it costs."
    ),
    play=sweep,
    elsewhere=lambda seed, site: sweep(seed, shift=site.shift(SHIFT), plant=site.ground),
)
