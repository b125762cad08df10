"""Rendering on other machines: a scheduler, worker hosts, and the service that learns of their devices."""
