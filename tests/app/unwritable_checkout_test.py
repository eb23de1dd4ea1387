"""A checkout that is built, but cannot be written by who runs it, runs as it is; one that is not built says so in one line.

A made-up checkout with the real ./impedraw and setup/prepare.sh; the program is a script that prints its arguments.
"""

import os
import shutil
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NOBODY = 65534


def checkout(folder, built):
    for name in ("setup", "cmake", "src", "web", "bench", "examples", "build/release/src/app", ".venv/bin"):
        (folder / name).mkdir(parents=True)
    for name in ("impedraw", "setup/prepare.sh", "apt-packages.txt", "requirements.txt", "CMakeLists.txt", "CMakePresets.json"):
        shutil.copy(ROOT / name, folder / name)
    program, python = folder / "build/release/src/app/impedraw", folder / ".venv/bin/python"
    for script in (program, python):
        script.write_text('#!/bin/sh\necho "ran $*"\n')
        script.chmod(0o755)
    if built:
        time.sleep(0.01)
        (folder / "build/release/.built-impedraw").touch()
    for path in [folder, *folder.rglob("*")]:
        if not path.is_symlink():
            path.chmod(0o555 if path.is_dir() or os.access(path, os.X_OK) else 0o444)


class UnwritableCheckout(unittest.TestCase):
    def run_in(self, built):
        with tempfile.TemporaryDirectory() as base:
            os.chmod(base, 0o755)
            folder = Path(base) / "impedraw"
            folder.mkdir()
            checkout(folder, built)
            other_user = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if os.geteuid() == 0 else {}
            ended = subprocess.run([folder / "impedraw", "draw", "--shape", "M"], capture_output=True, text=True, cwd="/", **other_user)
            for path in [folder, *folder.rglob("*")]:
                if path.is_dir() and not path.is_symlink():
                    path.chmod(0o755)
            return ended

    def test_built(self):
        ended = self.run_in(built=True)
        self.assertEqual((ended.returncode, ended.stdout, ended.stderr), (0, "ran draw --shape M\n", ""))

    def test_not_built(self):
        ended = self.run_in(built=False)
        self.assertEqual((ended.returncode, ended.stdout), (1, ""))
        self.assertIn("cannot be written", ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 2)


if __name__ == "__main__":
    unittest.main()
