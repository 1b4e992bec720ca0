"""A program in Python takes part in a coupled run of the heart.

    import heartbus

    with heartbus.join("ep", "my_ep") as bus:
        ... bus.points, bus.output, bus.input, bus.task, bus.scalar ...
        for order in bus.orders():                     # or bus.serve(solver)
            if order.what == heartbus.SOLVE:
                ...

Arrays are views of the memory that the bus sends from and receives into: change their elements, do not replace them. All
values are in SI units (calcium in uM). An exception ends the launch, with its message as the cause; any other failure of
the launch ends the program at once with the right exit code.
"""
import atexit
import ctypes
import os
import sys
import traceback
from pathlib import Path
from types import SimpleNamespace

import numpy

from . import interface
from .interface import (COMMIT, DEADLINE, END, FILE, FINISH, FIRST, HANDSHAKE, LOAD, MAP, MAX, MIN, NOT_CONVERGED,  # noqa: F401
                        NOT_FINITE, PREPARE, REFRESH, SAVE, SCENE, SOLVE, SUM, TASK, UNFORESEEN)

METHODS = {PREPARE: "prepare", SOLVE: "solve", COMMIT: "commit", TASK: "task", SAVE: "save", LOAD: "load", REFRESH: "refresh",
           FINISH: "finish"}


def _load():
    library = ctypes.CDLL(os.environ.get("HEARTBUS_LIBRARY", str(Path(__file__).resolve().parent / interface.LIBRARY)))
    for name, (result, arguments) in interface.FUNCTIONS.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


class Failure(Exception):
    """Ends the launch with an exit code of its own, e.g. heartbus.NOT_CONVERGED."""

    def __init__(self, code, message):
        super().__init__(message)
        self.code = code


def join(name, program):
    """Joins the launch; the name of the scene, if the launcher tells it, goes before `name`."""
    bus = ctypes.c_void_p()
    library = _load()
    code = library.heartbus_join(ctypes.byref(bus), name.encode(), program.encode())
    if code:
        sys.exit(code)
    return Bus(library, bus)


class Bus:
    def __init__(self, library, bus):
        self._library, self._bus = library, bus
        self._over = False
        atexit.register(self._end, HANDSHAKE, "it ended before the end of the run")

    def __enter__(self):
        return self

    def __exit__(self, kind, exception, trace):
        if exception is None:
            self.leave()
        elif not isinstance(exception, SystemExit) or not self._over:
            self._explain(exception, trace)
        return False

    def _explain(self, exception, trace):
        code = getattr(exception, "code", UNFORESEEN) if isinstance(exception, Failure) else UNFORESEEN
        message = str(exception)
        if not isinstance(exception, Failure):
            place = traceback.extract_tb(trace)[-1]
            message = f"{type(exception).__name__}: {message} ({Path(place.filename).name}:{place.lineno})"
        sys.exit(self._end(code, message))

    def _end(self, code, message):
        """After a failure the process ends next: others may still write into its memory, and MPI is not finalised."""
        if self._over:
            return None
        self._over = True
        code = self._library.heartbus_fail(self._bus, code, message.encode())
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)

    def _check(self, code):
        if code:
            self._over = True
            os._exit(code)

    def _array(self, pointer, n):
        if not pointer:
            self._check(self._library.heartbus_leave(self._bus))
        return numpy.ctypeslib.as_array(pointer, (n,))

    def _field(self, call, field, point_set, components, unit):
        n = self._sizes[point_set] if point_set else 1
        values = self._array(call(self._bus, field.encode(), point_set.encode(), components, unit.encode()), n * components)
        return values.reshape(n, components) if components > 1 else values

    @property
    def communicator(self):
        """The ranks of this participant alone, of mpi4py."""
        from mpi4py import MPI
        return MPI.Comm.f2py(self._library.heartbus_communicator(self._bus))

    @property
    def scene(self):
        """The whole scene, YAML."""
        return self._library.heartbus_scene(self._bus).decode()

    @property
    def folder(self):
        """Of the results; exists."""
        return Path(self._library.heartbus_folder(self._bus).decode())

    def setting(self, key, unit, default):
        """What the scene says under participants.NAME.settings, in `unit`; "1" for plain numbers."""
        value = ctypes.c_double(default)
        self._check(self._library.heartbus_setting(self._bus, key.encode(), unit.encode(), ctypes.byref(value)))
        return value.value

    def text(self, key, default=None):
        value = self._library.heartbus_setting_text(self._bus, key.encode(), None)
        return default if value is None else value.decode()

    def partner(self, participant, point_set):
        """Points of another participant: `points` (n, 3) [m], `spacing` [m], `faces` (m, corners), counter-clockwise seen
        from outside its body."""
        got = interface.heartbus_partner_points()
        self._check(self._library.heartbus_partner(self._bus, participant.encode(), point_set.encode(), ctypes.byref(got)))
        points = numpy.ctypeslib.as_array(got.points, (got.n_points, 3))
        corners = max(got.n_corners, 1)
        faces = numpy.ctypeslib.as_array(got.faces, (got.n_faces, corners)) if got.n_faces else numpy.empty((0, corners), int)
        return SimpleNamespace(points=points, spacing=got.spacing, faces=faces)

    _sizes = None

    def points(self, name, points, spacing):
        """Points that this rank owns, (n, 3) [m], and the smallest distance between neighbours [m]."""
        points = numpy.ascontiguousarray(points, dtype=float).reshape(-1, 3)
        pointer = points.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        self._check(self._library.heartbus_points(self._bus, name.encode(), len(points), pointer, spacing))
        self._sizes = {**(self._sizes or {}), name: len(points)}

    def output(self, field, point_set, components, unit):
        """The array to be filled, (n,) or (n, components); without a point set, "", of the components alone."""
        return self._field(self._library.heartbus_output, field, point_set, components, unit)

    def input(self, field, point_set, components, unit):
        """The array that is filled before the order that needs it."""
        return self._field(self._library.heartbus_input, field, point_set, components, unit)

    def scalar(self, name, unit, combine=FIRST):
        """A number for the history, as an array of one."""
        return self._array(self._library.heartbus_scalar(self._bus, name.encode(), unit.encode(), combine), 1)

    def task(self, name):
        self._check(self._library.heartbus_task(self._bus, name.encode()))

    def orders(self):
        """One after the other, each with what, number, iteration, time, size and text; waits asleep for the next."""
        order, next_order = interface.heartbus_order(), self._library.heartbus_next
        place = ctypes.byref(order)
        while next_order(self._bus, place):
            yield SimpleNamespace(what=order.what, number=order.number, iteration=order.iteration, time=order.time,
                                  size=order.size, text=order.text.decode())

    def serve(self, solver):
        """The loop over the orders: for each one the method of its name (prepare, solve, commit, task, save, load, refresh,
        finish), with the order; what the solver does not have is passed over."""
        for order in self.orders():
            getattr(solver, METHODS[order.what], lambda _: None)(order)

    def leave(self):
        """Waits until all have come to the end."""
        code = self._library.heartbus_leave(self._bus)
        self._check(code)
        self._over = True
