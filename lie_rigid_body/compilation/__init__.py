"""Compilation by numba, where it is installed, of the loops over steps that long work spends its time in.

Compiled or not, the source is the same, and so are the bits. It has only sums, products, quotients and square roots of
doubles, which are correctly rounded either way, and nothing is contracted or reordered. Numba is imported when the
first long piece of work comes, never before. It compiles once, in some seconds, and keeps the code in its cache.

Modules:

- `compiler`: the decorator of functions called from compiled code, the folder of its cache, and the compiler;
- `step_loop`: a loop that advances a state through samples, compiled as soon as that pays.
"""

from lie_rigid_body.compilation.compiler import kernel
from lie_rigid_body.compilation.step_loop import StepLoop

__all__ = ["StepLoop", "kernel"]
