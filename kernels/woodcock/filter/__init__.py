"""Pixel filters: where a pixel's samples lie. One kind a file: `<kind>.h` for devices, `<kind>.py` its oracle.

Samples are placed by the filter along each axis, so that every sample counts once and pixels are independent: Ernst,
Stamminger & Greiner, "Filter Importance Sampling", IEEE Symposium on Interactive Ray Tracing, 2006.
"""
