"""C expressions over numpy arrays: the probe that unit-tests device code at any lane width.

evaluate(context, ["sqrt(a)", "unit(w)"], {"a": floats, "w": words}, lanes=8, parts=["core/rng.h"])
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from woodcock.device import Context
from woodcock.program import OPTIONS, flatten

_LANES = {"f4": "real", "u4": "word"}
_SCALARS = {"f4": "float", "u4": "uint", "u2": "ushort", "u1": "uchar"}


def evaluate(
    context: Context,
    expressions: Sequence[str],
    inputs: Mapping[str, NDArray[np.generic]],
    *,
    lanes: int,
    parts: Sequence[str] = (),
    buffers: Mapping[str, NDArray[np.generic]] | None = None,
    body: str = "",
) -> NDArray[np.float32]:
    """The expressions' values, float32 (expressions, n), for inputs of float32 or uint32 (n,), each by its name.

    parts: what `flatten` puts before; buffers: arrays that the expressions see whole; body: statements before them.
    """
    count = len(next(iter(inputs.values())))
    padded = -(-count // lanes) * lanes
    arrays = {f"{name}_": np.pad(array, (0, padded - count), mode="edge") for name, array in inputs.items()}
    arrays |= buffers or {}
    parameters = "".join(f"__global const {_SCALARS[array.dtype.str[1:]]} *{name}, " for name, array in arrays.items())
    loads = "".join(
        f"    {_LANES[array.dtype.str[1:]]} {name} = lanes_load({name}_ + i);\n" for name, array in inputs.items()
    )
    stores = "".join(
        f"    lanes_store({expression}, result_ + {index * padded} + i);\n"
        for index, expression in enumerate(expressions)
    )
    text = f"""
__kernel void evaluate({parameters}__global float *result_) {{
    const size_t i = get_global_id(0) * LANES;
{loads}{body}
{stores}}}
"""
    kernel = context.build(flatten([f"core/lanes_{lanes}.h", *parts, text]), OPTIONS, "evaluate")
    result = np.zeros((len(expressions), padded), np.float32)
    out = context.output(result)
    uploads = [context.upload(np.ascontiguousarray(array)) for array in arrays.values()]
    kernel(context.queue, (padded // lanes,), None, *uploads, out)
    context.download(result, out)
    return result[:, :count]
