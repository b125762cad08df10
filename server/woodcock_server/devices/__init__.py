"""Devices: what can render."""
