"""A wave of calcium through the wall, in place of electrophysiology."""
import numpy as np

import heartbus

REST, RISE, DECAY = 0.13, 0.025, 0.15  # uM, s, s

with heartbus.join("ep", "wave") as bus:
    velocity = bus.setting("velocity", "m/s", 0.6)
    peak = bus.setting("peak", "uM", 0.8)
    wall = bus.partner("mech", "tissue")
    rank, size = bus.communicator.rank, bus.communicator.size
    mine = wall.points[len(wall.points) * rank // size:len(wall.points) * (rank + 1) // size]
    bus.points("tissue", mine, wall.spacing)
    calcium = bus.output("calcium", "tissue", 1, "uM")
    highest = bus.scalar("highest_calcium", "uM", heartbus.MAX)
    activation = (mine[:, 2] - wall.points[:, 2].min()) / velocity  # from the apex upwards
    for order in bus.orders():
        if order.what in (heartbus.SOLVE, heartbus.LOAD):
            t = np.maximum(order.time - activation, 0)
            calcium[:] = REST + (peak - REST) * (1 - np.exp(-t / RISE)) * np.exp(-t / DECAY)
            highest[0] = calcium.max(initial=0)
