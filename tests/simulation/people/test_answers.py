"""Answers to commands, and whoever waits for them."""

from __future__ import annotations

import asyncio

from dray.messages import CommandAnswered
from dray_sim.clock.loop import run
from dray_sim.people.answers import Answers


def test_each_answer_reaches_whoever_waits_for_it() -> None:
    async def main() -> None:
        answers = Answers()
        with answers.to("c1") as first, answers.to("c2") as second:
            answers.take(CommandAnswered(command="c2", done=False))
            answers.take(CommandAnswered(command="c1", done=True))
            assert ((await first).done, (await second).done) == (True, False)

    run(main())


def test_of_two_answers_to_one_command_the_first_counts() -> None:
    async def main() -> None:
        answers = Answers()
        with answers.to("c1") as answer:
            answers.take(CommandAnswered(command="c1", done=True))
            answers.take(CommandAnswered(command="c1", done=False))
            assert (await answer).done

    run(main())


def test_an_answer_that_nobody_waits_for_any_more_is_ignored() -> None:
    async def main() -> None:
        answers = Answers()
        with answers.to("c1") as answer:
            await asyncio.wait((answer,), timeout=1.0)
        answers.take(CommandAnswered(command="c1", done=True))
        assert not answer.done()

    run(main())
