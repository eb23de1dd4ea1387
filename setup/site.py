#!/usr/bin/env python3
"""Adds a version's documentation to a site of all versions (.github/workflows/site.yml).

site.py HTML SITE NAME    copies HTML to SITE/NAME; NAME is a release, as 0.1.0, or main. SITE/versions.json lists
                          the releases, newest first, then main; SITE/index.html leads to the first of them.
"""

import json
import pathlib
import re
import shutil
import sys


def versions(site):
    names = [folder.name for folder in site.iterdir() if (folder / "index.html").is_file()]
    releases = [name for name in names if re.fullmatch(r"\d+(\.\d+)+", name)]
    releases.sort(key=lambda name: [int(part) for part in name.split(".")], reverse=True)
    return releases + [name for name in names if name == "main"]


def main(html, site, name):
    html, site = pathlib.Path(html), pathlib.Path(site)
    if not re.fullmatch(r"main|\d+(\.\d+)+", name):
        raise SystemExit(f"site.py: '{name}' is no version; valid are main and numbers such as 0.1.0")
    if not (html / "index.html").is_file():
        raise SystemExit(f"site.py: {html} has no index.html: ./impedraw docs makes it")
    site.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(site / name, ignore_errors=True)
    shutil.copytree(html, site / name)
    all_of_them = versions(site)
    (site / "versions.json").write_text(json.dumps(all_of_them) + "\n")
    (site / "index.html").write_text(f'<!doctype html><meta http-equiv="refresh" content="0; url={all_of_them[0]}/"><a href="{all_of_them[0]}/">impedraw</a>\n')
    (site / ".nojekyll").touch()  # folders such as _static are served as they are


if __name__ == "__main__":
    if len(sys.argv) != 4:
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
