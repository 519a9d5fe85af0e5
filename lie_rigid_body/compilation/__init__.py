"""Code that runs compiled where numba is installed and the work is long, and as plain Python or on arrays otherwise.

The source is one and the same, and so are the bits: only sums, products, quotients and square roots of doubles are
used in it, all correctly rounded by either, and nothing is contracted or reordered. Numba is imported by the first long
piece of work, never before. What it compiles is kept in the user's cache folder, under a name that changes with the
source.

The first time, which takes some ten seconds in which Python would notice no signal, another process compiles; the work
goes on in Python until that is done. A table of contents

- `kernels`: functions that compiled code calls;
- `cache`, `compiler`: where compiled code is kept, and what makes it;
- `work`, `loop`: code that runs compiled from when it pays.
"""

from lie_rigid_body.compilation.kernels import kernel, kernel_of
from lie_rigid_body.compilation.loop import Loop
from lie_rigid_body.compilation.work import Work

__all__ = ["Loop", "Work", "kernel", "kernel_of"]
