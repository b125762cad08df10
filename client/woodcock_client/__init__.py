"""Talking to a Woodcock service from Python.

from woodcock.scene import load
from woodcock_client import Client

with Client("http://127.0.0.1:8000") as client:
    job = client.submit(load(Path("cloud.json")), name="cloud")
    for progress in client.follow(job.id):
        print(progress.samples, progress.relative_rmse)
    client.fetch(job.id, "image.exr", Path("cloud.exr"))
"""

from woodcock_client.batch_models import Axis, Batch, BatchJob
from woodcock_client.client import Artifact, Client
from woodcock_client.connection import ServiceError, Unreachable
from woodcock_client.models import (
    Device,
    FieldError,
    Grid,
    Job,
    JobSummary,
    Links,
    Stability,
    StabilityRow,
    Volume,
    Webhook,
)
from woodcock_client.trial_models import Comparison, DeviceForecast, JobCheck

__all__ = [
    "Artifact",
    "Axis",
    "Batch",
    "BatchJob",
    "Client",
    "Comparison",
    "Device",
    "DeviceForecast",
    "FieldError",
    "Grid",
    "Job",
    "JobCheck",
    "JobSummary",
    "Links",
    "ServiceError",
    "Stability",
    "StabilityRow",
    "Unreachable",
    "Volume",
    "Webhook",
]
