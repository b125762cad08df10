"""C expressions over numpy arrays: the probe that unit-tests device code at any lane width.

evaluate(context, ["sqrt(a)", "unit(w)"], {"a": floats, "w": words}, lanes=8, files=["core/rng.h"])
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from woodcock.device import Context
from woodcock.program import OPTIONS, flatten

_TYPES = {np.dtype(np.float32): ("float", "real"), np.dtype(np.uint32): ("uint", "word")}


def evaluate(
    context: Context,
    expressions: Sequence[str],
    inputs: Mapping[str, NDArray[np.generic]],
    *,
    lanes: int,
    files: Sequence[str] = (),
    setup: str = "",
    body: str = "",
) -> NDArray[np.float32]:
    """The expressions' values, float32 (expressions, n), for inputs of float32 or uint32 (n,), each by its name.

    files: of this package, inlined first; setup: text at file scope; body: statements before the expression.
    """
    count = len(next(iter(inputs.values())))
    padded = -(-count // lanes) * lanes
    arrays = {
        name: np.pad(np.ascontiguousarray(array), (0, padded - count), mode="edge") for name, array in inputs.items()
    }
    parameters = "".join(f"__global const {_TYPES[array.dtype][0]} *{name}_, " for name, array in arrays.items())
    loads = "".join(
        f"    {_TYPES[array.dtype][1]} {name} = lanes_load({name}_ + i);\n" for name, array in arrays.items()
    )
    stores = "".join(
        f"    lanes_store({expression}, result_ + {index * padded} + i);\n"
        for index, expression in enumerate(expressions)
    )
    text = f"""{setup}
__kernel void evaluate({parameters}__global float *result_) {{
    const size_t i = get_global_id(0) * LANES;
{loads}{body}
{stores}}}
"""
    kernel = context.build(flatten([f"core/lanes_{lanes}.h", *files, text]), OPTIONS, "evaluate")
    result = np.zeros((len(expressions), padded), np.float32)
    out = context.output(result)
    kernel(context.queue, (padded // lanes,), None, *map(context.upload, arrays.values()), out)
    context.download(result, out)
    return result[:, :count]
