#!/usr/bin/env python3
"""Makes dist/impedraw-VERSION-cp311-cp311-….whl and -cp312-abi3-….whl from a build, or dist/impedraw-VERSION.tar.gz from the tree. A wheel holds what the build's
install component `python` does; auditwheel adds the libraries of Debian. MuJoCo and Pinocchio are wheels that it depends on. Names,
versions and requirements are those of pyproject.toml.

build_wheel.py wheel ROOT BUILD DIST PYTHON_WITH_AUDITWHEEL
build_wheel.py sdist ROOT DIST                                 with a Python that has scikit-build-core
build_wheel.py check ROOT                                      pyproject.toml pins what requirements.txt does
build_wheel.py needs ROOT project|build-system                 this tree's lines, with hashes, of what pyproject.toml asks for there
"""

import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib
import zipfile

FOREIGN = ["libmujoco.so.*", "libpinocchio_*", "libconsole_bridge*", "liburdfdom*", "libboost_*", "libcoal*", "liboctomap*", "liboctomath*",
           "libassimp*", "libqhull*", "libtinyxml2*"]  # of cmeel's and MuJoCo's wheels: not copied


def version_of(root):
    return re.search(r"project\(impedraw VERSION ([\d.]+)", (root / "CMakeLists.txt").read_text()).group(1)


def check(root):
    """A wheel is compiled with the wheels of requirements.txt and asks for those of pyproject.toml."""
    def pins(lines):
        return dict(line.partition(" ")[0].lower().split("==") for line in lines if "==" in line and line[0] != "#")

    pinned = {}
    for name in ("requirements.txt", "setup/camera-requirements.txt", "setup/image-requirements.txt", "setup/sweep-requirements.txt"):
        pinned |= pins((root / name).read_text().splitlines())
    tools = pins((root / "setup/wheel-requirements.txt").read_text().splitlines())
    of = tomllib.loads((root / "pyproject.toml").read_text())
    lists = {"build-system.requires": of["build-system"]["requires"], "tool.impedraw.build": of["tool"]["impedraw"]["build"], "project.dependencies": of["project"]["dependencies"],
             **{f"project.optional-dependencies.{name}": needs for name, needs in of["project"]["optional-dependencies"].items()}}
    wrong = []
    for where, needs in lists.items():
        for name, version in pins(needs).items():
            expected = (tools | pinned).get(name)
            if version != expected:
                wrong.append(f"pyproject.toml: {where}: {name}=={version}; this tree's lists have {expected}")
        for need in needs:
            name, _, least = need.lower().partition(">=")
            if least and name in pinned and not (pinned[name] + ".").startswith(least + "."):
                wrong.append(f"pyproject.toml: {where}: {need}; this tree's lists have {pinned[name]}")
    compiled_with = {name for name in pinned if name.startswith("cmeel") or name in ("libcoal", "libpinocchio", "mujoco-core")}
    wrong += [f"pyproject.toml: project.dependencies: lacks {name}" for name in sorted(compiled_with - set(pins(lists["project.dependencies"])))]
    if wrong:
        raise SystemExit("\n".join(wrong))


def needs(root, table):
    """The lines of this tree's lists for what pyproject.toml asks for in that table, so that pip takes no other file for it."""
    of = tomllib.loads((root / "pyproject.toml").read_text())
    asked = of["build-system"]["requires"] + of["tool"]["impedraw"]["build"] if table == "build-system" else of["project"]["dependencies"]
    names = {re.split("[=>]", need)[0].lower() for need in asked}
    lists = ("requirements.txt", "setup/wheel-requirements.txt") if table == "build-system" else ("requirements.txt",)
    lines = [line for name in lists for line in (root / name).read_text().splitlines() if "==" in line and line[0] != "#"]
    # The backend's own needs stand in the tools' list.
    found = {line.partition("==")[0].lower(): line for line in lines}
    names |= {"packaging", "pathspec"} if table == "build-system" else set()
    return [found[name] for name in sorted(names)]


