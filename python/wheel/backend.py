# SPDX-License-Identifier: Apache-2.0
"""Makes a wheel of the package kestrel (PEP 517 and 660) out of a build folder of CMake, and needs nothing else.

The folder is build/, or that of `--config-settings build-dir=FOLDER`; what is built there already is not built again.
"""

from __future__ import annotations

import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SUFFIX = sysconfig.get_config_var("EXT_SUFFIX")  # of a module for this Python


class UnsupportedOperation(Exception):
    pass


def get_requires_for_build_wheel(config_settings=None):
    return []


def build_sdist(sdist_directory, config_settings=None):
    raise UnsupportedOperation("Kestrel is built from its checkout, not from a source archive")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    package = _build(config_settings) / "python" / "kestrel"
    files = {f"kestrel/{file.relative_to(package)}": file.read_bytes()
             for file in sorted(package.rglob("*"))
             if file.suffix in (".py", ".pyi") or file.name in ("py.typed", f"_core{SUFFIX}")}
    shared = f"kestrel-{_version()}.data/data/share/kestrel"
    for folder, pattern in ("models", "*"), ("scenarios", "*.yaml"):
        for file in sorted((ROOT / folder).rglob(pattern)):
            if file.is_file():
                files[f"{shared}/{file.relative_to(ROOT)}"] = file.read_bytes()
    return _write(wheel_directory, files)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    return _write(wheel_directory, {"kestrel.pth": f"{_build(config_settings) / 'python'}\n".encode()})


def _build(config_settings) -> Path:
    """The build folder, with the module for this Python."""
    build = ROOT / (config_settings or {}).get("build-dir", "build")
    cache = build / "CMakeCache.txt"
    if not cache.exists():
        _run("cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
             f"-DKESTREL_PYTHON={sys.executable}")
    else:
        python = re.search(r"^KESTREL_PYTHON:\w+=(.*)$", cache.read_text(), re.MULTILINE)
        ask = "import sysconfig; print(sysconfig.get_config_var('EXT_SUFFIX'))"
        if not python or subprocess.run([python[1], "-c", ask], capture_output=True, text=True).stdout.strip() != SUFFIX:
            _run("cmake", "-B", build, f"-DKESTREL_PYTHON={sys.executable}")
    _run("cmake", "--build", build, "--target", "python_package")
    return build


def _run(*command) -> None:
    subprocess.run([str(word) for word in command], check=True)


def _version() -> str:
    return re.search(r"project\(kestrel VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]


def _write(folder, files) -> str:
    tag = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    tag = f"{tag}-{tag}-{re.sub(r'[-.]', '_', sysconfig.get_platform())}"
    info = f"kestrel-{_version()}.dist-info"
    files = dict(files)
    files[f"{info}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: kestrel\nVersion: {_version()}\n"
        "Summary: Simulator for vision-guided flight\nLicense: Apache-2.0\n"
        f"Requires-Python: =={sys.version_info[0]}.{sys.version_info[1]}.*\nRequires-Dist: numpy\n"
        'Provides-Extra: campaign\nRequires-Dist: pandas; extra == "campaign"\n'
        'Provides-Extra: gym\nRequires-Dist: gymnasium; extra == "gym"\n').encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: kestrel\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    record = "".join(f"{name},sha256={_digest(content)},{len(content)}\n" for name, content in files.items())
    files[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    name = f"kestrel-{_version()}-{tag}.whl"
    with zipfile.ZipFile(os.path.join(folder, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, content in files.items():
            wheel.writestr(path, content)
    return name


def _digest(content: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
