"""Runs per second of a study on a Dask LocalCluster against the threads of the tool, of the same store.

    packaging/wheels native && pip install target/packages/native/camdrive-*.whl[study,dask]
    python benches/study/cluster.py [--runs 100000] [--rounds 3] [--workers 2]

The cluster, with one thread in each worker, is there before the clock starts. Rounds go in turn; the best of each counts.
"""

import argparse
import os
import tempfile
import time
from pathlib import Path

import camdrive
from distributed import Client, LocalCluster

SCENE = Path(__file__).resolve().parents[2] / "examples" / "guide_bar" / "scene.toml"


def seconds(runs, **place):
    vary = {"drive.w": {"from": "1000 rpm", "to": "3000 rpm", "count": runs}}
    with tempfile.TemporaryDirectory() as folder:
        begin = time.perf_counter()
        done = camdrive.study(SCENE, vary, "max |q|", time="0.1668 s", store=Path(folder, "store"), **place)
        took = time.perf_counter() - begin
        assert (done.table["status"] == "ok").sum() == runs
    return took


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, value in [("runs", 100_000), ("rounds", 3), ("workers", 2)]:
        options.add_argument(f"--{name}", type=int, default=value)
    args = options.parse_args()
    with LocalCluster(n_workers=args.workers, threads_per_worker=1, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            client.wait_for_workers(args.workers)
            both = [{"threads": args.workers}, {"client": client}]
            times = [[seconds(args.runs, **place) for place in both] for _ in range(args.rounds)]
    own, dask = (min(column) for column in zip(*times))
    print(f"{args.runs} runs on {os.cpu_count()} processors: {args.workers} threads {own:.2f} s, as many workers {dask:.2f} s")
    print(f"ratio {own / dask:.2f}")


if __name__ == "__main__":
    main()
