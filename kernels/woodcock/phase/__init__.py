"""Phase functions: how scattered light spreads. One kind a file: `<kind>.h` for devices, `<kind>.py` its oracle."""
