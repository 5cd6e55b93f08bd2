# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Computations that ask for work have the same results alone and together, errors included."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from stitchmesh.compute.asking import Ask, Asking, Begun, Several, answer_alone, answered_alone, ask
from stitchmesh.compute.asking_together import answer_together
from stitchmesh.errors import ParameterError, StitchMeshError


def half(number: int) -> int:
    if number % 2:
        raise ParameterError(f"half: got {number}")
    return number // 2


def double(number: int) -> int:
    return 2 * number


def halves_together(calls: list[list[int]], asks: Sequence[Ask]) -> list[Any]:
    calls.append([asked.positional[0] for asked in asks])
    found: list[Any] = []
    for asked in asks:
        try:
            found.append(asked.answer())
        except StitchMeshError as error:
            found.append(error)
    return found


@answered_alone
def steps_to_one(number: int) -> Asking[int]:
    """Halve a number until it is 1; one that is odd is doubled once and halved again, as an error says."""
    count = 0
    while number > 1:
        try:
            number = yield ask(half, number)
        except ParameterError:
            number = (yield ask(double, number)) // number - 1
        count += 1
    return count


def largest_of(numbers: Sequence[int]) -> Asking[int]:
    """The most steps of some numbers, each counted by itself."""
    found = yield Several([steps_to_one.asking(number) for number in numbers])
    return max(found, default=0)


def refused() -> Asking[int]:
    found: int = yield ask(half, 3)
    return found


def test_together_has_the_results_of_alone():
    numbers = [[8, 64], [], [1], [12, 5]]
    calls: list[list[int]] = []
    found = answer_together(
        [largest_of(some) for some in numbers], {half: lambda asks: halves_together(calls, asks)}
    )  # fmt: skip
    assert found == [answer_alone(largest_of(some)) for some in numbers] == [6, 0, 0, 3]
    assert calls[0] == [8, 64, 12, 5], "the work of one kind is done at once"
    assert len(calls) == 6, "as often as the longest computation asks"


def test_short_work_is_done_first():
    order: list[str] = []

    def way(name: str) -> Any:
        def answer(asks: Sequence[Ask]) -> list[Any]:
            order.append(f"{name} {len(asks)}")
            return [asked.answer() for asked in asks]

        return answer

    def one(times: int) -> Asking[int]:
        number = 1
        for _ in range(times):
            number = yield ask(double, number)
        found: int = yield ask(half, number)
        return found

    assert answer_together([one(1), one(3)], {double: way("double"), half: way("half")}) == [1, 4]
    assert order == ["double 2", "double 1", "double 1", "half 2"]


def test_an_error_ends_its_computation_only():
    done: list[int] = []
    made = answer_together([refused(), steps_to_one.asking(4)], {half: lambda asks: halves_together([], asks)},
                           done.append)  # fmt: skip
    assert isinstance(made[0], ParameterError) and made[1] == 2
    assert done == [1, 2]
    with pytest.raises(ParameterError, match="half: got 3"):
        answer_alone(refused())


def test_work_that_has_no_way_is_done_alone():
    assert answer_together([steps_to_one.asking(16), refused()], {})[0] == 4


def test_work_that_has_begun_goes_on_with_the_next() -> None:
    """Of each set of numbers halved together the last is put off, with the number of times in its state."""
    calls = list[list[tuple[int, int]]]()

    def all_but_the_last(asks: Sequence[Ask]) -> list[Any]:
        states = [asked.state if isinstance(asked, Begun) else 0 for asked in asks]
        calls.append([(asked.positional[0], state) for asked, state in zip(asks, states, strict=True)])
        done = [asked.answer() for asked in (asks[:-1] if len(asks) > 1 else asks)]
        last = asks[-1]
        return done if len(asks) == 1 else [*done, Begun(last.function, last.positional, last.named, states[-1] + 1)]

    assert answer_together([steps_to_one.asking(number) for number in (4, 2, 8)], {half: all_but_the_last}) == [2, 1, 3]
    assert calls == [[(4, 0), (2, 0), (8, 0)], [(2, 0), (8, 1)], [(8, 2)], [(4, 0)], [(2, 0)]]
