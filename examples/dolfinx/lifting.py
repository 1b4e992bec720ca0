"""Motion of the fluid's mesh in DOLFINx, in place of ale_solver: the wall's motion, lifted harmonically.

    -Laplace d = 0,  d as the wall's on `interface`, d = 0 on `base`, `mitral`, `aortic`"""
import numpy as np
import ventricle

import heartbus

def lift(bus):
    import dolfinx
    import ufl
    from petsc4py import PETSc

    blood = ventricle.Body(bus.communicator, bus.text("mesh", "ventricle.h5"), "fluid")
    interface = blood.nodes("interface")
    held = np.unique(np.concatenate([blood.nodes(label) for label in ("base", "mitral", "aortic")]))
    wall = interface[interface < blood.n_owned]
    bus.points("cavity", blood.x[:blood.n_owned], blood.spacing)
    bus.points("interface", blood.x[wall], blood.spacing)
    displacement = bus.input("displacement", "interface", 3, "m")
    mesh_motion = bus.output("mesh_motion", "cavity", 3, "m")

    d, v = ufl.TrialFunction(blood.space), ufl.TestFunction(blood.space)
    motion, given = dolfinx.fem.Function(blood.space), dolfinx.fem.Function(blood.space)
    conditions = [dolfinx.fem.dirichletbc(given, np.union1d(interface, held).astype(np.int32))]
    measure = ufl.dx(metadata={"quadrature_degree": 3})
    stiffness = dolfinx.fem.form(ufl.inner(ufl.grad(d), ufl.grad(v)) * measure)
    matrix = dolfinx.fem.petsc.assemble_matrix(stiffness, conditions)
    matrix.assemble()
    solver = PETSc.KSP().create(bus.communicator)
    solver.setOperators(matrix)
    solver.setType("preonly")
    solver.getPC().setType("lu")
    solver.getPC().setFactorSolverType("mumps")
    right = dolfinx.fem.petsc.create_vector(dolfinx.fem.form(ufl.inner(given, v) * measure))

    for order in bus.orders():
        if order.what != heartbus.SOLVE:
            continue
        given.x.array.reshape(-1, 3)[wall] = displacement
        given.x.array.reshape(-1, 3)[np.intersect1d(held, wall)] = 0
        given.x.scatter_forward()
        right.set(0)
        dolfinx.fem.petsc.apply_lifting(right, [stiffness], [conditions])
        right.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        dolfinx.fem.petsc.set_bc(right, conditions)
        solver.solve(right, motion.vector)
        mesh_motion[:] = motion.x.array.reshape(-1, 3)[:blood.n_owned]


ventricle.take_part("ale", "lifting", lift)
