"""What the matrix holds the service to."""

from __future__ import annotations

from dataclasses import dataclass, field

from . import strikes
from .rig import LEASE
from .stages import STAGES, WITH_CHECKPOINT


@dataclass(frozen=True)
class Fault:
    """rig: of RIGS, the kind that it needs; device: that the job asks for; lasts: seconds that it goes on after the
    stage was let go of; left_out: stage or database -> why the two do not go together."""

    name: str
    strike: strikes.Strike
    rig: str = "plain"
    device: str = "cpu0"
    lasts: float = 0.0
    left_out: dict[str, str] = field(default_factory=dict)


NO_FILM = dict.fromkeys(
    (stage for stage in STAGES if stage not in WITH_CHECKPOINT), "no checkpoint is there, or none is read any more"
)
GONE_BY = {"ended": "the lease is renewed no more", "claim": "the lease is not renewed yet"}
SHARED = {"sqlite": "what machines share is tried with PostgreSQL"}
SHORTER = dict.fromkeys(STAGES.keys() - {"mid-range", "exr"}, "a shorter time is tried there")
#: Of a farm's hosts.
NODE1 = "cpu0@node1"

FAULTS = [
    Fault("service killed", strikes.service_killed),
    Fault("dispatcher cancelled", strikes.dispatcher_cancelled),
    Fault("dispatcher raises", strikes.dispatcher_raises, lasts=LEASE, left_out=GONE_BY),
    Fault("worker killed", strikes.worker_killed),
    Fault("worker killed, two devices", strikes.worker_killed, device="any"),
    Fault("connections cut", strikes.connections_cut, left_out={"sqlite": "a file has no connections"}),
    Fault("database away", strikes.database_away, lasts=2.5 * LEASE),
    Fault("disk full", strikes.disk_full, "small disk", lasts=2.5 * LEASE),
    Fault("disk read-only", strikes.disk_read_only, "small disk", lasts=2.5 * LEASE),
    Fault("clock +1 day", strikes.clock_jumped(1), "clock"),
    Fault("clock -1 day", strikes.clock_jumped(-1), "clock"),
    Fault("clock -1 day, worker killed", strikes.clock_back_and_worker_killed, "clock"),
    Fault("stopped for two leases", strikes.stopped, "pair", lasts=2 * LEASE),
    Fault("checkpoint truncated", strikes.corrupted(strikes.truncate), left_out=NO_FILM),
    Fault("checkpoint's bits flipped", strikes.corrupted(strikes.flip), left_out=NO_FILM),
    Fault("object store killed", strikes.store_killed, "bucket", lasts=6, left_out=SHARED),
    Fault("object store killed for a minute", strikes.store_killed, "bucket", lasts=60, left_out=SHARED | SHORTER),
    # Longer than until a request is given up.
    Fault("object store hangs", strikes.store_hangs, "bucket", lasts=18, left_out=SHARED),
    Fault("object store, service killed", strikes.service_killed, "bucket", left_out=SHARED),
    Fault("farm: dispatcher killed", strikes.dispatcher_killed, "farm", NODE1, left_out=SHARED),
    Fault("farm: dispatcher stopped for two leases", strikes.stopped, "farm", NODE1, 2 * LEASE, SHARED),
    Fault("farm: scheduler killed", strikes.scheduler_killed, "farm", NODE1, 4, SHARED),
    Fault("farm: host cut off for a moment", strikes.cut_off_for_a_moment, "farm", NODE1, 3, SHARED),
    Fault("farm: host cut off", strikes.cut_off_until_the_end, "farm", "any", left_out=SHARED),
    Fault("farm: the only host cut off", strikes.cut_off, "farm", NODE1, left_out=SHARED),
]
