"""Checks the C++ sources that git tracks: clang-format 14 of build/format-venv changes nothing, and no line is
wider than 100 columns (clang-format leaves raw strings and comments alone). In src/ no source has more than 500 lines,
and no function more than 120. No bullet of the changelog has more than 15 words, and no comment of src/ opens with a
word that leaves it without a subject.

./check --format installs that tool and calls this.

usage: check_format.py [--fix]
"""
import pathlib
import re
import subprocess
import sys
import unicodedata

COLUMNS = 100
SOURCE = 500  # lines
FUNCTION = 120
BULLET = 15  # words
NO_SUBJECT = re.compile(r"\s*// (Of|That|What|Whether|How|Where|Which|Why)\b")
TOOL = pathlib.Path(__file__).resolve().parents[1] / "build/format-venv/bin/clang-format"


def width(line: str) -> int:
    """Display columns: combining marks take none, East Asian wide characters two."""
    return sum(0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1
               for c in line)


def long_functions(lines: list[str]) -> list[tuple[int, int]]:
    """First line and length of each function that is too long. The text is as clang-format leaves it: a function ends with
    a brace alone, as far in as its first line; classes and namespaces have something behind theirs."""
    found = []
    for indent in ("", "  "):
        begin = 0
        for number, line in enumerate(lines, 1):
            if line == indent + "}":
                if number - begin >= FUNCTION:
                    found.append((begin, number - begin + 1))
            elif re.match(indent + r"[A-Za-z~]", line):
                begin = number
    return found


def main() -> int:
    files = subprocess.run(["git", "ls-files", "-z", "*.cc", "*.h"], check=True, capture_output=True,
                           text=True).stdout.split("\0")[:-1]
    files = [f for f in files if pathlib.Path(f).exists()]
    if "--fix" in sys.argv:
        subprocess.run([TOOL, "-i", *files], check=True)
    failed = subprocess.run([TOOL, "--dry-run", "-Werror", *files]).returncode != 0
    for file in files:
        lines = pathlib.Path(file).read_text().splitlines()
        if file.startswith("src/"):
            if len(lines) > SOURCE:
                print(f"{file}: {len(lines)} lines, at most {SOURCE} are allowed")
                failed = True
            for begin, length in long_functions(lines):
                print(f"{file}:{begin}: a function of {length} lines, at most {FUNCTION} are allowed")
                failed = True
        for number, line in enumerate(lines, 1):
            if file.startswith("src/") and NO_SUBJECT.match(line) and not lines[number - 2].lstrip().startswith("//"):
                print(f"{file}:{number}: the comment has no subject: {line.strip()}")
                failed = True
            if width(line) > COLUMNS:
                print(f"{file}:{number}: {width(line)} columns, at most {COLUMNS} are allowed")
                failed = True
    for number, line in enumerate(pathlib.Path("CHANGELOG.md").read_text().splitlines(), 1):
        if line.startswith("- ") and len(line.split()) > 1 + BULLET:
            print(f"CHANGELOG.md:{number}: {len(line.split()) - 1} words, at most {BULLET} are allowed")
            failed = True
    if failed:
        print("format: ./check --fix-format rewrites what clang-format can", file=sys.stderr)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
