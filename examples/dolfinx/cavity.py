"""Blood of one pressure in the cavity of mechanics.py, for a circulation in another participant."""
import numpy as np


class Cavity:
    """The wall is solved under the guess p* = 2 p^n - p^{n-1}, tells its volume V and what a unit pressure adds to it,

        w = A^{-1} b,   C = (V(d + w) - V(d - w)) / 2,

    and follows the pressure that the circulation finds: d += (p - p*) w. V is that behind a lid from the rim to its
    centre."""

    def __init__(self, bus, wall):
        self.wall, body = wall, wall.body
        self.volume = bus.output("cavity_volume", "", 1, "m^3")
        self.compliance = bus.output("cavity_compliance", "", 1, "m^3/Pa")
        self.guess = bus.output("cavity_pressure_guess", "", 1, "Pa")
        self.pressure = bus.input("cavity_pressure", "", 1, "Pa")
        bus.task("press")
        rim = np.intersect1d(body.nodes("interface"), body.nodes("base"))
        self.rim = rim[rim < body.n_owned]
        self.p_n = self.p_nm1 = 0.0

    def sum(self, values):
        return self.wall.body.mesh.comm.allreduce(values)

    def measured(self):
        """V = -1/3 int (x - o) . n da over the moved interface, n out of the wall, o the centre of the rim."""
        n, d = self.wall.body.n_owned, self.wall.d.x.array.reshape(-1, 3)
        x = self.wall.body.x[:n] + d[:n]
        centre = self.sum(x[self.rim].sum(0)) / self.sum(len(self.rim))
        return -self.sum(((x - centre) * self.wall.assembled(self.wall.area).array.reshape(-1, 3)).sum()) / 3

    def begin(self, p_n, p_nm1):
        self.p_n, self.p_nm1 = p_n, p_nm1
        self.wall.pressure.value = self.pressure[0] = p_n
        self.guess[0], self.volume[0] = 2 * p_n - p_nm1, self.measured()

    def respond(self):
        self.w, d, volumes = self.wall.answer_to_pressure(), self.wall.d.x.array, []
        for share in (1, -2):
            d += share * self.w
            volumes.append(self.measured())
        d += self.w
        self.volume[0], self.compliance[0] = self.measured(), (volumes[0] - volumes[1]) / 2

    def press(self):
        self.wall.d.x.array[:] += (self.pressure[0] - self.guess[0]) * self.w
        self.volume[0] = self.measured()

    def commit(self):
        self.p_n, self.p_nm1 = self.pressure[0], self.p_n
        self.guess[0] = 2 * self.p_n - self.p_nm1
