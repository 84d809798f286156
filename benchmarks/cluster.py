"""A sweep on a Dask cluster beside threads, and Dask's scheduler with many workers that only wait.

    python benchmarks/cluster.py [--robots 128] [--cycles 15] [--repeat 3]
    python benchmarks/cluster.py --workers 200 --shards 20000 --seconds 2

The first: two workers of one thread each on this machine, begun before the clock, beside two
threads; everything from the experiments to the dataset counts; measured in turn, medians. The
second: shards are given to the scheduler as a sweep gives them, and its workers, all in this
process, sleep instead of simulating: what is more than shards x seconds / workers is scheduling.
"""

from __future__ import annotations

import argparse
import asyncio
import time
from itertools import islice
from statistics import median

import numpy as np

import resonance_mj as rmj
from resonance_mj.sweeps import cluster


def beside_threads(robots: int, cycles: int, repeat: int) -> None:
    """Print seconds with two threads and with two workers."""
    from distributed import LocalCluster

    base = rmj.load("two-link-transfer")
    one = base.model_dump(exclude_unset=True)["motion"][0] | {"duration": float(cycles)}
    base, keys = base.replace({"motion": [one]}), {"law.beta": np.linspace(2, 10, robots).tolist()}
    with LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0", silence_logs=50) as scheduler:
        address = scheduler.scheduler_address
        workers = [cluster.begin_worker(address) for _ in range(2)]
        rmj.sweep(base, keys, dask=address, progress=False)  # imports and compiles
        took: dict[str, list[float]] = {"threads": [], "workers": []}
        for _ in range(repeat):
            for name, how in (("threads", {"threads": 2}), ("workers", {"dask": address})):
                began = time.perf_counter()
                rmj.sweep(base, keys, progress=False, **how)
                took[name].append(time.perf_counter() - began)
        for each in workers:
            cluster.end_worker(each)
    threads, spread = (median(took[name]) for name in ("threads", "workers"))
    print("| robots | 2 threads [s] | 2 workers [s] | ratio |\n|---|---|---|---|")
    print(f"| {robots} | {threads:.2f} | {spread:.2f} | {spread / threads:.2f} |")


async def _wait(seconds: float, shard: int) -> int:
    await asyncio.sleep(seconds)
    return shard


async def scheduling(workers: int, shards: int, seconds: float) -> None:
    """Print how long shards take that only wait."""
    from distributed import Client, Scheduler, Worker, as_completed

    async with Scheduler(dashboard_address=None, port=0, host="127.0.0.1") as scheduler:
        pool = [
            Worker(scheduler.address, nthreads=1, name=i, dashboard_address=None, memory_limit=0)
            for i in range(workers)
        ]
        await asyncio.gather(*pool)
        async with Client(scheduler.address, asynchronous=True) as client:
            names = iter(range(shards))

            def submitted(most: int) -> list[object]:
                return [
                    client.submit(_wait, seconds, i, key=f"shard-{i}") for i in islice(names, most)
                ]

            began, done = time.perf_counter(), 0
            finished = as_completed(submitted(cluster.AHEAD * workers))
            async for future in finished:
                await future
                done += 1
                finished.update(submitted(1))
            took = time.perf_counter() - began
        await asyncio.gather(*(each.close() for each in pool))
    ideal = shards * seconds / workers
    print("| workers | shards | of [s] | took [s] | at least [s] | more | shards a second |")
    print("|---|---|---|---|---|---|---|")
    print(
        f"| {workers} | {done} | {seconds:g} | {took:.1f} | {ideal:.1f} | {took / ideal - 1:.1%} "
        f"| {done / took:.0f} |"
    )


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=128)
    parser.add_argument("--cycles", type=int, default=15)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--workers", type=int, default=0)
    parser.add_argument("--shards", type=int, default=20_000)
    parser.add_argument("--seconds", type=float, default=2.0)
    options = parser.parse_args()
    if options.workers:
        asyncio.run(scheduling(options.workers, options.shards, options.seconds))
    else:
        beside_threads(options.robots, options.cycles, options.repeat)


if __name__ == "__main__":
    main()
