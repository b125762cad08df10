"""Batches: a scene rendered at every point of a sweep."""
