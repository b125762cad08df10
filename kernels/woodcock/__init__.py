"""Woodcock's renderer: scenes of participating media, rendered by OpenCL kernels made for them.

Importing this package costs nothing; the scene needs pydantic only, the renderer the `render` extra.
"""

__version__ = "0.1.0"
