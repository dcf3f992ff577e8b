"""A sweep on a Dask cluster: python dask_sweep.py preset:studio --vary ball.kd=0..0.7:200

Without a scheduler in `DASK_SCHEDULER`, workers are processes of this machine.
"""

import os

from dask.distributed import Client, LocalCluster, as_completed
from parts import make_part, merge, read_arguments, share_out


def main():
    arguments = read_arguments(__doc__)
    parts = share_out(arguments)
    scheduler = os.environ.get("DASK_SCHEDULER")
    cluster = scheduler or LocalCluster(n_workers=arguments["workers"], threads_per_worker=1, dashboard_address=None)
    with Client(cluster) as client:
        # A part of a worker that dies is given to another one.
        futures = [client.submit(make_part, arguments, part, retries=2, pure=False) for part in parts]
        merge(arguments, parts, [future.result() for future in as_completed(futures)])


if __name__ == "__main__":
    main()
