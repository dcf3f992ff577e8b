"""A sweep on a Ray cluster: python ray_sweep.py preset:studio --vary ball.kd=0..0.7:200

Without a cluster in `RAY_ADDRESS`, workers are processes of this machine.
"""

import os

import ray
from parts import make_part, merge, read_arguments, share_out


def main():
    arguments = read_arguments(__doc__)
    parts = share_out(arguments)
    local = {} if "RAY_ADDRESS" in os.environ else {"num_cpus": arguments["workers"]}
    ray.init(log_to_driver=False, include_dashboard=False, **local)
    # A part of a worker that dies is given to another one.
    task = ray.remote(max_retries=2)(make_part)
    merge(arguments, parts, ray.get([task.remote(arguments, part) for part in parts]))
    ray.shutdown()


if __name__ == "__main__":
    main()
