"""The scenario of a simulated factory: its progress, and skipping to the next step."""

from __future__ import annotations

from http import HTTPStatus

from fastapi import APIRouter

from dray.errors import UnavailableError
from dray.gateway.factory.scenario_play import ScenarioPlay
from dray.gateway.http.problems import Problem
from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.live.views import ScenarioView, StepView
from dray.scenario_steps import ScenarioStep

router = APIRouter(tags=["scenario"])

EXAMPLE = ScenarioView(
    id="experiment-power-off",
    shows="Figure 6, right: the primary is switched off; the secondary takes over and delivers.",
    steps=(
        StepView(step=ScenarioStep.SWITCHED_OFF, after_s=604.7, expected_s=604.7, agents=("ATV3",)),
        StepView(step=ScenarioStep.TAKEN_OVER, expected_s=608.2),
    ),
    began_at_s=1_893_456_000.0,
)

REFUSED = problems(
    p403="Another site's page asked",
    p409="No scenario is played, or it has ended",
    p503="The factory does not answer",
)


@router.get(
    "/scenario",
    responses={
        200: described(ScenarioView, "The scenario", EXAMPLE),
        **problems(p409="No scenario is played"),
    },
    response_class=Json,
)
async def get_scenario(play: Provided[ScenarioPlay]) -> Json:
    """Steps that have happened, expected times of the others, and the result."""
    return Json(play.view())


@router.post(
    "/scenario/skip",
    responses={
        200: described(ScenarioView, "The factory is on its way to the next step", EXAMPLE),
        **REFUSED,
    },
    response_class=Json,
)
async def skip_to_next_step(play: Provided[ScenarioPlay]) -> Json:
    """Run the factory as fast as possible until the next step or the end.

    The plant's clock and the panels' wall clock advance together.

    The events are the same as at any speed.
    """
    return Json(await _skip(play, skips=True))


@router.delete(
    "/scenario/skip",
    responses={200: described(ScenarioView, "The factory runs at its speed", EXAMPLE), **REFUSED},
    response_class=Json,
)
async def end_skip(play: Provided[ScenarioPlay]) -> Json:
    """Return to the normal speed before the next step. Without a skip, this changes nothing."""
    return Json(await _skip(play, skips=False))


async def _skip(play: ScenarioPlay, *, skips: bool) -> ScenarioView:
    try:
        return await play.skip(skips=skips)
    except UnavailableError as error:
        raise Problem(
            HTTPStatus.SERVICE_UNAVAILABLE, "no-answer", "The factory does not answer", str(error)
        ) from None
