# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Variants of kernels: all concrete kernels that the text of the package stands for, found without a launch.

The text of a kernel serves both precisions, and yarns with and without a lattice. A launch makes a concrete kernel from
the types of its arguments. To compile kernels before they are launched, this module makes the same concrete kernels
from the names of types in the text: ``Vec3`` stands for a vector of three numbers of the precision. The module that
gives a type its name also says which types the name stands for (``named_type``).

A kernel that is made by a function is the result of calls with different arguments. Its function says with which
arguments the program calls it (``kernel_factory``).
"""

from __future__ import annotations

import ast
import builtins
import functools
import inspect
import itertools
import textwrap
from collections import ChainMap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any, TypeVar

import warp as wp

from stitchmesh.compute.kernel import concrete_kernel

Factory = TypeVar("Factory", bound=Callable[..., wp.Kernel])


@dataclass(frozen=True)
class KernelForm:
    """What decides the types of the arguments of all kernels of a run."""

    scalar: Any
    """Warp's floating-point type."""
    on_lattice: bool
    """Whether the yarns lie on a lattice."""
    on_gpu: bool
    """Whether the kernels run on a GPU."""
    quadratures: tuple[int, ...]
    """Usual numbers of Gauss points in a segment of a relaxation in this precision."""
    measured_quadratures: tuple[int, ...]
    """Further numbers of Gauss points for the measuring of relaxed yarns in this precision."""

    @property
    def relaxing(self) -> tuple[bool, ...]:
        """Whether cells relax: both, or never without a lattice."""
        return (False, True) if self.on_lattice else (False,)


_TYPES: dict[str, Callable[[KernelForm], Sequence[Any]]] = {}
"""The types that each name stands for in a form."""


def named_type(name: str, types_of: Callable[[KernelForm], Sequence[Any]]) -> None:
    """Say which types a name in the text of a kernel stands for in a form; none if no such kernel runs in it."""
    _TYPES[name] = types_of


def kernel_factory(arguments: Callable[[KernelForm], Iterable[tuple[Any, ...]]]) -> Callable[[Factory], Factory]:
    """Declare a function that makes a kernel: calls with the same arguments return the same kernel.

    Args:
        arguments: the arguments with which the program calls the function in a form.
    """

    def declare(make: Factory) -> Factory:
        kept: Any = functools.cache(make)
        kept.usual_arguments = arguments
        return kept

    return declare


def kernels_of_module(module: ModuleType, form: KernelForm) -> Iterator[wp.Kernel]:
    """Yield all concrete kernels of a Python module in a form, in the order of its text."""
    for value in list(vars(module).values()):
        if getattr(value, "__module__", module.__name__) != module.__name__:
            continue
        if hasattr(value, "usual_arguments"):
            for arguments in value.usual_arguments(form):
                yield from _concrete_kernels(value(*arguments), form)
        elif isinstance(value, wp.Kernel) and value.func.__module__ == module.__name__:
            yield from _concrete_kernels(value, form)


def _concrete_kernels(kernel: wp.Kernel, form: KernelForm) -> Iterator[wp.Kernel]:
    """Yield the kernel for each combination of the types that the names in its text stand for."""
    if not kernel.is_generic:
        yield kernel
        return
    annotations = _annotations(kernel.func)
    names = sorted({name for annotation in annotations for name in _names(annotation) if name in _TYPES})
    places = kernel.func.__globals__
    for types in itertools.product(*(_TYPES[name](form) for name in names)):
        meaning = ChainMap(dict(zip(names, types, strict=True)), places, vars(builtins))
        yield concrete_kernel(kernel, [_type_of(annotation, meaning) for annotation in annotations])


def _annotations(function: Callable[..., Any]) -> list[ast.expr]:
    """Return the annotations of the arguments of a function as they stand in its text."""
    [definition] = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    assert isinstance(definition, ast.FunctionDef)
    return [each.annotation for each in definition.args.args if each.annotation is not None]


def _type_of(annotation: ast.expr, meaning: Mapping[str, Any]) -> Any:
    """The type that an annotation such as ``Scalar``, ``wp.array[Vec3]`` or ``wp.array(dtype=Vec3)`` names.

    Raises:
        TypeError: the annotation has another form.
    """
    match annotation:
        case ast.Name(name):
            return meaning[name]
        case ast.Constant(value):
            return value
        case ast.Attribute(owner, name):
            return getattr(_type_of(owner, meaning), name)
        case ast.Subscript(generic, item):
            return _type_of(generic, meaning)[_type_of(item, meaning)]
        case ast.Call(called, arguments, keywords):
            given = {each.arg: _type_of(each.value, meaning) for each in keywords if each.arg is not None}
            return _type_of(called, meaning)(*(_type_of(each, meaning) for each in arguments), **given)
    raise TypeError(f"annotation of a kernel: got {ast.unparse(annotation)}; expected a name, or a type of arrays")


def _names(annotation: ast.expr) -> list[str]:
    return [node.id for node in ast.walk(annotation) if isinstance(node, ast.Name)]
