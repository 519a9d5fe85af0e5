"""Compilation by numba, where it is installed, of the loops that long work spends its time in.

Compiled or not, the source is the same, and so are the bits. It has only sums, products, quotients and square roots of
doubles, which are correctly rounded either way, and nothing is contracted or reordered. Numba is imported when the
first long piece of work comes, never before. Compiled code is kept in the user's cache folder, under a name that
changes with the source.

Compiling takes some ten seconds, in which Python would notice no signal. So another process does it, while the work
goes on in Python.

Modules:

- `cache`: the folder of compiled code;
- `compiler`: the decorator of functions called from compiled code, and the process that compiles;
- `work`: a function that runs compiled as soon as that pays, as a loop that advances a state through samples.
"""

from lie_rigid_body.compilation.compiler import kernel, kernel_of
from lie_rigid_body.compilation.work import Loop, Work

__all__ = ["Loop", "Work", "kernel", "kernel_of"]
