"""Writes the hashes of every wheel into the lists that pip installs from.

python3 setup/hashes.py [LIST …]    by default all lists; NAME==VERSION stands in each line, and its hashes are written anew

A hash is that of the file that pip takes for one of PYTHONS on x86-64; the package index tells it, and pip refuses any other file.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

from pip._vendor.packaging.requirements import Requirement

ROOT = pathlib.Path(__file__).resolve().parents[1]
LISTS = ["requirements.txt", "docs/requirements.txt", "setup/arm-meshes.txt", "setup/sweep-requirements.txt", "setup/camera-requirements.txt", "setup/image-requirements.txt", "setup/vpype-requirements.txt", "setup/format-requirements.txt",
         "setup/wheel-requirements.txt", "tests/python/requirements.txt", "tests/foreign/drake/requirements.txt", "tests/foreign/franka/requirements.txt"]
PYTHONS = ["3.11", "3.13", "3.14"]  # of Debian 12, 13 and forky
FOR_ONE = ("setup/arm-meshes.txt", "tests/foreign/")  # data, and simulators that have no other wheels
PLATFORMS = ["manylinux2014_x86_64", *(f"manylinux_2_{minor}_x86_64" for minor in range(17, 37))]


def plain(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def hashes(lines, python):
    """Name → hash of the file that pip takes for that version of CPython."""
    # pip would read markers as those of the CPython that runs it.
    wanted = [line for line in lines if "==" in line and not line.startswith("#")]
    wanted = [str(r).partition(";")[0] for r in map(Requirement, wanted) if r.marker is None or r.marker.evaluate({"python_version": python})]
    with tempfile.TemporaryDirectory() as folder:
        bare = pathlib.Path(folder) / "bare.txt"
        bare.write_text("\n".join(wanted) + "\n")
        report = subprocess.run(
            [sys.executable, "-m", "pip", "install", "--dry-run", "--ignore-installed", "--no-deps", "--only-binary", ":all:", "--quiet", "--target", folder,
             "--python-version", python, *(word for platform in PLATFORMS for word in ("--platform", platform)), "--report", "-", "-r", bare],
            check=True, stdout=subprocess.PIPE, text=True).stdout  # fmt: skip
    return {plain(item["metadata"]["name"]): item["download_info"]["archive_info"]["hashes"]["sha256"] for item in json.loads(report)["install"]}


def main():
    for name in sys.argv[1:] or LISTS:
        file = ROOT / name
        lines = [line.partition(" --hash=")[0] for line in file.read_text().splitlines()]
        found = [hashes(lines, python) for python in (PYTHONS[:1] if name.startswith(FOR_ONE) else PYTHONS)]
        for i, line in enumerate(lines):
            if "==" in line and not line.startswith("#"):
                own = dict.fromkeys(of[key] for of in found if (key := plain(line.partition("==")[0])) in of)  # each once, in order
                lines[i] = " ".join([line, *(f"--hash=sha256:{value}" for value in own)])
        file.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
