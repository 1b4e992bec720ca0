"""The blood of the ventricle as one pressure: two valves, an atrium of constant pressure, an aorta as a Windkessel.

In place of blood in three dimensions, in the scheme `circulation`: the wall tells its volume V and its answer C to pressure;
p is found with V + C (p - guess) = V_old + dt (Q_mitral - Q_aortic), implicitly, so that no blood is lost."""
import json

import heartbus

with heartbus.join("circulation", "circulation") as bus:
    atrium = bus.setting("atrial_pressure", "Pa", 1333)
    r_mitral = bus.setting("mitral_resistance", "kg/(s m^4)", 1.3e6)
    r_aortic = bus.setting("aortic_resistance", "kg/(s m^4)", 1.3e7)
    r_vessels = bus.setting("peripheral_resistance", "kg/(s m^4)", 1.2e8)
    c_vessels = bus.setting("compliance", "m^3/Pa", 1.5e-8)
    initial = bus.setting("initial_pressure", "Pa", 1333)

    volume = bus.input("cavity_volume", "", 1, "m^3")
    compliance = bus.input("cavity_compliance", "", 1, "m^3/Pa")
    guess = bus.input("cavity_pressure_guess", "", 1, "Pa")
    pressure = bus.output("cavity_pressure", "", 1, "Pa")
    bus.task("start")
    shown = {name: bus.scalar(name, unit) for name, unit in (("volume", "m^3"), ("mean_pressure", "Pa"),
                                                             ("mitral_flow", "m^3/s"), ("aortic_flow", "m^3/s"))}
    old = {"blood": 0.0, "pressure": initial, "vessels": bus.setting("arterial_pressure", "Pa", 9000)}
    new = dict(old)

    def solve(dt):
        """One of four cases, as each valve is open or closed, contradicts nothing: all is piecewise linear in p."""
        slope = 1 / (c_vessels / dt + 1 / r_vessels)  # vessels = rest + slope Q_aortic, by implicit Euler
        rest = slope * c_vessels / dt * old["vessels"]
        closed = old["blood"] - volume[0] + compliance[0] * guess[0]
        for m, a in ((0, 0), (1, 0), (0, 1), (1, 1)):
            mitral, aortic = m * dt / r_mitral, a * dt / (r_aortic + slope)
            p = (closed + mitral * atrium + aortic * rest) / (compliance[0] + mitral + aortic)
            if (p < atrium) == bool(m) and (p > rest) == bool(a):
                break
        q_mitral, q_aortic = max(atrium - p, 0) / r_mitral, max(p - rest, 0) / (r_aortic + slope)
        shown["mitral_flow"][0], shown["aortic_flow"][0] = q_mitral, q_aortic
        return {"blood": old["blood"] + dt * (q_mitral - q_aortic), "pressure": p, "vessels": rest + slope * q_aortic}

    for order in bus.orders():
        if order.what == heartbus.TASK:
            new["blood"] = volume[0]
        elif order.what == heartbus.SOLVE:
            new = solve(order.size)
        elif order.what == heartbus.SAVE:
            with open(order.text + "/circulation.json", "w") as file:
                json.dump(old, file)
        elif order.what == heartbus.LOAD:
            with open(order.text + "/circulation.json") as file:
                new = json.load(file)
        if order.what in (heartbus.TASK, heartbus.COMMIT, heartbus.LOAD):
            old = dict(new)
        pressure[0] = shown["mean_pressure"][0] = new["pressure"]
        shown["volume"][0] = volume[0]
