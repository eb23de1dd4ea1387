"""Writes the hash of every wheel into the lists that pip installs from.

python3 setup/hashes.py [LIST …]    by default all lists; NAME==VERSION stands in each line, and its hash is written anew

A hash is that of the file that pip takes for CPython 3.11 on x86-64; the package index tells it, and pip refuses any other file.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
LISTS = ["requirements.txt", "docs/requirements.txt", "setup/arm-meshes.txt", "setup/sweep-requirements.txt", "setup/wheel-requirements.txt",
         "tests/python/requirements.txt", "tests/foreign/drake/requirements.txt", "tests/foreign/franka/requirements.txt"]
PLATFORMS = ["manylinux2014_x86_64", *(f"manylinux_2_{minor}_x86_64" for minor in range(17, 37))]


def plain(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def main():
    for file in (ROOT / name for name in sys.argv[1:] or LISTS):
        lines = [line.partition(" --hash=")[0] for line in file.read_text().splitlines()]
        with tempfile.TemporaryDirectory() as folder:
            bare = pathlib.Path(folder) / "bare.txt"
            bare.write_text("\n".join(lines) + "\n")
            report = subprocess.run(
                [sys.executable, "-m", "pip", "install", "--dry-run", "--ignore-installed", "--no-deps", "--only-binary", ":all:", "--quiet", "--target", folder,
                 "--python-version", "3.11", *(word for platform in PLATFORMS for word in ("--platform", platform)), "--report", "-", "-r", bare],
                check=True, stdout=subprocess.PIPE, text=True).stdout  # fmt: skip
        hashes = {plain(item["metadata"]["name"]): item["download_info"]["archive_info"]["hashes"]["sha256"] for item in json.loads(report)["install"]}
        for i, line in enumerate(lines):
            if "==" in line and not line.startswith("#"):
                lines[i] = f"{line} --hash=sha256:{hashes[plain(line.partition('==')[0])]}"
        file.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
