"""Where the other machines of a farm find this one."""

from __future__ import annotations

from distributed.comm.addressing import get_address_host
from distributed.utils import get_ip


def own_host(scheduler: str) -> str:
    """The address of this machine by which it reaches the scheduler's; as a URL has it."""
    found: str = get_ip(get_address_host(scheduler))  # type: ignore[no-untyped-call]
    return f"[{found}]" if ":" in found else found
