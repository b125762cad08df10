"""The states of a job, and which may follow which: nothing else decides that."""

from __future__ import annotations

from enum import StrEnum


class State(StrEnum):
    QUEUED = "queued"  # waits for a dispatcher, perhaps not for the first time
    RUNNING = "running"  # a dispatcher holds its lease
    CANCELLING = "cancelling"  # is to stop; its holder has not let go of it yet
    SUCCEEDED = "succeeded"  # picture and report are there
    FAILED = "failed"  # `error` says why
    CANCELLED = "cancelled"  # stopped as asked; there is no picture, perhaps a preview

    @property
    def final(self) -> bool:
        """Nothing follows."""
        return not _AFTER[self]

    @property
    def before(self) -> list[State]:
        """From which a job may come to be in this one."""
        return [state for state in State if self in _AFTER[state]]


_AFTER: dict[State, frozenset[State]] = {
    State.QUEUED: frozenset({State.RUNNING, State.CANCELLED}),
    # Running again: its holder let the lease run out, and another one claims it.
    State.RUNNING: frozenset({State.RUNNING, State.QUEUED, State.CANCELLING, State.SUCCEEDED, State.FAILED}),
    State.CANCELLING: frozenset({State.CANCELLED}),
    State.SUCCEEDED: frozenset(),
    State.FAILED: frozenset(),
    State.CANCELLED: frozenset(),
}

#: Ends, and all others: a database finds rows by what their state is, not by what it is not.
FINAL = tuple(state for state in State if state.final)
UNENDED = tuple(state for state in State if not state.final)
