"""The wall of the ventricle in DOLFINx, in place of mech_solver, in the loosely coupled schemes.

    rho (d - 2 d^n + d^{n-1}) / dt^2 - div P = 0,   P = dW/dF + T O(SL) / lambda F H,   P n = L on `interface`, d = 0 on `base`,
    P n = -(n x n) (K_perp d + C_perp v) - (I - n x n) (K_par d + C_par v) on `epicardium`

with Guccione's W, the tension T = T_max s_1 of nodal states s, fibres H = (1 - nu) f x f + nu n x n of stretch lambda^2 = H : C,
and the overlap O of short sarcomeres. The blood is given, with nodal forces on the wall,

    v* = (d^n - d^{n-1}) / dt,  W* = L^n + int (P_act(d^n, s^{n+1}) - P_act(d^n, s^n)) : grad phi,

then, for each further iteration, v* = (d - d^n) / dt, W* = L. Formulas and sources: mech_solver/README.md."""
import numpy as np
import rdq18
import ventricle

import heartbus

RHO = 1000.0                                                    # kg/m^3
C, A_FF, A_SS, A_NN, A_FS, A_FN, A_SN = 880.0, 8, 6, 3, 12, 3, 3  # Pa, 1
KAPPA, T_MAX, SL0 = 50e3, 500e3, 1.75                           # Pa, Pa, um
K_PERP, K_PAR, C_PERP, C_PAR = 2e5, 2e4, 2e4, 2e3               # Pa/m, Pa s/m
DEGREE = 3                                                      # of quadrature: two points in each direction


