"""The equations of the wall in DOLFINx. Sources of the formulas: mech_solver/README.md."""
import numpy as np
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
        pericardium = normal * (K_PERP * self.d + C_PERP * velocity) + \
            (I - normal) * (K_PAR * self.d + C_PAR * velocity)
        area = ufl.inner(J * ufl.inv(F).T * N, v) * ds(1)
        inner = RHO * ufl.inner(acceleration, v) * dx + ufl.derivative(energy * dx, self.d, v) + \
            active(self.share * self.tension) + ufl.inner(pericardium, v) * ds(2) + \
            self.pressure * area
        self.residual, self.tangent = fem.form(inner), fem.form(ufl.derivative(inner, self.d))
        self.active_change, self.area = fem.form(active(self.change)), fem.form(area)
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

    def answer_to_pressure(self):
        """w = A^{-1} b: of all nodes of this rank [m/Pa]."""
        from dolfinx import fem
        right, w = self.assembled(self.area), fem.Function(self.body.space)
        right.scale(-1)
        fem.petsc.set_bc(right, self.conditions, scale=0)
        self.ksp.solve(right, w.vector)
        w.x.scatter_forward()
        return w.x.array
