#!/usr/bin/env python3
"""Checks that every relative link of README, CHANGELOG, CONTRIBUTING and docs leads to a file and to a heading in it, and that
every picture in docs/pictures is shown by a page and drawn by a script, and that reference pages have their fixed headings.

    tests/docs/links.py"""
import importlib.machinery
import importlib.util
import os
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# Every page of a feature has these, in this order; the pages named are no features.
HEADINGS = ["Syntax", "Example", "Description", "Restrictions", "Related", "Defaults", "References"]
NO_FEATURE = {"index.md", "keys.md"}
# Pictures that no script draws, with the reason.
BY_HAND = {"inclined-flow.png": "the picture of a run beside a plot of its profile"}
LINK = re.compile(r"!?\[[^\]]*\]\(<?([^)\s>]+)>?\)")
FENCE = re.compile(r"^\s*(```+)[^\n]*\n.*?^\s*\1\s*$", re.M | re.S)


def slug(heading):
    """The anchor of a heading as GitHub and MyST make it."""
    heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def anchors(text):
    text = FENCE.sub("", text)
    return {slug(h) for h in re.findall(r"^#+ (.*)$", text, re.M)} | set(re.findall(r"^\(([^)]*)\)=\s*$", text, re.M))


def links_of(text):
    return LINK.findall(re.sub(r"`[^`\n]*`", "", FENCE.sub("", text)))


def faults(pages):
    """`pages`: path -> text; yields each link that leads nowhere."""
    for path, text in pages.items():
        for link in links_of(text):
            if re.match(r"[a-z]+:", link):
                continue
            name, _, anchor = link.partition("#")
            target = pathlib.Path(os.path.normpath(path.parent / name)) if name else path
            if not target.exists() and target not in pages:
                yield f"{path}: {link}: there is no such file"
            elif anchor and target in pages and anchor not in anchors(pages[target]):
                yield f"{path}: {link}: {target.name} has no heading of this name"


def heading_faults(name, text):
    found = re.findall(r"^## (.*)$", FENCE.sub("", text), re.M)
    if found != HEADINGS:
        yield f"{name}: its headings are {', '.join(found)}; a reference page has {', '.join(HEADINGS)}"


def pictures_drawn():
    """Names of the pictures that scripts draw: those of scripts/pictures, and those that other scripts name."""
    loader = importlib.machinery.SourceFileLoader("pictures", str(ROOT / "scripts" / "pictures"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("pictures", loader))
    sys.dont_write_bytecode = True
    loader.exec_module(module)
    others = " ".join((ROOT / "scripts" / name).read_text() for name in ("ledger", "verify.gnuplot", "work_precision.py"))
    return module.drawn() | set(re.findall(r"[\w-]+\.png", others))


def picture_faults(pictures, shown, drawn):
    """`shown`: text of all pages; `drawn`: names that scripts draw."""
    for name in pictures:
        if name not in shown:
            yield f"docs/pictures/{name}: no page shows it"
        if name not in drawn and name not in BY_HAND:
            yield f"docs/pictures/{name}: no script draws it; add its commands to scripts/pictures"


def main():
    files = [ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")] + sorted((ROOT / "docs").rglob("*.md"))
    pages = {path: path.read_text() for path in files if path.exists()}
    found = list(faults(pages))
    for path, text in pages.items():
        if path.parent == ROOT / "docs" / "reference" and path.name not in NO_FEATURE:
            found += heading_faults(path, text)
    names = sorted(p.name for p in (ROOT / "docs" / "pictures").rglob("*.*"))
    found += picture_faults(names, "\n".join(pages.values()), pictures_drawn())
    print("\n".join(found).replace(str(ROOT) + "/", "") or f"links: {len(pages)} pages, no fault")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
