"""Marks a header's // comments as documentation, for Doxygen alone.

The comment above #pragma once becomes the file's text; where it has columns, they are kept. A
comment above a declaration, or behind one, becomes that declaration's.
"""

import re
import sys

COMMENT = re.compile(r"^(\s*)//(?!/) ?(.*)$")
BEHIND = re.compile(r"^(.*[;,{)\w>=\"'\]}]\s*)// ?(.*)$")


def escaped(text):
    return re.sub(r"([\\@<>&#$%\"])", r"\\\1", text.replace("::", "\\::"))


def is_code(line):
    return bool(line.strip()) and not line.lstrip().startswith("//")


def main():
    lines = open(sys.argv[1], encoding="utf-8").read().splitlines()
    head = next((i for i, line in enumerate(lines) if not line.startswith("//")), len(lines))
    text = [line[3:].replace("*/", "* /") for line in lines[:head]]
    laid_out = any(re.search(r"^ |\S {2,}\S", line) for line in text)
    if laid_out:
        out = ["/** \\file", "\\verbatim", *text, "\\endverbatim */"]
    else:
        out = ["/** \\file", *map(escaped, text), "*/"]
    last_code = ";"  # what ends the last line of code
    private = False
    for line in lines[head:]:
        private = (private or line == " private:") and line != "};"
        if private:  # Doxygen's XML would have it
            out.append("")
            continue
        if line in ("namespace impedraw {", "}  // namespace impedraw"):
            out.append("")  # all of it is; names are shorter without
            continue
        comment, behind = COMMENT.match(line), BEHIND.match(line)
        if comment:
            # Within a declaration that goes on over lines Doxygen takes no comment.
            starts = last_code in ";{}:" or last_code == ","
            out.append(f"{comment[1]}{'///' if starts else '//'} {escaped(comment[2])}")
            continue
        if behind and behind[1].count('"') % 2 == 0:
            mark = "///<" if behind[1].rstrip()[-1] in ";," or "{}" in behind[1] else "//"
            out.append(f"{behind[1]}{mark} {escaped(behind[2])}")
            last_code = behind[1].rstrip()[-1]
            continue
        out.append(line)
        if is_code(line) and not line.startswith("#"):
            last_code = line.rstrip()[-1]
    sys.stdout.write("\n".join(out) + "\n")


main()
