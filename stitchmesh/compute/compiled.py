# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Compiled kernels in the folder where Warp keeps them between runs.

The name of a compiled kernel there is a hash of the text of the kernel and of its functions, of the types of its
arguments, of the options of the compiler and, on a GPU, of the number of threads of a block. The name also says for
which processor it is. These functions ask Warp for the same names as a launch does, so that a launch finds what they
compile.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import warp as wp

from stitchmesh.errors import CompilationError


def compiled_folder() -> Path:
    """Return the folder of compiled kernels, which the variable ``WARP_CACHE_PATH`` chooses."""
    return Path(wp.config.kernel_cache_dir)


def is_compiled(kernel: wp.Kernel, block: int, device: wp.Device) -> bool:
    """Return whether the folder holds a kernel for blocks of ``block`` threads on a device."""
    module: Any = kernel.module
    folder = compiled_folder() / module.get_module_identifier(block)
    names = module._get_compile_output_name(device, block_dim=block), module._get_meta_name(block_dim=block)
    return all((folder / name).exists() for name in names)


def compile_kernel(kernel: wp.Kernel, block: int, device: wp.Device) -> None:
    """Compile a kernel for blocks of ``block`` threads as a launch does, and do not load it.

    Raises:
        CompilationError: the compiler refuses the kernel, or the folder cannot be written.
    """
    module: Any = kernel.module
    try:
        folder = compiled_folder() / module.get_module_identifier(block)
        name = module._get_compile_output_name(device, block_dim=block)
        module._compile(
            device, folder, name, module._get_compile_arch(device), options=module.resolved_options[block]
        )  # fmt: skip
    except Exception as error:  # whatever a compiler raises concerns this kernel
        place = f"kernel {kernel.func.__name__} of {kernel.func.__module__}"
        raise CompilationError(f"{place}: cannot be compiled for {device} ({error})") from error
