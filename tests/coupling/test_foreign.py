"""A program of somebody else that does something wrong ends the launch: one message with the culprit, its code, nobody left.
What does not fit between two programs is in test_conformance.py."""
import shutil
import subprocess
import sys
import tempfile
import textwrap
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from launch import BIN, SOURCE, Launch, unless_sanitized, use_library

SHARE = BIN.parent / "share/heartbus"
AT_ONCE = 3   # some are waited for
SECONDS = 30  # the deadline is not waited for, but the machine may be busy
SCENE = f"""\
base: {SOURCE}/configs/ideal_lv/electromechanics.yaml
scene: foreign
geometry: {{mesh: MXS}}
time: {{end: 4 ms, step: 1 ms}}
coupling: {{deadline: 20 s}}
participants:
  ep: {{command: COMMAND, ranks: 1, settings: {{pressure: 10 mmHg}}}}
  mech: {{program: stand_in, ranks: 1, settings: {{mischief: none, step: 0, delay: 0}}}}
output: {{every: 0 ms}}
"""
PYTHON = """\
import os
import heartbus
with heartbus.join("ep", "mine") as bus:
    pressure = bus.setting("pressure", "Pa", 0)
    assert abs(pressure - 1333.22) < 0.01
    wall = bus.partner("mech", "tissue")
    bus.points("tissue", wall.points, wall.spacing)
    calcium = bus.output("calcium", "tissue", 1, "uM")
    for order in bus.orders():
        calcium[:] = order.time
"""
# (what is wrong, text, in its place, exit code, parts of the message)
WRONG = [
    ("nothing", "", "", 0, []),
    ("nothing, orders are served", "    for order in bus.orders():\n        calcium[:] = order.time\n",
     "    from types import SimpleNamespace\n    bus.serve(SimpleNamespace(solve=lambda order: calcium.fill(order.time)))\n", 0, []),
    ("an exception of a method", "    for order in bus.orders():\n        calcium[:] = order.time\n",
     "    from types import SimpleNamespace\n    bus.serve(SimpleNamespace(commit=lambda order: 1 / 0))\n", 1,
     ["heartbus: ep (rank 0): ZeroDivisionError: division by zero (mine.py:10)"]),
    ("an exception", "calcium[:] = order.time", "calcium[10**6] = 1", 1,
     ["heartbus: ep (rank 0): IndexError: index 1000000 is out of bounds", "(mine.py:10)"]),
    ("a failure of its own", "calcium[:] = order.time", "raise heartbus.Failure(heartbus.FILE, 'table.csv:3: no number')", 8,
     ["heartbus: ep (rank 0): table.csv:3: no number"]),
    ("NaN", "calcium[:] = order.time", "calcium[3] = float('nan')", 6,
     ["heartbus: ep (rank 0): field 'calcium' is nan at point (", "it has not been sent"]),
    ("points of nobody", '"mech", "tissue"', '"mesh", "tissue"', 3,
     ["ep asks for the points 'tissue' of 'mesh', who does not take part; the others are mech"]),
    ("points that do not exist", '"mech", "tissue"', '"mech", "nodes"', 3,
     ["mech declares no point set 'nodes'; it has: tissue interface"]),
    ("a setting of another dimension", '"pressure", "Pa"', '"pressure", "m"', 2,
     ["key 'participants.ep.settings.pressure'", "expected a length-like unit, e.g. m; got mmHg"]),
    ("a setting that is not known", 'bus.setting("pressure", "Pa", 0)', "1333.22", 2,
     ["key 'participants.ep.settings.pressure': this program takes no such setting; it takes none"]),
    ("it leaves early", "    for order in bus.orders():\n        calcium[:] = order.time\n", "", 3,
     ["heartbus: ep (rank 0): it leaves before the end of the run"]),
    ("a declaration that comes late", "calcium[:] = order.time", "bus.task('late')", 3,
     ["task 'late' is declared after the first order"]),
    ("it ends the process", "calcium[:] = order.time", "os._exit(0)", None, []),
    ("no MPI", "import heartbus", "raise SystemExit(0)", None, ["heartbus: ep"]),
]
CRASH = """\
program crash
  use heartbus
  type(bus_t) :: bus
  type(order_t) :: order
  type(partner_t) :: wall
  real(8), pointer :: calcium(:, :)
  integer, pointer :: nowhere
  real(8) :: pressure
  call bus%join('ep', 'crash')
  call bus%setting('pressure', 'Pa', pressure)
  wall = bus%partner('mech', 'tissue')
  call bus%points('tissue', wall%points, wall%spacing)
  calcium => bus%output('calcium', 'tissue', 1, 'uM')
  nullify(nowhere)
  do while (bus%next(order))
    nowhere = 1
  end do
  call bus%leave()
end program crash
"""


class Foreign(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        use_library()

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def launch(self, command, folder=None):
        folder = folder or self.folder
        scene = folder / "scene.yaml"
        scene.write_text(SCENE.replace("COMMAND", command))
        return Launch(["/usr/bin/python3", SOURCE / "tools/check.py", "--launch", scene, "--oversubscribe", "--force"], folder)

    def assert_ends(self, run, code, parts):
        self.assertEqual(run.code, code, run.output) if code is not None else self.assertNotEqual(run.code, 0, run.output)
        for part in parts:
            self.assertIn(part, run.output)
        causes = [line for line in run.output.splitlines() if line.startswith(("heartbus: ", "error: "))]
        self.assertEqual(len(causes), 0 if code == 0 else 1, run.output)
        self.assertLess(run.seconds, SECONDS)
        self.assertEqual(run.orphans, [])

    def test_whatever_a_python_program_does_wrong_is_told_in_one_message(self):
        def launch(what, right, wrong, *_):
            folder = self.folder / what.replace(" ", "_")
            folder.mkdir()
            (folder / "mine.py").write_text(PYTHON.replace(right, wrong) if right else PYTHON)
            return self.launch(f"{sys.executable} mine.py", folder)

        with ThreadPoolExecutor(AT_ONCE) as pool:
            runs = list(pool.map(launch, *zip(*WRONG)))
        for (what, _, _, code, parts), run in zip(WRONG, runs):
            with self.subTest(what):
                self.assert_ends(run, code, parts)

    @unless_sanitized
    @unittest.skipUnless(shutil.which("gfortran"), "there is no gfortran here")
    def test_a_crash_in_fortran_names_the_program_and_the_signal(self):
        (self.folder / "crash.f90").write_text(textwrap.dedent(CRASH))
        modules = [SHARE / "fortran" / file for file in ("heartbus_c.f90", "heartbus.f90")]
        library = BIN.parent / "lib"
        subprocess.run(["mpif90", "-o", "crash", *modules, "crash.f90", f"-L{library}", "-lheartbus", f"-Wl,-rpath,{library}"],
                       cwd=self.folder, check=True)
        self.assert_ends(self.launch("./crash"), 139, ["heartbus: ep on ", "was ended by signal 11 (SIGSEGV)"])

    def test_a_command_that_does_not_exist_is_an_error_of_the_scene(self):
        run = self.launch("pyhton3 mine.py")
        self.assert_ends(run, 2, ["scene.yaml:7: key 'participants.ep.command': there is no executable 'pyhton3'"])

    def test_a_quote_that_is_not_closed_is_an_error_of_the_scene(self):
        self.assert_ends(self.launch("\"python3 'mine.py\""), 2, ["has a quote that is not closed"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
