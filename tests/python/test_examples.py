# SPDX-License-Identifier: Apache-2.0
"""Each example of Python, run as a reader would run it."""

import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).parents[2]
PROGRAM = os.environ.get("KESTREL_PROGRAM", "kestrel")


def run(example, *arguments):
    command = [sys.executable, "-B", SOURCE / "examples/python" / example, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f"{example}: {done.stderr}")
    return done.stdout


def needs(*modules):
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    return unittest.skipIf(missing, f"without {' and '.join(missing)}")


class Examples(unittest.TestCase):
    @needs("cv2")
    def test_own_detector_lands(self):
        out = run("land_with_own_detector.py", SOURCE / "models/pads/helipad/helipad.png", 201)
        self.assertRegex(out, r"seed 201: passed \(landed\)")

    @needs("cv2")
    def test_horizon_evaluation(self):
        out = run("horizon_evaluation.py", 3)
        roll, pitch = map(float, re.search(r"autumn_clear +roll +([\d.]+), pitch +([\d.]+)", out).groups())
        self.assertLess(roll, 2)
        self.assertLess(pitch, 2)

    @needs("pandas", "matplotlib")
    def test_plot_campaign(self):
        with tempfile.TemporaryDirectory() as folder:
            results, plot = pathlib.Path(folder, "landings"), pathlib.Path(folder, "landings.png")
            subprocess.run([PROGRAM, "campaign", "dispersion", "--runs", "2", "--out", results,
                            "--record-failures", "0", "--quiet"], cwd=SOURCE)
            out = run("plot_campaign.py", results, plot)
            self.assertEqual(sum(float(count) for count in re.findall(r"\] +(\d\.0) ", out)), 2)
            self.assertEqual(plot.read_bytes()[1:4], b"PNG")

    def test_learn_hover(self):
        out = run("learn_hover.py", 4)
        untrained, learnt = map(float, re.search(r"untrained ([\d.]+) m, learnt ([\d.]+) m", out).groups())
        self.assertLess(learnt, untrained)


if __name__ == "__main__":
    unittest.main()
