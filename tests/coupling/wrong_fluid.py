"""A fluid that does wrong what is named on the command line; without physics otherwise."""
import sys
import threading
import time

import numpy as np

wrong = set(sys.argv[1:])
if "stranger" in wrong:
    sys.exit(0)

import heartbus  # noqa: E402: a stranger has none

if "spins" in wrong:

    def spin():
        while True:
            pass

    threading.Thread(target=spin, daemon=True).start()

with heartbus.join("fluid", "wrong_fluid") as bus:
    wall, lifting = bus.partner("mech", "interface"), bus.partner("ale", "cavity")
    points = wall.points.copy()
    if "shifted" in wrong:
        points[7] += 1e-3
    bus.points("interface", points, wall.spacing)
    bus.points("cavity", lifting.points, lifting.spacing)
    motion = bus.input("mesh_motion", "cavity", 3, "m")
    velocity = bus.input("wall_velocity", "interface", 3, "m/s")
    force = bus.input("wall_force", "interface", 3, "N")
    name = "blood_pressure" if "nameless" in wrong else "blood_force"
    blood = bus.output(name, "interface", 3, "mN" if "other_unit" in wrong else "N")
    old, new = np.zeros_like(velocity), np.zeros_like(velocity)  # displacement of the wall
    for order in bus.orders():
        if order.what == heartbus.SOLVE:
            heard = np.nan_to_num(velocity) if "swallows" in wrong else velocity
            new = old + order.size * heard
            if "accumulates" in wrong:
                old = new
            blood[:] = -1e-3 * heard - 1e2 * new
        elif order.what == heartbus.COMMIT:
            old = new
        elif order.what == heartbus.SAVE and "forgets" not in wrong:
            np.save(order.text + "/fluid.npy", old)
        elif order.what == heartbus.LOAD and "forgets" not in wrong:
            old = np.load(order.text + "/fluid.npy")
        elif order.what == heartbus.FINISH and "lingers" in wrong:
            time.sleep(300)
        if order.what == heartbus.SOLVE and "raises" in wrong and order.number == 2:
            raise ValueError("a number is out of range")
