"""Worker hosts of a Woodcock farm as jobs of SLURM by dask-jobqueue, for as long as this program runs (server/farm.md).

    pip install dask-jobqueue
    export WOODCOCK_SCHEDULER=tls://HEAD:8786 WOODCOCK_CERTIFICATES="$HOME/farm"
    python woodcock_jobqueue.py 16

Queue, account, cores, memory, time, prologue and further directives are those of ~/.config/dask/jobqueue.yaml. For
another queue its job takes the place of SLURMJob, its section that of jobqueue.slurm, `$(hostname)` that of
$SLURMD_NODENAME, and its directives those of whole nodes.
"""

import asyncio
import signal
import sys

import dask
from dask_jobqueue.slurm import SLURMJob

#: In place of the shell, so that the script's last line, a worker of Dask's, is never reached.
WORKER = 'exec woodcock worker --name "$SLURMD_NODENAME"'


async def main(hosts: int) -> None:
    stopped = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, stopped.set)
    jobs = [
        SLURMJob(
            name=f"woodcock-{host}",
            job_name="woodcock-worker",
            job_script_prologue=[*dask.config.get("jobqueue.slurm.job-script-prologue"), WORKER],
            job_extra_directives=[*dask.config.get("jobqueue.slurm.job-extra-directives"), "--exclusive", "--mem=0"],
        )
        for host in range(hosts)
    ]
    try:
        for job in jobs:
            await job  # sbatch
        await stopped.wait()
    finally:
        for job in jobs:
            await job.close()  # scancel


if __name__ == "__main__":
    asyncio.run(main(int(sys.argv[1])))
