"""Volumes, meshes and pictures: uploaded files, whatever a scene may name."""