def metadata(root, requires_python):
    of = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    lines = ["Metadata-Version: 2.4", f"Name: {of['name']}", f"Version: {version_of(root)}", f"Summary: {of['description']}",
             f"License-Expression: {of['license']}", *[f"License-File: {name}" for name in of["license-files"]],
             f"Requires-Python: {requires_python}", *[f"Requires-Dist: {need}" for need in of["dependencies"]]]
    for name, needs in of["optional-dependencies"].items():
        lines += [f"Provides-Extra: {name}", *[f"Requires-Dist: {need}; extra == '{name}'" for need in needs]]
    lines += ["Description-Content-Type: text/markdown", "", (root / of["readme"]).read_text()]
    return "\n".join(lines)


def content(root, stage, extension):
    """Path in the wheel → file."""
    files = {str(file.relative_to(stage)): file for file in sorted(stage.rglob("*"))
             if file.is_file() and (file.suffix != ".so" or file.name == extension)}
    for name in ("LICENSE", "THIRD_PARTY.md"):
        files[f"impedraw-{version_of(root)}.dist-info/licenses/{name}"] = root / name
    return files


def pack(root, stage, folder, extension):
    """A wheel for the Python that the extension's name tells."""
    own = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    tag, requires = ("cp312-abi3", ">=3.12") if ".abi3." in extension else (f"{own}-{own}", f"=={sys.version_info[0]}.{sys.version_info[1]}.*")
    version = version_of(root)
    info = f"impedraw-{version}.dist-info"
    wheel = folder / f"impedraw-{version}-{tag}-linux_x86_64.whl"
    scripts = tomllib.loads((root / "pyproject.toml").read_text())["project"]["scripts"]
    texts = {f"{info}/METADATA": metadata(root, requires).encode(),
             f"{info}/entry_points.txt": "\n".join(["[console_scripts]", *(f"{name} = {what}" for name, what in scripts.items()), ""]).encode(),
             f"{info}/WHEEL": f"Wheel-Version: 1.0\nGenerator: impedraw\nRoot-Is-Purelib: false\nTag: {tag}-linux_x86_64\n".encode()}
    record = []
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as out:
        for name, data in [*((n, f.read_bytes()) for n, f in content(root, stage, extension).items()), *texts.items()]:
            entry = zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0))  # the same content gives the same wheel
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            out.writestr(entry, data, compresslevel=9)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{name},sha256={digest},{len(data)}")
        out.writestr(f"{info}/RECORD", "\n".join([*record, f"{info}/RECORD,,"]) + "\n")
    return wheel


def make_wheels(root, build, dist, tools):
    check(root)
    dist.mkdir(exist_ok=True)
    for old in dist.glob("impedraw-*.whl"):
        old.unlink()
    # Libraries that come with other wheels are found for the check alone.
    beside = [str(p) for p in (root / ".venv/lib").glob("python3*/site-packages/mujoco")]
    beside += [str(p) for p in (root / ".venv/lib").glob("python3*/site-packages/cmeel.prefix/lib")]
    environment = {**os.environ, "LD_LIBRARY_PATH": ":".join(beside), "PATH": f"{tools.parent}:{os.environ['PATH']}"}
    excluded = [word for pattern in FOREIGN for word in ("--exclude", pattern)]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run(["cmake", "--install", build, "--component", "python", "--prefix", folder / "stage"], check=True, stdout=subprocess.DEVNULL)
        for extension in sorted(file.name for file in (folder / "stage/impedraw").glob("_impedraw.*.so")):
            plain = pack(root, folder / "stage", folder, extension)
            subprocess.run([tools, "-m", "auditwheel", "repair", "--strip", "-z", "9", "--plat", "manylinux_2_36_x86_64", *excluded, "-w", dist, plain],
                           check=True, env=environment)
    return sorted(dist.glob("impedraw-*.whl"))


def make_sdist(root, dist):
    check(root)
    from scikit_build_core.build import build_sdist

    for need in ("build/web/page.html", "build/arm-meshes/iiwa14_pen"):
        if not (root / need).exists():
            raise SystemExit(f"{root / need} is not there: ./impedraw fetches and makes it when it builds, which needs the network")
    for old in dist.glob("impedraw-*.tar.gz"):
        old.unlink()
    os.chdir(root)
    return [dist / build_sdist(str(dist))]


def main():
    what, *places = sys.argv[1:]
    if what == "needs":
        print("\n".join(needs(pathlib.Path(places[0]), places[1])))
        return
    places = [pathlib.Path(place) for place in places]
    if what == "check":
        check(*places)
        return
    for made in {"wheel": make_wheels, "sdist": make_sdist}[what](*places):
        print(f"made {made} {made.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
