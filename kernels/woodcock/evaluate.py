"""C expressions over numpy arrays: the probe that unit-tests device code at any lane width.

evaluate(context, ["sqrt(a)", "unit(w)"], {"a": floats, "w": words}, lanes=8, parts=["core/rng.h"])
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from woodcock.device import Context
from woodcock.program import OPTIONS, flatten

_LANES = {"f4": "real", "u4": "word", "f8": "real", "u8": "word"}
_SCALARS = {"f8": "double", "u8": "ulong", "f4": "float", "i4": "int", "u4": "uint", "u2": "ushort", "u1": "uchar"}


def evaluate(
    context: Context,
    expressions: Sequence[str],
    inputs: Mapping[str, NDArray[np.generic]],
    *,
    lanes: int,
    parts: Sequence[str] = (),
    buffers: Mapping[str, NDArray[np.generic]] | None = None,
    body: str = "",
) -> NDArray[np.floating]:
    """The expressions' values, float32 (expressions, n), for inputs of float32 or uint32 (n,), each by its name.

    Inputs of float64 or uint64 ask for lanes of doubles, and so are the values.

    parts: what `flatten` puts before; buffers: arrays that the expressions see whole; body: statements before them.
    """
    count = len(next(iter(inputs.values())))
    precise = any(array.dtype.itemsize == 8 for array in inputs.values())
    padded = -(-count // lanes) * lanes
    arrays = {f"{name}_": np.pad(array, (0, padded - count), mode="edge") for name, array in inputs.items()}
    arrays |= buffers or {}
    parameters = "".join(f"__global const {_SCALARS[array.dtype.str[1:]]} *{name}, " for name, array in arrays.items())
    load = "*({} + i)" if lanes == 1 else f"vload{lanes}(0, {{}} + i)"
    loads = "".join(
        f"    {_LANES[array.dtype.str[1:]]} {name} = {load.format(f'{name}_')};\n" for name, array in inputs.items()
    )
    stores = "".join(
        f"    lanes_store({expression}, result_ + {index * padded} + i);\n"
        for index, expression in enumerate(expressions)
    )
    text = f"""
__kernel void evaluate({parameters}__global number *result_) {{
    const size_t i = get_global_id(0) * LANES;
{loads}{body}
{stores}}}
"""
    header = f"core/lanes_{lanes}_double.h" if precise else f"core/lanes_{lanes}.h"
    kernel = context.build(flatten([header, *parts, text]), OPTIONS, "evaluate")
    result = np.zeros((len(expressions), padded), np.float64 if precise else np.float32)
    out = context.output(result)
    uploads = [context.upload(a if hasattr(a, "pieces") else np.ascontiguousarray(a)) for a in arrays.values()]
    kernel(context.queue, (padded // lanes,), None, *uploads, out)
    context.download(result, out)
    return result[:, :count]
