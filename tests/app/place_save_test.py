"""The page's Save of areas that were marked: scenario and SVG have names of their own, whatever --save says, and leave the artwork alone."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import urllib.request

PROGRAM = pathlib.Path(os.environ.get("IMPEDRAW_PROGRAM", "build/release/src/app/impedraw")).resolve()
ART = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><path d="M1 1H8" stroke="black"/></svg>'
AREAS = [[0.58, -0.02, 0.62, -0.02, 0.62, 0.02]]


class PlaceSave(unittest.TestCase):
    def saved(self, folder, save):
        art = folder / "x.svg"
        if save != "x.svg":
            art.write_text(ART)
        place = [PROGRAM, "place", "--headless", "--set", "canvas.kind=plane", "--save", save]
        run = subprocess.Popen(place, cwd=folder, stdout=subprocess.PIPE, text=True)
        try:
            address = re.search(r"http://\S+", run.stdout.readline()).group()
            question = json.dumps({"areas": AREAS, "overwrite": True}).encode()
            where, _, token = address.partition("?")
            asked = urllib.request.Request(f"{where.rstrip('/')}/save{'?' + token if token else ''}", question)
            with urllib.request.urlopen(asked, timeout=60) as answer:
                file = pathlib.Path(json.load(answer)["file"])
        finally:
            run.terminate()
            run.communicate(timeout=60)
        if save != "x.svg":
            self.assertEqual(art.read_text(), ART)
        return file

    def test_scenario_and_areas_are_two_files(self):
        for save in ("x.yaml", "x.svg", "x", "x.areas.svg"):
            with self.subTest(save), tempfile.TemporaryDirectory() as scratch:
                file = self.saved(pathlib.Path(scratch), save)
                self.assertEqual(file.name, save)
                region = pathlib.Path(re.search(r"region: \"?([^\"\s]+)", file.read_text()).group(1))
                self.assertNotEqual(region, file)
                self.assertIn("<svg", region.read_text())


if __name__ == "__main__":
    sys.exit(unittest.main())
