#!/usr/bin/env python3
"""Packs dist/impedraw-VERSION-cp3XX-….whl from a build: the package's Python files, the extension that is linked for wheels, its
stubs, and the data that it reads. auditwheel then adds the libraries of Debian. MuJoCo and Pinocchio are wheels that it depends on.

build_wheel.py ROOT BUILD DIST PYTHON_WITH_AUDITWHEEL
"""

import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import zipfile

NEEDS = ["mujoco", "mujoco-core", "libpinocchio"]  # wheels whose libraries stand beside the package
FOREIGN = ["libmujoco.so.*", "libpinocchio_*", "libconsole_bridge*", "liburdfdom*", "libboost_*", "libcoal*", "liboctomap*", "liboctomath*",
           "libassimp*", "libqhull*", "libtinyxml2*"]  # of cmeel's and MuJoCo's wheels: not copied
DATA = ["models/iiwa14_pen.urdf", "models/arms/*.urdf", "docs/scenario.schema.json", "scenarios/*.yaml", "artwork/*.svg", "src/planning/wrap/flatten_patch.py", "build/arm-meshes/*/*"]
FONTS = pathlib.Path("/usr/share/hershey-fonts")


def version_of(root):
    return re.search(r"project\(impedraw VERSION ([\d.]+)", (root / "CMakeLists.txt").read_text()).group(1)


def requirements(root):
    pinned = dict(line.split("==") for line in (root / "requirements.txt").read_text().split("\n") if "==" in line and line[0] != "#")
    cmeel = [name for name in pinned if name.startswith("cmeel") or name == "libcoal"]
    needs = [f"numpy>={pinned['numpy'].rsplit('.', 1)[0]}"]
    needs += [f"{name}=={pinned[name]}" for name in ["mujoco-core", "libpinocchio", *cmeel]]
    return needs, pinned


def metadata(root):
    needs, pinned = requirements(root)
    extras = {"log": [f"h5py>={pinned['h5py'].rsplit('.', 1)[0]}"], "table": ["pandas>=2"], "gym": ["gymnasium>=1"],
              "sweep": [line for line in (root / "setup/sweep-requirements.txt").read_text().split("\n")
                        if line.partition("==")[0].lower() in ("ray", "pyarrow", "optuna", "pyyaml")],
              "wrap": [f"libigl=={pinned['libigl']}", f"scipy=={pinned['scipy']}"]}
    lines = ["Metadata-Version: 2.1", "Name: impedraw", f"Version: {version_of(root)}",
             "Summary: A pen on a robot arm draws on unknown curved surfaces under operational-space impedance control",
             "License: Apache-2.0", f"Requires-Python: =={sys.version_info[0]}.{sys.version_info[1]}.*",
             *[f"Requires-Dist: {n}" for n in [*needs, *extras["log"]]]]
    for name, of in extras.items():
        lines += [f"Provides-Extra: {name}", *[f"Requires-Dist: {n}; extra == '{name}'" for n in of]]
    lines += ["Description-Content-Type: text/markdown", "", (root / "python/README.md").read_text()]
    return "\n".join(lines)


def content(root, build):
    """Path in the wheel → file."""
    files = {}
    for file in sorted((root / "python/impedraw").rglob("*")):
        if file.is_file() and "__pycache__" not in file.parts:
            files[f"impedraw/{file.relative_to(root / 'python/impedraw')}"] = file
    for file in (build / "python/wheel").glob("_impedraw*.so"):
        files[f"impedraw/{file.name}"] = file
    files["impedraw/_impedraw.pyi"] = build / "python/impedraw/_impedraw.pyi"
    for pattern in DATA:
        for file in sorted(root.glob(pattern)):
            files[f"impedraw/data/{file.relative_to(root)}"] = file
    for file in sorted(FONTS.glob("*.jhf")):
        files[f"impedraw/data/hershey-fonts/{file.name}"] = file
    for name in ("LICENSE", "THIRD_PARTY.md"):
        files[f"impedraw-{version_of(root)}.dist-info/{name}"] = root / name
    copyright_of_fonts = pathlib.Path("/usr/share/doc/hershey-fonts-data/copyright")
    if copyright_of_fonts.is_file():
        files["impedraw/data/hershey-fonts/copyright"] = copyright_of_fonts
    return files


def pack(root, build, folder):
    tag = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    version = version_of(root)
    info = f"impedraw-{version}.dist-info"
    wheel = folder / f"impedraw-{version}-{tag}-{tag}-linux_x86_64.whl"
    texts = {f"{info}/METADATA": metadata(root).encode(),
             f"{info}/WHEEL": f"Wheel-Version: 1.0\nGenerator: impedraw\nRoot-Is-Purelib: false\nTag: {tag}-{tag}-linux_x86_64\n".encode()}
    record = []
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as out:
        for name, data in [*((n, f.read_bytes()) for n, f in content(root, build).items()), *texts.items()]:
            entry = zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0))  # the same content gives the same wheel
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            out.writestr(entry, data, compresslevel=9)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{name},sha256={digest},{len(data)}")
        out.writestr(f"{info}/RECORD", "\n".join([*record, f"{info}/RECORD,,"]) + "\n")
    return wheel


def main():
    root, build, dist = (pathlib.Path(a) for a in sys.argv[1:4])
    tools = pathlib.Path(sys.argv[4])
    with tempfile.TemporaryDirectory() as folder:
        plain = pack(root, build, pathlib.Path(folder))
        dist.mkdir(exist_ok=True)
        for old in dist.glob("impedraw-*.whl"):
            old.unlink()
        # Libraries that come with other wheels are found for the check alone.
        beside = [str(p) for p in (root / ".venv/lib").glob("python3*/site-packages/mujoco")]
        beside += [str(p) for p in (root / ".venv/lib").glob("python3*/site-packages/cmeel.prefix/lib")]
        environment = {**os.environ, "LD_LIBRARY_PATH": ":".join(beside), "PATH": f"{tools.parent}:{os.environ['PATH']}"}
        excluded = [word for pattern in FOREIGN for word in ("--exclude", pattern)]
        subprocess.run([tools, "-m", "auditwheel", "repair", "--strip", "-z", "9", "--plat", "manylinux_2_36_x86_64", *excluded, "-w", dist, plain],
                       check=True, env=environment)
    made = next(dist.glob("impedraw-*.whl"))
    print(f"{made} {made.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