class Wall:
    """All that is assembled: d and what it depends on are functions, set from outside."""

    def __init__(self, body):
        import dolfinx
        import ufl
        from dolfinx import fem
        self.body, mesh, space = body, body.mesh, body.space
        self.d, self.d_n, self.d_nm1, self.load = (fem.Function(space) for _ in range(4))
        nodal = fem.FunctionSpace(mesh, ("Lagrange", 1))
        assert np.array_equal(nodal.tabulate_dof_coordinates(), body.x)
        self.tension, self.change = fem.Function(nodal), fem.Function(nodal)
        self.frequency, self.pressure, self.share = (fem.Constant(mesh, 0.0) for _ in range(3))  # 1/dt or 0, Pa, 0 to 1
        f, s, n, nu = self.frame()
        v, w, N, I = ufl.TestFunction(space), ufl.TestFunction(nodal), ufl.FacetNormal(mesh), ufl.Identity(3)
        metadata = {"quadrature_degree": DEGREE}
        dx = ufl.dx(domain=mesh, metadata=metadata)
        labels = [(1, body.facets("interface")), (2, body.facets("epicardium"))]
        where = np.concatenate([facets for _, facets in labels])
        which = np.concatenate([np.full(len(facets), label, dtype=np.int32) for label, facets in labels])
        order = np.argsort(where)
        tags = dolfinx.mesh.meshtags(mesh, 2, where[order], which[order])
        ds = ufl.ds(domain=mesh, subdomain_data=tags, metadata=metadata)

        F = I + ufl.grad(self.d)
        J, right = ufl.det(F), F.T * F
        E = [[ufl.dot(a, (right - I) / 2 * b) for b in (f, s, n)] for a in (f, s, n)]
        Q = A_FF * E[0][0]**2 + A_SS * E[1][1]**2 + A_NN * E[2][2]**2 + \
            2 * (A_FS * E[0][1]**2 + A_FN * E[0][2]**2 + A_SN * E[1][2]**2)
        energy = C / 2 * (ufl.exp(Q) - 1) + KAPPA / 2 * (J - 1) * ufl.ln(J)
        H = (1 - nu) * ufl.outer(f, f) + nu * ufl.outer(n, n)
        I4 = ufl.inner(H, right)
        SL, full = SL0 * ufl.sqrt(I4), 1.7 + 1.65 - 2.4
        overlap = ufl.conditional(SL < 1.2, 0, ufl.conditional(SL < 1.65, 2 / full * (SL - 1.2), ufl.conditional(
            SL < 1.7, (SL + 1.65 - 2.4) / full, 1)))
        def active(tension):
            return ufl.inner(tension * overlap / ufl.sqrt(I4) * F * H, ufl.grad(v)) * dx
        acceleration = self.frequency**2 * (self.d - 2 * self.d_n + self.d_nm1)
        velocity = self.frequency * (self.d - self.d_n)
        normal = ufl.outer(N, N)
        pericardium = normal * (K_PERP * self.d + C_PERP * velocity) + (I - normal) * (K_PAR * self.d + C_PAR * velocity)
        inner = RHO * ufl.inner(acceleration, v) * dx + ufl.derivative(energy * dx, self.d, v) + \
            active(self.share * self.tension) + ufl.inner(pericardium, v) * ds(2) + \
            self.pressure * ufl.inner(J * ufl.inv(F).T * N, v) * ds(1)
        self.residual, self.tangent = fem.form(inner), fem.form(ufl.derivative(inner, self.d))
        self.active_change = fem.form(active(self.change))
        self.stretches, self.weights = fem.form(I4 * w * dx), fem.form(w * dx)
        held = np.intersect1d(body.nodes("base"), np.arange(len(body.x))).astype(np.int32)
        self.held, self.conditions = held, [fem.dirichletbc(np.zeros(3), held, space)]

    def frame(self):
        """f, s, n and nu at the points of quadrature."""
        import basix
        import ufl
        from dolfinx import fem
        mesh = self.body.mesh
        element = {"family": "Quadrature", "cell": mesh.ufl_cell(), "degree": DEGREE, "quad_scheme": "default"}
        vectors = fem.FunctionSpace(mesh, ufl.VectorElement(**element))
        scalars = fem.FunctionSpace(mesh, ufl.FiniteElement(**element))
        index_map = mesh.topology.index_map(3)
        cells = np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
        points, _ = basix.make_quadrature(basix.CellType.hexahedron, DEGREE)
        places = fem.Expression(ufl.SpatialCoordinate(mesh), points).eval(cells)
        fields = []
        for values in ventricle.fibres(places.reshape(-1, 3)):
            function = fem.Function(vectors if values.ndim == 2 else scalars)
            function.x.array.reshape(-1, *values.shape[1:])[function.function_space.dofmap.list.array] = values
            fields.append(function)
        return fields

    def assembled(self, form):
        from dolfinx import fem
        from petsc4py import PETSc
        vector = fem.petsc.assemble_vector(form)
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        return vector

    def forces(self, form):
        """Nodal forces (n_owned, 3) [N], zero where the wall is held."""
        values = self.assembled(form).array.reshape(-1, 3)
        values[self.held[self.held < len(values)]] = 0
        return values

    def stretch(self):
        return np.sqrt(self.assembled(self.stretches).array / self.assembled(self.weights).array)

    def solve(self):
        """Newton's method for d; returns its iterations."""
        from dolfinx import fem
        from petsc4py import PETSc
        if not hasattr(self, "ksp"):
            self.matrix = fem.petsc.create_matrix(self.tangent)
            self.ksp = PETSc.KSP().create(self.body.mesh.comm)
            self.ksp.setOperators(self.matrix)
            self.ksp.setType("preonly")
            self.ksp.getPC().setType("lu")
            self.ksp.getPC().setFactorSolverType("mumps")
        for iteration in range(1, 31):
            right = self.assembled(self.residual)
            right.axpy(-1, self.load.vector)
            fem.petsc.set_bc(right, self.conditions, scale=0)
            self.matrix.zeroEntries()
            fem.petsc.assemble_matrix(self.matrix, self.tangent, self.conditions)
            self.matrix.assemble()
            update = right.duplicate()
            self.ksp.solve(right, update)
            self.d.vector.axpy(-1, update)
            self.d.x.scatter_forward()
            if update.norm(PETSc.NormType.INFINITY) < 1e-11:  # m
                return iteration
        raise heartbus.Failure(heartbus.NOT_CONVERGED, "Newton's method of the wall: no convergence in 30 iterations")


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
        if order.what == heartbus.TASK:  # inflate: at rest under the initial pressure, then the same forces without it
            set_tension(wall.tension, s)
            for wall.share.value in (0.5, 1):
                wall.pressure.value = wall.share.value * initial_pressure
                iterations[0] = wall.solve()
            wall.pressure.value = 0
            d_n[:], d_nm1[:] = d, d
            force_n[:] = wall_force[:] = wall.forces(wall.residual)[interface]
            show(d_n, 0)
        elif order.what == heartbus.PREPARE:
            wall.frequency.value = frequency
            s = s_n + order.size * rdq18.rate(s_n, calcium, SL0 * wall.stretch())
            set_tension(wall.tension, s)
            set_tension(wall.change, s - s_n)
            wall_velocity[:] = frequency * (d_n - d_nm1).reshape(-1, 3)[interface]
            wall_force[:] = force_n + wall.forces(wall.active_change)[interface]
        elif order.what == heartbus.SOLVE:
            load.reshape(-1, 3)[interface] = blood_force
            iterations[0] = wall.solve()
            show(d_n, frequency)
            wall_force[:] = blood_force
        elif order.what == heartbus.COMMIT:
            d_nm1[:], d_n[:], s_n, force_n[:] = d_n, d, s.copy(), blood_force
        elif order.what == heartbus.SAVE:
            np.savez(f"{order.text}/mech.{bus.communicator.rank}.npz", d_n=d_n, d_nm1=d_nm1, s=s_n, force=force_n)
        elif order.what == heartbus.LOAD:
            state = np.load(f"{order.text}/mech.{bus.communicator.rank}.npz")
            d[:], d_n[:], d_nm1[:], s_n, force_n[:] = (state[key] for key in ("d_n", "d_n", "d_nm1", "s", "force"))
            s, wall.share.value, wall_force[:] = s_n.copy(), 1, force_n
            show(d_nm1, frequency)


ventricle.take_part("mech", "mechanics", contract)
