"""What is fetched is named by its hash: wheels, actions and images."""

import re
import subprocess
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def tracked(*patterns):
    listed = subprocess.run(["git", "ls-files", "-z", *patterns], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [ROOT / name for name in listed.split("\0") if name and (ROOT / name).is_file()]


class Pins(unittest.TestCase):
    def test_every_wheel_of_every_list_has_its_version_and_hashes(self):
        lists = [*tracked("*requirements.txt"), ROOT / "setup/arm-meshes.txt"]
        self.assertGreaterEqual(len(lists), 8)
        for file in lists:
            for line in file.read_text().splitlines():
                if line and not line.startswith("#"):
                    self.assertRegex(line, r"^[\w.-]+==[\w.]+( ; python_version < \"[\d.]+\")?( --hash=sha256:[0-9a-f]{64})+$", file)

    def test_pip_is_called_with_hashes_or_without_an_index(self):
        calls = 0
        for file in tracked("impedraw", "check", ".ci/*", "*.sh", "Dockerfile", ".github/*"):
            text = re.sub(r"^\s*#.*", "", file.read_text(), flags=re.MULTILINE).replace("\\\n", " ")
            for line in text.splitlines():
                if re.search(r"pip\"? (install|download)\b", line):
                    calls += 1
                    self.assertTrue("--require-hashes" in line or "--no-index" in line, f"{file}: {line}")
        self.assertGreaterEqual(calls, 8)

    def test_the_version_is_that_of_cmake_everywhere(self):
        version = re.search(r"^project\(impedraw VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), flags=re.MULTILINE)[1]
        for file, pattern in {
            "CITATION.cff": r"^version: (.*)$",
            "packaging/conda/recipe.yaml": r"^  version: ([\d.]+)$",
            "examples/04_ros2_control/package.xml": r"<version>(.*)</version>",
        }.items():
            self.assertEqual(re.search(pattern, (ROOT / file).read_text(), flags=re.MULTILINE)[1], version, file)

    def test_actions_and_images_are_pinned_by_digest(self):
        named = 0
        for file in tracked("Dockerfile", ".github/workflows/*", ".devcontainer/*"):
            for what in re.findall(r'^\s*(?:FROM|- uses:|container:|"?image"?:) *[\["]?(?!\${{ matrix.image }})([^\s\]",]+)', file.read_text(), flags=re.MULTILINE):
                named += 1
                self.assertRegex(what, r"@(sha256:[0-9a-f]{64}|[0-9a-f]{40})$", file)
        self.assertEqual(named, 17)


if __name__ == "__main__":
    unittest.main()
