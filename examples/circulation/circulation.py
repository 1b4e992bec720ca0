"""The blood of the ventricle as one pressure: two valves, an atrium of constant pressure, an aorta as a Windkessel.

In place of blood in three dimensions, in the scheme `circulation`: the wall tells its volume V and its answer C to
pressure; p is found with V + C (p - guess) = V_old + dt (Q_mitral - Q_aortic), so that no blood is lost."""
import json
from pathlib import Path

import heartbus

with heartbus.join("circulation", "circulation") as bus:
    atrium = bus.setting("atrial_pressure", "Pa", 1333)
    r_mitral = bus.setting("mitral_resistance", "kg/(s m^4)", 1.3e6)
    r_aortic = bus.setting("aortic_resistance", "kg/(s m^4)", 1.3e7)
    a_mitral, a_aortic = bus.setting("mitral_area", "m^2", 0), bus.setting("aortic_area", "m^2", 0)
    density = bus.setting("density", "kg/m^3", 1060)
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
    old = new = {"blood": 0.0, "pressure": initial, "vessels": bus.setting("arterial_pressure", "Pa", 9000)}

    def flow(dp, resistance, area):
        """Q of dp = R Q + rho/2 (Q / A)^2: resistance and jet of a valve; nothing flows backwards."""
        jet = density / (2 * area**2) if area else 0
        return 2 * dp / (resistance + (resistance**2 + 4 * jet * dp)**0.5) if dp > 0 else 0

    def solve(dt):
        """What volume and flows contradict each other by grows with p: it is zero once."""
        slope = 1 / (c_vessels / dt + 1 / r_vessels)  # vessels = rest + slope Q_aortic, by implicit Euler
        rest = slope * c_vessels / dt * old["vessels"]
        closed = guess[0] + (old["blood"] - volume[0]) / compliance[0]
        low, high = min(closed, rest), max(closed, atrium)
        for _ in range(100):
            p = (low + high) / 2
            q_mitral, q_aortic = flow(atrium - p, r_mitral, a_mitral), flow(p - rest, r_aortic + slope, a_aortic)
            low, high = (low, p) if compliance[0] * (p - closed) > dt * (q_mitral - q_aortic) else (p, high)
        shown["mitral_flow"][0], shown["aortic_flow"][0] = q_mitral, q_aortic
        return {"blood": old["blood"] + dt * (q_mitral - q_aortic), "pressure": p, "vessels": rest + slope * q_aortic}

    for order in bus.orders():
        if order.what == heartbus.TASK:
            new["blood"] = volume[0]
        elif order.what == heartbus.SOLVE:
            new = solve(order.size)
        elif order.what == heartbus.SAVE:
            Path(order.text, "circulation.json").write_text(json.dumps(old))
        elif order.what == heartbus.LOAD:
            new = json.loads(Path(order.text, "circulation.json").read_text())
        if order.what in (heartbus.TASK, heartbus.COMMIT, heartbus.LOAD):
            old = dict(new)
        pressure[0] = shown["mean_pressure"][0] = new["pressure"]
        shown["volume"][0] = volume[0]
