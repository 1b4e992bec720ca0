"""The wall of the ventricle in DOLFINx, in place of mech_solver, in the loosely coupled schemes or under a circulation.

    rho (d - 2 d^n + d^{n-1}) / dt^2 - div P = 0,   P = dW/dF + T O(SL) / lambda F H
    P n = L on `interface`,   d = 0 on `base`
    P n = -(n x n) (K_perp d + C_perp v) - (I - n x n) (K_par d + C_par v) on `epicardium`

with Guccione's W, the tension T = T_max s_1 of nodal states s, fibres H = (1 - nu) f x f + nu n x n of stretch
lambda^2 = H : C, and the overlap O of short sarcomeres. The blood is given, with nodal forces on the wall,

    v* = (d^n - d^{n-1}) / dt,  W* = L^n + int (P_act(d^n, s^{n+1}) - P_act(d^n, s^n)) : grad phi,

then, for each further iteration, v* = (d - d^n) / dt, W* = L."""
import cavity
import numpy as np
import rdq18
import ventricle
from wall import SL0, T_MAX, Wall

import heartbus


def contract(bus):
    body = ventricle.Body(bus.communicator, bus.text("mesh", "ventricle.h5"), "solid")
    wall, n = Wall(body), body.n_owned
    interface = body.nodes("interface")
    interface = interface[interface < n]
    bus.points("tissue", body.x[:n], body.spacing)
    bus.points("interface", body.x[interface], body.spacing)
    calcium = bus.input("calcium", "tissue", 1, "uM")
    blood_force = bus.input("blood_force", "interface", 3, "N")
    held = bus.output("held", "interface", 3, "1")
    displacement = bus.output("displacement", "interface", 3, "m")
    wall_velocity = bus.output("wall_velocity", "interface", 3, "m/s")
    wall_force = bus.output("wall_force", "interface", 3, "N")
    bus.task("inflate")
    filling = cavity.Cavity(bus, wall) if bus.text("load") == "cavity_pressure" else None
    iterations, tension = bus.scalar("newton_iterations", "1"), bus.scalar("peak_tension", "Pa", heartbus.MAX)
    initial_pressure = bus.setting("initial_pressure", "Pa", 1333)
    held[np.isin(interface, wall.held)] = 1
    d, d_n, d_nm1, load = (function.x.array for function in (wall.d, wall.d_n, wall.d_nm1, wall.load))
    s_n = np.tile(rdq18.REST, (n, 1))
    s, force_n = s_n.copy(), np.zeros_like(blood_force)

    def set_tension(function, states):
        function.x.array[:n] = T_MAX * states[:, 0]
        function.x.scatter_forward()

    def show(old, frequency):
        wall_velocity[:] = frequency * (d - old).reshape(-1, 3)[interface]
        displacement[:] = d.reshape(-1, 3)[interface]
        tension[0] = T_MAX * s[:, 0].max(initial=0)

    for order in bus.orders():
        frequency = 1 / order.size if order.size > 0 else 0
        if order.what == heartbus.TASK and order.text == "press":
            filling.press()
            show(d_n, frequency)
        elif order.what == heartbus.TASK:  # inflate: at rest under the initial pressure; then its forces without it
            set_tension(wall.tension, s)
            for wall.share.value in (0.5, 1):
                wall.pressure.value = wall.share.value * initial_pressure
                iterations[0] = wall.solve()
            wall.pressure.value = 0
            d_n[:], d_nm1[:] = d, d
            force_n[:] = wall_force[:] = wall.forces(wall.residual)[interface]
            show(d_n, 0)
            if filling:
                filling.begin(initial_pressure, initial_pressure)
        elif order.what == heartbus.PREPARE:
            wall.frequency.value = frequency
            s = s_n + order.size * rdq18.rate(s_n, calcium, SL0 * wall.stretch())
            set_tension(wall.tension, s)
            set_tension(wall.change, s - s_n)
            wall_velocity[:] = frequency * (d_n - d_nm1).reshape(-1, 3)[interface]
            wall_force[:] = force_n + wall.forces(wall.active_change)[interface]
        elif order.what == heartbus.SOLVE:
            load.reshape(-1, 3)[interface] = blood_force
            wall.pressure.value = filling.guess[0] if filling else 0
            iterations[0] = wall.solve()
            if filling:
                filling.respond()
            show(d_n, frequency)
            wall_force[:] = blood_force
        elif order.what == heartbus.COMMIT:
            d_nm1[:], d_n[:], s_n, force_n[:] = d_n, d, s.copy(), blood_force
            if filling:
                filling.commit()
        elif order.what == heartbus.SAVE:
            np.savez(f"{order.text}/mech.{bus.communicator.rank}.npz", d_n=d_n, d_nm1=d_nm1, s=s_n, force=force_n,
                     pressures=[filling.p_n, filling.p_nm1] if filling else [])
        elif order.what == heartbus.LOAD:
            state = np.load(f"{order.text}/mech.{bus.communicator.rank}.npz")
            d[:], d_n[:], d_nm1[:], s_n, force_n[:] = (state[key] for key in ("d_n", "d_n", "d_nm1", "s", "force"))
            s, wall.share.value, wall_force[:] = s_n.copy(), 1, force_n
            show(d_nm1, frequency)
            if filling:
                filling.begin(*state["pressures"])


ventricle.take_part("mech", "mechanics", contract)
