#!/usr/bin/env python3
"""Checks that the relative links of all Markdown files lead to files that exist, and to headings in them, and that every
document is a chapter of the manual.

Code is left out. Headings are named as GitHub and mdBook name them. Needs nothing but Python and git.

    scripts/links.py [FILE...]
"""

import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(__file__).resolve().parent.parent
# Parts of one page, whose links lead to headings of the whole.
PARTS = ROOT / "docs/study"
# Chapters of the manual that scripts/book.py moves to the root, and what it adds to them.
BOOK = ROOT / "book"
ADDED = re.compile(r"(gallery\.md|libraries\.md|docs/words\.md|api/.*)$")
LINK = re.compile(r"!?\[(?:[^\]\[]|\[[^\]]*\])*\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)")


def without_code(text: str) -> str:
    """The text with code as blanks, its lines in their places."""
    blank = lambda match: re.sub(r"[^\n]", " ", match.group())
    text = re.sub(r"^(```+|~~~+).*?^\1[^\n]*$", blank, text, flags=re.M | re.S)
    return re.sub(r"(`+)(?!`).+?(?<!`)\1(?!`)", blank, text)


def anchors(path: Path) -> set[str]:
    """Names of all headings of a file."""
    found: dict[str, int] = {}
    names = set()
    text = re.sub(r"^(```+|~~~+).*?^\1[^\n]*$", "", path.read_text(encoding="utf-8"), flags=re.M | re.S)
    for title in re.findall(r"^#{1,6}\s+(.*?)\s*#*$", text, flags=re.M):
        title = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title)
        name = re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-")
        count = found.get(name, 0)
        found[name] = count + 1
        names.add(name if count == 0 else f"{name}-{count}")
    return names


def broken(path: Path) -> list[str]:
    """Links of a file that lead nowhere, each with its line."""
    text = without_code(path.read_text(encoding="utf-8"))
    mistakes = []
    for match in LINK.finditer(text):
        link = match.group(1)
        if re.match(r"[a-z][a-z0-9+.-]*:", link):
            continue
        file, _, anchor = link.partition("#")
        folder = ROOT if path.parent == BOOK else path.parent
        target = (folder / unquote(file)).resolve() if file else path
        if folder != path.parent and ADDED.match(file):
            continue
        line = text.count("\n", 0, match.start()) + 1
        if not target.exists():
            mistakes.append(f"{path.relative_to(ROOT)}:{line}: {link}: there is no such file")
        elif anchor and path.parent == PARTS and path.name != "README.md":
            continue
        elif anchor and target.suffix == ".md" and anchor not in anchors(target):
            mistakes.append(f"{path.relative_to(ROOT)}:{line}: {link}: there is no such heading")
    return mistakes


def missing_chapters(files: list[Path]) -> list[str]:
    """Documents that are no chapters of the manual."""
    summary = (BOOK / "SUMMARY.md").read_text(encoding="utf-8")
    names = [str(path.relative_to(ROOT)) for path in files if path.parent in (ROOT / "docs", ROOT / "docs/how-to")]
    return [f"{name}: it is not in book/SUMMARY.md" for name in names if f"({name})" not in summary]


def main() -> int:
    command = ["git", "ls-files", "-co", "--exclude-standard", "*.md"]
    tracked = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    files = [Path(name).resolve() for name in sys.argv[1:]] or [ROOT / name for name in tracked]
    mistakes = [mistake for file in files if file.exists() for mistake in broken(file)] + missing_chapters(files)
    print("\n".join(mistakes), end="\n" if mistakes else "")
    print(f"{len(files)} files, {len(mistakes)} mistakes")
    return 1 if mistakes else 0


if __name__ == "__main__":
    sys.exit(main())
