"""The command of the wheels, in an empty venv for each CPython that is here: it needs no source tree, no compiler, no network and no root, and
prints what the program does.

wheel_command.py PROGRAM WHEEL…     exit code 1 if something differs. Fetches the wheels' own needs from pip's index.
"""

import glob
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

WALL = ("step_time", "real_time_factor", "report", "simulated in")  # of the machine, or of the folder
NEEDS_TREE = ("film", "docs", "figures", "bench", "robustness", "reach", "wheel")


def interpreters():
    """Version → the first interpreter of that version, of the system or of pyenv."""
    names = [f"python3.{minor}" for minor in range(11, 16)]
    files = [shutil.which(name) for name in names]
    files += sorted(glob.glob(os.path.expanduser("~/.pyenv/versions/3.1[1-9]*/bin/python3")))
    found = {}
    for file in filter(None, files):
        asked = subprocess.run([file, "-c", "import sys, venv, ensurepip; print('%d.%d' % sys.version_info[:2])"], capture_output=True, text=True)
        if asked.returncode == 0:
            found.setdefault(asked.stdout.strip(), file)
    return found


def figures(text):
    return [line for line in text.splitlines() if not any(word in line for word in WALL)]


class Command:
    def __init__(self, command, folder):
        self.command, self.folder, self.wrong = command, folder, 0
        self.environment = {"HOME": str(folder), "PATH": str(pathlib.Path(command[-1]).parent), "LANG": "C.UTF-8"}

    def run(self, *arguments, code=0):
        done = subprocess.run([*self.command, *arguments], cwd=self.folder, env=self.environment, capture_output=True, text=True)
        text = done.stdout + done.stderr
        self.check(done.returncode == code, f"{arguments}: exit code {done.returncode}, not {code}: {text[-400:]}")
        self.check("./impedraw" not in text or arguments[0] in NEEDS_TREE, f"{arguments}: names ./impedraw: {text[-400:]}")
        return text

    def check(self, good, message):
        if not good:
            self.wrong += 1
            print(f"FAILED: {message}")


def try_command(command, folder, version, expected):
    it = Command(command, folder)
    it.check(re.fullmatch(r"impedraw \d+\.\d+\.\d+\n", it.run("--version")), "--version")
    drawn = it.run("draw", "--out", "sine")
    it.check(figures(drawn) == expected, f"draw prints {figures(drawn)}, the program {expected}")
    it.check((folder / "sine/report.html").stat().st_size > 100_000, "report.html")
    it.run("report", "sine")
    it.run("draw", "scenarios/bowl-m.yaml", "--out", "m", "--set", "path.draw_speed=0.1")
    it.run("compare", "sine", "m", "--out", "both")
    it.run("plan", "--svg", "artwork/koi.svg", "--json")
    it.check("strokes" in it.run("inspect", "artwork/koi.svg"), "inspect")
    it.run("settings")
    it.run("arm", "make-urdf", "--arm", "fr3")
    it.check("Nothing is missing" in it.run("doctor"), "doctor")
    it.check("see impedraw draw --help" in it.run("draw", "--no-such", code=2), "a wrong option")
    it.run("draw", "artwork/no-such.svg", code=2)
    for name in NEEDS_TREE:
        it.check("needs" in it.run(name, code=2), name)
    try:
        import_needs = subprocess.run([pathlib.Path(command[-1]).parent / "python", "-c", "import ray, pyarrow"], capture_output=True).returncode
    except OSError:
        import_needs = 1
    if import_needs:
        it.check("impedraw[sweep]" in it.run("sweep", "x.yaml", code=2), "sweep without its needs")
    # Ctrl-C lifts the pen, as in the program.
    child = subprocess.Popen([*command, "draw", "scenarios/bowl-sine10.yaml", "--out", "stopped"], cwd=folder, env=it.environment,
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    until = time.monotonic() + 120
    while not (folder / "stopped/run.h5").exists() and time.monotonic() < until and child.poll() is None:
        time.sleep(0.05)
    child.send_signal(signal.SIGINT)
    told, _ = child.communicate(timeout=120)
    it.check(child.returncode == 130 and "Traceback" not in told, f"ctrl-C: exit code {child.returncode}: {told[-400:]}")
    print(f"CPython {version}: {'passed' if not it.wrong else f'{it.wrong} failed'}")
    return it.wrong


def main(program, *wheels):
    wrong = 0
    with tempfile.TemporaryDirectory() as name:
        top = pathlib.Path(name)
        os.chmod(top, 0o755)
        # Without a network, as an ordinary user who owns a home folder alone, where root may become one.
        offline, nobody = [shutil.which("unshare"), "-n"], [shutil.which("setpriv"), "--reuid=65534", "--regid=65534", "--clear-groups", "--"]
        root = os.geteuid() == 0 and offline[0] and nobody[0]
        drawn = subprocess.run([program, "draw", "--out", str(top / "program")], cwd=top, check=True, capture_output=True, text=True).stdout
        tried = 0
        for version, python in interpreters().items():
            fits = [w for w in wheels if (f"-cp{version.replace('.', '')}-" in w if version == "3.11" else "-cp312-abi3-" in w)]
            if not fits:
                continue
            home, venv = top / version, top / f"venv-{version}"
            subprocess.run([python, "-m", "venv", venv], check=True)
            subprocess.run([venv / "bin/python", "-m", "pip", "install", "--disable-pip-version-check", "--no-input", "-q", *fits], check=True)
            home.mkdir()
            as_user = []
            if root and subprocess.run([*offline, "true"], capture_output=True).returncode == 0:
                as_user = offline
            # Not where the interpreter stands in root's own folder.
            if root and subprocess.run([*nobody, venv / "bin/python", "-c", ""], capture_output=True).returncode == 0:
                os.chown(home, 65534, 65534)
                as_user = [*as_user, *nobody]
            wrong += try_command([*as_user, str(venv / "bin/impedraw")], home, version, figures(drawn))
            tried += 1
    return int(wrong > 0 or tried == 0)


if __name__ == "__main__":
    sys.exit(main(*(os.path.abspath(file) for file in sys.argv[1:])))
