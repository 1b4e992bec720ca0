"""The participants of benchmark_bus in Python:
   p="python3 tests/benchmarks/bus/echo.py"; mpirun -n 1 build/release/bin/benchmark_bus : -n 2 $p a : -n 2 $p b
with PYTHONPATH=build/release/share/heartbus/python."""
import sys
import time

import numpy as np

import heartbus

is_a = sys.argv[1] == "a"
with heartbus.join(sys.argv[1], "benchmark_bus") as bus:
    rank = bus.communicator.rank
    for size in (1000, 10000, 100000):
        split = size // 2 if is_a else size // 3
        i = np.arange(0, split) if rank == 0 else np.arange(split, size)
        p = i if is_a else size - 1 - i
        points = 1e-3 * np.stack([p % 50, p // 50 % 50, p // 2500], axis=1)
        bus.points(f"points_{size}", points, 1e-3)
        bus.output(f"field_{size}", f"points_{size}", 3, "m")[:] = points
        bus.input(f"field_{size}", f"points_{size}", 3, "m")
    bus.task("start")
    bus.task("stop")
    seconds = bus.scalar("seconds", "s")
    start = 0
    for order in bus.orders():
        if order.what == heartbus.TASK:
            now = time.perf_counter()
            seconds[0] = now - start
            start = now if order.text == "start" else start
