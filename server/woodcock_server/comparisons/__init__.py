"""Comparisons: a scene rendered in variants for equal time, and which of them wins."""
