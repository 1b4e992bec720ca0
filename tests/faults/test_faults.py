"""The cheapest cells of the matrix; tests/faults/run tries them all, as the test faults/matrix (label nightly) does."""
import unittest

from casts import Casts
from faults import FAULTS
from trial import Trial

CHEAP = {"SIGSEGV": "mech", "NaN in a field": "ep", "missing rank": "ale", "wrong version": "coupler"}


class Faults(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.casts = Casts()

    def test_each_ends_soon_with_its_cause_and_the_last_checkpoint_restarts(self):
        for fault in FAULTS:
            if participant := CHEAP.get(fault.name):
                with self.subTest(fault.name, participant=participant):
                    outcome = fault.run(Trial(self.casts, participant))
                    self.assertEqual(outcome.complaints(), [], outcome.output)
                    self.assertLess(outcome.seconds, 30)


if __name__ == "__main__":
    unittest.main(verbosity=2)
