# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Computations with shared work have the same results alone and together, errors included."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextvars import ContextVar
from functools import partial
from typing import Any

import pytest

from stitchmesh.compute.shared_work import Call, Worker, compute_each, done_by, shared
from stitchmesh.compute.work_together import Begun, done_together
from stitchmesh.errors import ParameterError, StitchMeshError

SIZE: ContextVar[int] = ContextVar("size")


@shared
def half(number: int) -> int:
    if number % 2:
        raise ParameterError(f"half: got {number}")
    return number // 2


@shared
def double(number: int) -> int:
    return 2 * number


def steps_to_one(number: int) -> int:
    """Halve a number until it is 1; one that is odd is doubled once and halved again, as an error says."""
    count = 0
    while number > 1:
        try:
            number = half(number)
        except ParameterError:
            number = double(number) // number - 1
        count += 1
    return count


def largest_of(numbers: Sequence[int]) -> int:
    """The most steps of some numbers, each counted by itself."""
    found = compute_each([partial(steps_to_one, number) for number in numbers])
    return max((count for count in found if isinstance(count, int)), default=0)


def results(calls: Sequence[Call]) -> list[Any]:
    found: list[Any] = []
    for call in calls:
        try:
            found.append(call.do())
        except StitchMeshError as error:
            found.append(error)
    return found


def test_together_has_the_results_of_alone():
    numbers = [[8, 64], [], [1], [12, 5]]
    done: list[list[int]] = []

    def halves(calls: Sequence[Call]) -> list[Any]:
        done.append([call.arguments["number"] for call in calls])
        return results(calls)

    found = done_together([partial(largest_of, some) for some in numbers], {half: halves})
    assert found == [largest_of(some) for some in numbers] == [6, 0, 0, 3]
    assert done[0] == [8, 64, 12, 5], "the work of one kind is done at once"
    assert len(done) == 6, "as often as the longest computation needs"


def test_short_work_is_done_first():
    order: list[str] = []

    def way(name: str) -> Callable[[Sequence[Call]], list[Any]]:
        def do(calls: Sequence[Call]) -> list[Any]:
            order.append(f"{name} {len(calls)}")
            return results(calls)

        return do

    def one(times: int) -> int:
        number = 1
        for _ in range(times):
            number = double(number)
        return half(number)

    ways = {double: way("double"), half: way("half")}
    assert done_together([partial(one, 1), partial(one, 3)], ways) == [1, 4]
    assert order == ["double 2", "double 1", "double 1", "half 2"]


def test_an_error_ends_its_computation_only():
    done: list[int] = []
    made = done_together([partial(half, 3), partial(steps_to_one, 4)], {half: results}, done.append)
    assert isinstance(made[0], ParameterError) and made[1] == 2
    assert done == [1, 2]
    with pytest.raises(ParameterError, match="half: got 3"):
        half(3)


@pytest.mark.parametrize("ended_by", [KeyboardInterrupt, ValueError])
@pytest.mark.parametrize("place", ["computation", "part", "work", "report"])
def test_any_other_exception_ends_all_computations(place: str, ended_by: type[BaseException]) -> None:
    """No thread is left, those that wait for others included."""
    before = threading.active_count()

    def fail(where: str) -> None:
        if where == place:
            raise ended_by

    def part(number: int) -> int:
        fail("part" if number == 4 else "")
        return steps_to_one(number)

    def computation(number: int) -> int:
        count = len(compute_each([partial(part, number), partial(part, 16)]))
        fail("computation")
        return count

    def halves(calls: Sequence[Call]) -> list[Any]:
        fail("work")
        return results(calls)

    computations = [partial(computation, number) for number in (8, 4, 2)]
    with pytest.raises(ended_by):
        done_together(computations, {half: halves}, lambda _done: fail("report"))
    assert threading.active_count() == before


def test_work_that_has_no_way_is_done_where_it_is_called():
    made = done_together([partial(steps_to_one, 16), partial(half, 3)], {})
    assert made[0] == 4 and isinstance(made[1], ParameterError)


def test_computations_see_the_block_in_which_they_begin():
    """Limits on the time are such values."""
    token = SIZE.set(3)
    try:
        assert done_together([lambda: sum(map(int, compute_each([SIZE.get, SIZE.get])))], {}) == [6]
    finally:
        SIZE.reset(token)


def test_work_that_has_begun_goes_on_with_the_next() -> None:
    """Of each set of numbers halved together the last is put off, with the number of times in its state."""
    done = list[list[tuple[int, int]]]()

    def all_but_the_last(calls: Sequence[Call]) -> list[Any]:
        states = [call.state if isinstance(call, Begun) else 0 for call in calls]
        done.append([(call.arguments["number"], state) for call, state in zip(calls, states, strict=True)])
        if len(calls) == 1:
            return results(calls)
        last = calls[-1]
        return [*results(calls[:-1]), Begun(last.function, last.arguments, states[-1] + 1)]

    computations = [partial(steps_to_one, number) for number in (4, 2, 8)]
    assert done_together(computations, {half: all_but_the_last}) == [2, 1, 3]
    assert done == [[(4, 0), (2, 0), (8, 0)], [(2, 0), (8, 1)], [(8, 2)], [(4, 0)], [(2, 0)]]


def test_a_worker_gets_the_calls_of_its_block():
    class Recorder(Worker):
        def __init__(self) -> None:
            self.calls: list[Any] = []

        def do(self, call: Call) -> Any:
            self.calls.append(dict(call.arguments))
            return call.do()

    recorder = Recorder()
    with done_by(recorder):
        assert largest_of([2, 4]) == 2
    half(8)
    assert recorder.calls == [{"number": 2}, {"number": 4}, {"number": 2}]
