# SPDX-License-Identifier: Apache-2.0
"""The stub has what the module has, each with a docstring, and mypy takes what it is meant to take."""

import ast
import os
import subprocess
import sys
import tempfile
import unittest

import kestrel
from kestrel import _core

PACKAGE = os.path.dirname(kestrel.__file__)
PROGRAM = """
import kestrel
from kestrel import laws

sim = kestrel.Sim("landing", seed=7, overrides={"wind.mean_m_s": 5}, depth=True)
frame, state = sim.reset()
while not sim.done:
    seen, state = sim.step(kestrel.Velocity(0.1, 0, 0, yaw_rate=0.1))
    if seen is not None:
        height: float = float(seen.depth.min()) + state.position[2]
camera = kestrel.Camera.load("thesis_6mm")
pixels = camera.project([[0.0, 0.0, 1.0]])
drawn = kestrel.render("landing", camera, ((0, 0, -3), [[0, -1, 0], [1, 0, 0], [0, 0, 1]]))
velocity = laws.pbvs((0, 0, 1), [[1, 0, 0], [0, 1, 0], [0, 0, 1]], 0.5)
reveal = sim.step(3)
"""


class Stubs(unittest.TestCase):
    def setUp(self):
        with open(os.path.join(PACKAGE, "_core.pyi")) as file:
            tree = ast.parse(file.read())
        self.classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
        self.functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}

    def test_names_of_the_module(self):
        there = {name for name in vars(_core) if not name.startswith("_")}
        self.assertEqual(there, set(self.classes) | self.functions)
        self.assertLessEqual(there - set(kestrel.laws.__all__), set(kestrel.__all__))

    def test_names_of_its_classes(self):
        for name, node in self.classes.items():
            of_stub = {item.name for item in node.body if isinstance(item, ast.FunctionDef)} - {"__init__", "__bool__"}
            of_class = {member for member in vars(getattr(_core, name)) if not member.startswith("__")}
            if not issubclass(getattr(_core, name), Exception):
                self.assertEqual(of_class - {"_pybind11_conduit_v1_"}, of_stub, name)

    def test_all_are_documented(self):
        for name in set(self.classes) | self.functions:
            value = getattr(_core, name)
            self.assertTrue(value.__doc__ and len(value.__doc__) > 20, name)
            if isinstance(value, type) and not issubclass(value, Exception):
                for member, of in vars(value).items():
                    if not member.startswith("_"):
                        text = of.__doc__ if not isinstance(of, staticmethod) else of.__func__.__doc__
                        self.assertTrue(text and text.strip(), f"{name}.{member}")

    def test_mypy_takes_a_program(self):
        if subprocess.run([sys.executable, "-m", "mypy", "--version"], capture_output=True).returncode != 0:
            self.skipTest("without mypy")
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "program.py")
            with open(file, "w") as out:
                out.write(PROGRAM)
            run = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent",
                                  "--cache-dir", folder, file], capture_output=True, text=True,
                                 env=dict(os.environ, MYPYPATH=os.path.dirname(PACKAGE)))
        errors = [line for line in run.stdout.splitlines() if "error" in line and "Found" not in line]
        self.assertEqual(len(errors), 1, run.stdout + run.stderr)  # but for what is meant to be one
        self.assertIn('incompatible type "int"', errors[0])


if __name__ == "__main__":
    unittest.main()
