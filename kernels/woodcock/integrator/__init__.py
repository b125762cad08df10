"""Integrators: the only entry points. One a file: `<name>.cl` for devices, `<name>.py` lays scenes out for it."""
