# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Warming up compiles what commands load, and nothing is compiled twice."""

from __future__ import annotations

import ast
import json
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest
import warp as wp
from warp._src.context import Module

import stitchmesh as sm
from stitchmesh import first_use as warming
from stitchmesh.child_interpreter import clean_environment, python_command
from stitchmesh.errors import CompilationError, ParameterError
from stitchmesh.first_use import KernelChoice, compile_kernels, every_kernel, kernel_modules
from stitchmesh.quality import PRESETS
from tests.source_files import tree_of

FEW = KernelChoice("cpu", ("stitchmesh.compute.captured", "stitchmesh.yarnrelax.energies.evaluation"),
                   (("float32", False),))  # fmt: skip
SHORT = replace(PRESETS["draft"], max_iterations=60)
LOAD_FEW = """
import sys, json
import warp as wp
from warp._src.context import Module
from stitchmesh.first_use import KernelChoice
compiled, compile = [], Module._compile
def counted(self, *given, **named):
    done = compile(self, *given, **named)
    compiled.append(bool(done))
    return done
Module._compile = counted
choice = KernelChoice(*json.loads(sys.argv[1]))
for kernel, block in choice.kernels():
    kernel.module.load("cpu", block)
print(compiled.count(True), compiled.count(False))
"""
"""Loads the kernels of a choice; prints how many were compiled, and how many were found compiled."""


@pytest.fixture(scope="module")
def planned() -> set[str]:
    """The names under which Warp keeps the kernels that ``warm_up`` compiles for a CPU."""
    return {kernel.module.get_module_identifier(block) for kernel, block in every_kernel("cpu").kernels()}


@pytest.fixture
def loaded(monkeypatch: pytest.MonkeyPatch) -> Iterator[set[str]]:
    """The names under which Warp keeps what is loaded while the test runs."""
    names: set[str] = set()
    load = Module.load

    def recorded(module: Module, device: object, block_dim: int | None = None, *given: object) -> object:
        names.add(module.get_module_identifier(block_dim))
        return load(module, device, block_dim, *given)

    monkeypatch.setattr(Module, "load", recorded)
    yield names


def test_every_kernel_of_every_file_is_compiled() -> None:
    made = {(kernel.func.__module__, kernel.func.__name__) for kernel, _block in every_kernel("cpu").kernels()}
    declared = {
        (name, node.name)
        for name in kernel_modules()
        for node in ast.walk(tree_of(Path(str(import_module(name).__file__))))
        if isinstance(node, ast.FunctionDef) and any(_is_kernel(each) for each in node.decorator_list)
    }
    assert made == declared and len(declared) > 200


def _is_kernel(decorator: ast.expr) -> bool:
    called = decorator.func if isinstance(decorator, ast.Call) else decorator
    return isinstance(called, ast.Name) and called.id == "kernel"


def test_blocks_of_a_gpu_have_the_threads_that_kernels_declare(monkeypatch: pytest.MonkeyPatch) -> None:
    class Gpu:
        is_cuda = True

    monkeypatch.setattr(warming, "device_named", lambda _name: Gpu())
    choice = KernelChoice("cuda:0", ("stitchmesh.yarnrelax.solvers.lbfgs_fused", "stitchmesh.compute.reduction",
                                       "stitchmesh.compute.launch"),
                          (("float32", True),))  # fmt: skip
    blocks: dict[str, set[int]] = {}
    for kernel, block in choice.kernels():
        blocks.setdefault(kernel.func.__name__, set()).add(block)
    assert blocks["fused_iterations"] == {128, 256, 384, 512} and blocks["row_totals"] == {256}
    assert blocks["strand_sums"] == {64}  # of kernels without tiles
    assert "work_through" not in blocks  # the table of launches is a part of the CPU only


def test_what_knit_loads_is_compiled(planned: set[str], loaded: set[str]) -> None:
    sm.knit(sm.read_mesh("hat"), quality=SHORT, stitch_width=2.5)
    assert len(loaded) > 40 and loaded <= planned


def test_what_a_swatch_loads_is_compiled(planned: set[str], loaded: set[str]) -> None:
    sm.swatch("stockinette", quality=SHORT, relax_cell=True, progress=False)
    assert len(loaded) > 60 and loaded <= planned


def test_another_process_finds_what_was_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WARP_CACHE_PATH", str(tmp_path))
    count = len(FEW.kernels())
    reports: list[float] = []
    compile_kernels(FEW, range(count), 2, lambda _stage, done, _note: reports.append(done))
    assert reports == [number / count for number in range(1, count + 1)]
    words = python_command("-c", LOAD_FEW, json.dumps([FEW.device, FEW.modules, FEW.forms]))
    ran = subprocess.run(words, env=clean_environment(), capture_output=True, text=True, check=True)
    assert ran.stdout.split() == ["0", str(count)]


def test_a_second_warm_up_compiles_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path / wp.__version__))
    monkeypatch.setenv("WARP_CACHE_PATH", str(tmp_path))
    few = KernelChoice("cpu", FEW.modules[:1], FEW.forms)
    monkeypatch.setattr(warming, "every_kernel", lambda _device: few)
    first, second = sm.warm_up("cpu", progress=False), sm.warm_up("cpu", progress=False)
    assert (first.compiled, first.kept) == (2, 0) and first.folder == tmp_path / wp.__version__
    assert (second.compiled, second.kept, second.workers) == (0, 2, 0)


def test_a_machine_of_few_cores_compiles_nothing_before_a_relaxation(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    monkeypatch.setattr(warming, "compile_kernels", lambda _choice, missing, *_others: asked.append(len(missing)))
    monkeypatch.setattr(warming, "is_compiled", lambda _kernel, _block, _device: False)
    for workers in (3, 4):
        monkeypatch.setattr(warming, "usual_workers", lambda count=workers: count)
        warming.compile_before_relaxing("cpu", on_lattice=False, progress=lambda *_report: None)
    assert len(asked) == 1 and 40 < asked[0] < 300


def test_what_cannot_be_compiled_is_refused_in_one_line() -> None:
    with pytest.raises(ParameterError, match="workers: got 0; expected at least 1"):
        sm.warm_up("cpu", workers=0)
    with pytest.raises(ParameterError, match="device: got 'cuda:9'"):
        sm.warm_up("cuda:9")
    broken = KernelChoice("no device", FEW.modules, FEW.forms)  # its processes end at once
    with pytest.raises(CompilationError, match=r"ended with status 1; memory may be short, so take fewer workers$"):
        compile_kernels(broken, [0, 1], 1, lambda *_report: None)


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("WARP_CACHE_PATH", str(tmp_path / "file" / "kernels"))
    with pytest.raises(CompilationError):
        compile_kernels(FEW, [0], 1, lambda *_report: None)
