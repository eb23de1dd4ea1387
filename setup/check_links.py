"""Checks that links to files in pages outside the documentation site lead to existing files.

Sphinx checks the links between the pages of docs itself; README.md and the like are not among them.
"""

import re
import sys
from pathlib import Path

root = Path(__file__).resolve().parent.parent
pages = [*root.glob("*.md"), *root.glob("examples/*.md")]

dead = []
for page in pages:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        path = target.split("#")[0]
        if path and "://" not in path and not path.startswith("mailto:") and not (page.parent / path).exists():
            dead.append(f"{page.relative_to(root)}: {target} leads nowhere")
if dead:
    sys.exit("\n".join(f"impedraw: {line}" for line in dead))
