"""Volumes: uploaded files."""
