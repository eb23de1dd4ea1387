"""Counts the results of ./check: each GoogleTest case, and any other test or part as one. Prints the
slowest programs, the time of each part, and the closing line.

usage: count_tests.py FOLDER PART…    FOLDER/PART has the file part (exit code, seconds) and, of a part with tests,
                                      ctest.xml (ctest --output-junit) and GoogleTest's PROGRAM.json files
Exit code 1 when a test failed or none ran.
"""
import json
import pathlib
import sys
import xml.etree.ElementTree as xml


def cases(report: pathlib.Path) -> tuple[int, int, int]:
    """Passed, failed and skipped cases of one GoogleTest program. Cases that a filter excludes do not count."""
    passed = failed = skipped = 0
    for suite in json.loads(report.read_text())["testsuites"]:
        for case in suite["testsuite"]:
            if case["status"] != "RUN":
                continue
            if case.get("failures"):
                failed += 1
            elif case["result"] == "SKIPPED":
                skipped += 1
            else:
                passed += 1
    return passed, failed, skipped


def outcome(folder: pathlib.Path, test: xml.Element) -> list[int]:
    """Passed, failed and skipped cases of one entry in ctest's report."""
    status = test.get("status")
    good = status == "run"
    try:
        counts = list(cases(folder / f"{test.get('name')}.json"))
    except (OSError, ValueError, KeyError):  # not a GoogleTest program, or it crashed before it wrote its report
        counts = [int(good), int(status == "fail"), int(status not in ("run", "fail"))]
    if status == "fail" and counts[1] == 0:  # every case passed, but the program hung or crashed at exit
        counts[1] = 1
    return counts


def main(folder: pathlib.Path, parts: list[str]) -> int:
    total = [0, 0, 0]
    times = []
    lines = []
    for part in parts:
        here = folder / part
        status, seconds = map(int, (here / "part").read_text().split())
        counts = [0, 0, 0]
        if (here / "ctest.xml").exists():
            for test in xml.parse(here / "ctest.xml").getroot().findall("testcase"):
                times.append((float(test.get("time") or 0), f"{part}: {test.get('name')}"))
                counts = [a + b for a, b in zip(counts, outcome(here, test))]
        if status and not counts[1]:  # no test failed, but the part did: the build failed, or no test ran
            counts[1] = 1
        elif not status and not any(counts):
            counts[0] = 1
        total = [a + b for a, b in zip(total, counts)]
        lines.append(f"{seconds:8d} s  {part}: {counts[0]} passed, {counts[1]} failed")
    print("the slowest test programs:")
    for seconds, name in sorted(times, reverse=True)[:5]:
        print(f"{seconds:8.1f} s  {name}")
    print("the parts, with installing and building:", *lines, sep="\n")
    passed, failed, skipped = total
    print(f"\n{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
    return 0 if passed and not failed else 1


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]), sys.argv[2:]))
