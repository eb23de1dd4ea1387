"""Counts what ctest ran: every GoogleTest case by itself, any other test as one. Prints the slowest programs and the closing line.

usage: count_tests.py FOLDER    with ctest.xml (ctest --output-junit) and GoogleTest's PROGRAM.json files
Exit code 1 when a test failed or none ran.
"""
import json
import pathlib
import sys
import xml.etree.ElementTree as xml


def cases(report: pathlib.Path) -> tuple[int, int, int]:
    """Passed, failed, skipped cases of one GoogleTest program; cases that a filter left out count nowhere."""
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


def main(folder: pathlib.Path) -> int:
    total = [0, 0, 0]
    times = []
    outcomes = xml.parse(folder / "ctest.xml").getroot().findall("testcase") if (folder / "ctest.xml").exists() else []
    for test in outcomes:
        name, status = test.get("name"), test.get("status")
        times.append((float(test.get("time") or 0), name))
        good = status == "run"
        report = folder / f"{name}.json"
        try:
            counts = list(cases(report))
        except (OSError, ValueError, KeyError):  # no GoogleTest program, or one that died before it wrote its report
            counts = [int(good), int(status == "fail"), int(status not in ("run", "fail"))]
        if status == "fail" and counts[1] == 0:  # every case passed, but the program crashed on its way out or hung
            counts[1] = 1
        total = [a + b for a, b in zip(total, counts)]
    for seconds, name in sorted(times, reverse=True)[:5]:
        print(f"{seconds:8.1f} s  {name}")
    passed, failed, skipped = total
    print(f"\n{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
    return 0 if passed and not failed else 1


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
