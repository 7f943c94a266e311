# SPDX-License-Identifier: Apache-2.0
"""The wheel is whole, and what it is unpacked to flies by itself."""

import base64
import csv
import hashlib
import io
import os
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path

import kestrel

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python" / "wheel"))
import backend  # noqa: E402


class Wheel(unittest.TestCase):
    def setUp(self):
        self.build = Path(kestrel.__file__).parents[2]  # as it is: a test builds nothing
        self.backend_build, backend._build = backend._build, lambda settings: self.build
        self.folder = tempfile.TemporaryDirectory()

    def tearDown(self):
        backend._build = self.backend_build
        self.folder.cleanup()

    def test_flies_by_itself(self):
        name = backend.build_wheel(self.folder.name)
        self.assertRegex(name, r"^kestrel-[\d.]+-cp3\d+-cp3\d+-linux_\w+\.whl$")
        target = os.path.join(self.folder.name, "target")
        with zipfile.ZipFile(os.path.join(self.folder.name, name)) as wheel:
            record = next(file for file in wheel.namelist() if file.endswith("RECORD"))
            rows = list(csv.reader(io.StringIO(wheel.read(record).decode())))
            self.assertEqual(sorted(row[0] for row in rows), sorted(wheel.namelist()))
            for file, digest, size in rows:
                content = wheel.read(file)
                if file != record:
                    expected = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
                    self.assertEqual((digest, size), ("sha256=" + expected, str(len(content))))
                # as an installer does
                path = os.path.join(target, file.split(".data/data/")[-1])
                os.makedirs(os.path.dirname(path), exist_ok=True)
                with open(path, "wb") as out:
                    out.write(content)
        code = ("import kestrel; s = kestrel.Sim('hover', overrides={'duration_s': 2}, images=False); s.reset(); "
                "print(kestrel.__file__, kestrel.Camera.load('thesis_6mm'))")
        environment = {key: value for key, value in os.environ.items() if key not in ("KESTREL_ROOT", "KESTREL_PATH")}
        run = subprocess.run([sys.executable, "-c", code], env={**environment, "PYTHONPATH": target}, cwd=target,
                             capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertTrue(run.stdout.startswith(target), run.stdout)

    def test_for_work_on_it_names_the_build_folder(self):
        name = backend.build_editable(self.folder.name)
        with zipfile.ZipFile(os.path.join(self.folder.name, name)) as wheel:
            self.assertEqual(wheel.read("kestrel.pth").decode().strip(), str(self.build / "python"))


if __name__ == "__main__":
    unittest.main()
