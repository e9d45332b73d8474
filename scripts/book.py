#!/usr/bin/env python3
"""Prepares the chapters of the manual, and checks the site that mdBook makes of them; see scripts/book.sh.

The chapters are the documents of the repository, in the same folders, so that their links hold. Links to anything else
lead to the repository on the web. The gallery, with pictures and sources, and the list of all words are added.
"""

import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import links

ROOT = links.ROOT
SOURCE = ROOT / "target/book/src"
SITE = ROOT / "target/book/html"
REPOSITORY = "https://github.com/pathmarch/pathmarch/blob/main/"
# What chapters may link to.
SUFFIXES = {".md", ".kdl", ".jpg", ".png", ".svg", ".csv"}


def tracked() -> list[Path]:
    command = ["git", "ls-files", "-co", "--exclude-standard"]
    names = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    return [Path(name) for name in names if (ROOT / name).is_file()]


def belongs(path: Path) -> bool:
    """True for documents and what they show."""
    folders = {"docs", "scenes", "editors", "farm"}
    return path.suffix in SUFFIXES and (len(path.parts) == 1 or path.parts[0] in folders)


def prepare() -> None:
    shutil.rmtree(SOURCE.parent, ignore_errors=True)
    files = [path for path in tracked() if belongs(path)]
    for path in files:
        target = SOURCE / path
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / path, target)
    for name in ["SUMMARY.md", "libraries.md"]:
        shutil.copyfile(ROOT / "book" / name, SOURCE / name)
    (SOURCE / "gallery.md").write_text(gallery(), encoding="utf-8")
    shutil.copyfile(ROOT / "target/words.md", SOURCE / "docs/words.md")
    pages = list(SOURCE.rglob("*.md"))
    for path in pages:
        redirect(path)
    # mdBook calls these pages index.html, and forgets it in links.
    for path in pages:
        if path.name == "README.md":
            path.rename(path.with_name("index.md"))


def redirect(path: Path) -> None:
    """Makes links to what is not in the book lead to the repository, and those to README.md to index.md."""
    text = path.read_text(encoding="utf-8")
    plain = links.without_code(text)
    pieces, done = [], 0
    for match in links.LINK.finditer(plain):
        start, end = match.span(1)
        file, mark, anchor = text[start:end].partition("#")
        target = (path.parent / unquote(file)).resolve()
        if not file or re.match(r"[a-z][a-z0-9+.-]*:", file) or file.startswith("api/"):
            continue
        if not target.is_file():
            file = REPOSITORY + str(target.relative_to(SOURCE))
        elif target.name == "README.md":
            file = file.removesuffix("README.md") + "index.md"
        pieces += [text[done:start], file + mark + anchor]
        done = end
    path.write_text("".join(pieces) + text[done:], encoding="utf-8")


def gallery() -> str:
    """Every scene of scenes/README.md with its picture and its source."""
    page = ["# Gallery\n\nEvery scene with its source. `pathmarch render NAME` renders one, and the window opens them all.\n"]
    row = re.compile(r"^\| !\[([^\]]*)\]\(([^)]*)\) \| \[[^\]]*\]\(([^)]*)\)<br>(.*?) \|", re.M)
    for name, picture, scene, words in row.findall((ROOT / "scenes/README.md").read_text(encoding="utf-8")):
        words = re.sub(r"\]\((?!https?:)(?!\.\./)", "](scenes/", words).replace("](../", "](")
        page.append(f"\n## {name}\n\n{words}\n\n![{name}](scenes/{picture})\n\n<details><summary>Source</summary>\n")
        page.append(f"\n```kdl\n{{{{#include scenes/{scene}}}}}\n```\n\n</details>\n")
    return "".join(page)


class Page(HTMLParser):
    """Links and names of a page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.names: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, _tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.append(value)
            if name in ("id", "name") and value:
                self.names.add(value)


def check() -> int:
    """Reports links of the site that lead nowhere; those of the libraries' documentation are rustdoc's business."""
    paths = [path for path in SITE.rglob("*.html") if SITE / "api" not in path.parents and path.name != "print.html"]
    pages = {path: Page(path) for path in paths}
    mistakes, count = [], 0
    for path, page in pages.items():
        for link in page.links:
            file, _, anchor = link.partition("#")
            if re.match(r"[a-z][a-z0-9+.-]*:|//", link) or path.name == "404.html":
                continue
            count += 1
            target = (path.parent / unquote(file)).resolve() if file else path
            target = target / "index.html" if target.is_dir() else target
            is_left_out = (SITE / "api") in target.parents and not (SITE / "api").exists()
            if not target.exists() and not is_left_out:
                mistakes.append(f"{path.relative_to(SITE)}: {link}: there is no such file")
            elif anchor and target in pages and unquote(anchor) not in pages[target].names:
                mistakes.append(f"{path.relative_to(SITE)}: {link}: there is no such place")
    print("\n".join(mistakes), end="\n" if mistakes else "")
    print(f"{len(pages)} pages, {count} links, {len(mistakes)} broken")
    return 1 if mistakes or not pages else 0


if __name__ == "__main__":
    sys.exit(prepare() if sys.argv[1:] == ["prepare"] else check())
