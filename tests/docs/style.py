#!/usr/bin/env python3
"""Checks the language of docs, header comments and messages.

    tests/docs/style.py               all checks; exit code 1 when one fails
    tests/docs/style.py --list        every finding, also those within the budget
    tests/docs/style.py --statistics  sentence lengths of each page
    tests/docs/style.py --lower       writes the present counts into style_budget.json where they are smaller

Three rules:
1. No word of WORDS. Code spans, code blocks and link targets are not prose, so that keys and column names pass.
2. No sentence of more than 40 words in docs.
3. The median sentence of the prose of all docs has MEDIAN words: below it reads like a telegram, above it tires.
   Headings, table cells and list items are not prose.

style_budget.json holds the findings that a page, or a group of sources, still has. What is not listed has none.
A budget only shrinks: the sum over all entries must not exceed that of the merge base with main."""
import argparse
import collections
import json
import pathlib
import re
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUDGET = pathlib.Path(__file__).with_name("style_budget.json")
MAX_WORDS = 40
MEDIAN = (14, 18)

# Private word -> the field's term. Each entry is one regular expression, case-insensitive.
WORDS = {
    r"dead points?": "singular configuration",
    r"look(s|ed|ing)? (back|ahead|into)": "dense output, sample",
    r"(walk|step|creep|bridge|land)(s|ed|ing)? (on|over) (the |a )?(singular|dead)": "step across the singularity",
    r"grips?": "stiction (bristle) state",
    r"bod(y|ies) that yields?": "body of finite effective mass",
    r"calm(er|ly)?": "sleep candidate",
    r"frozen|freez(e|es|ing)": "asleep",
    r"let(s|ting)? go": "release",
    r"carv(e|es|ed|ing)": "remove overlapping particles",
    r"taken out": "removed",
    r"go(es|ing)? on( from)?|went on": "continues, restart from, advances",
    r"anew": "again, re-",
    r"told": "identifiable; inconclusive",
    r"sa(y|ys|id)": "reports, prints, states",
    r"by the clock": "wall time",
    r"in turn": "interleaved A/B runs",
    r"the engine before|of that day": "baseline commit",
    r"levers?": "moment arm",
    r"(?<!at )least(?! squares)": "minimum",
    r"largest": "maximum",
    r"strongest line": "dominant frequency",
    r"watch(es|ed|ing)?": "monitor",
    r"rehears(al|als|e|ed)": "dry run",
    r"trial run": "dry run",
    r"stand-ins?": "proxy",
    r"usual": "fast path, default options",
    r"foreign (file|byte|input)s?": "untrusted input",
    r"sought|seek(s|ing)?": "root or extremum request; search",
    r"retired?|set aside": "migrate, saved history",
    r"StepQuestion": "StableStepInput",
    r"mended": "fixed",
    r"spins?": "angular velocity",
    r"twins?": "duplicate",
    r"errands?|census": "a field term",
}
# Of the table in the style guide these are not checked, since the field uses them too:
#   column, row (tables, matrices), block (block averaging, code block), piece, trial (trial force), words, look, cross,
#   creep, bridge (capillary bridge), land, waiting (a thread), wake (a flow).

# (path pattern, word pattern, reason): findings that stay.
ALLOWED = [
    (r".*", r"spin-?up", "name of a published benchmark of beams"),
    (r"docs/reference/keys\.md", r".*", "generated from the declarations in the sources, which are checked as messages"),
    (r"docs/reference/output-variables\.md", r".*", "the table is generated from declarations in the sources"),
    (r"docs/verification/(index|mechanisms)\.md", r".*", "generated; the prose is checked in index.in.md"),
]
GENERATED = {"docs/reference/keys.md", "docs/reference/output-variables.md",
             "docs/verification/index.md", "docs/verification/mechanisms.md"}
SOURCES = ("libdem", "libmbd", "coupling", "libsim", "apps")

Finding = collections.namedtuple("Finding", "place kind text")


def word_pattern():
    return re.compile(r"(?<![\w-])(?:" + "|".join(f"(?:{one})" for one in WORDS) + r")(?![\w-])", re.I)


PATTERN = word_pattern()


def term_for(word):
    for pattern, term in WORDS.items():
        if re.fullmatch(pattern, word, re.I):
            return term
    return next((term for pattern, term in WORDS.items() if re.search(pattern, word, re.I)), "")


def allowed(path, line, match):
    for where, what, _ in ALLOWED:
        if not re.fullmatch(where, path):
            continue
        if what == ".*" or any(m.start() <= match.start() and match.end() <= m.end() for m in re.finditer(what, line, re.I)):
            return True
    return False


# --- Markdown -------------------------------------------------------------------------------------------------------

def without_code(line):
    """A line of prose: code spans and formulas become one word each, links their text."""
    line = re.sub(r"<!--.*?-->", "", line)
    line = re.sub(r"(`+)(?:(?!\1).)+?\1", "CODE", line)
    line = re.sub(r"\$[^$]+\$", "FORMULA", line)
    line = re.sub(r"!\[([^\]]*)\]\([^)]*\)", r"\1", line)
    line = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line)
    return re.sub(r"\{[a-z:]+\}CODE", "CODE", line)


def blocks(text):
    """(first line number, [lines]) for each paragraph, list item, heading and table cell of a Markdown text."""
    found, lines, start = [], [], 0
    fence = None
    after_blank = True

    def flush():
        nonlocal lines
        if lines:
            found.append((start, lines))
        lines = []

    for number, raw in enumerate(text.splitlines(), 1):
        marker = re.match(r"\s*(```+|~~~+|:::+)", raw)
        if fence:
            if (marker and raw.strip().startswith(fence)) or (fence == "$$" and raw.rstrip().endswith("$$")):
                fence = None
            continue
        if raw.strip().startswith("$$"):  # a displayed formula, to the line that ends with $$
            flush()
            if raw.strip() == "$$" or not raw.strip().endswith("$$"):
                fence = "$$"
            continue
        if marker and not marker.group(1).startswith(":::"):
            flush()
            fence = marker.group(1)
            continue
        if marker or re.match(r"\s*(\{\{|<!--|\(.*\)=\s*$|:[a-z-]+:)", raw):
            flush()
            continue
        if not raw.strip():
            flush()
            after_blank = True
            continue
        if raw.startswith("    ") and after_blank and not lines and not re.match(r"\s*([-*]|\d+\.) ", raw) and not found_list(found):
            continue  # an indented code block
        if raw.lstrip().startswith("|"):
            flush()
            for cell in re.split(r"(?<!\\)\|", without_code(raw).strip().strip("|")):
                if cell.strip() and not re.fullmatch(r"[\s:-]+", cell):
                    found.append((number, [cell.strip()]))
            continue
        if re.match(r"\s*([-*]|\d+\.) |#+ ", raw):
            flush()
        if not lines:
            start = number
        lines.append(without_code(raw.strip()))
        after_blank = raw.startswith("#")
        if after_blank:
            flush()
    flush()
    return found


def found_list(found):
    return bool(found) and re.match(r"([-*]|\d+\.) ", found[-1][1][0]) is not None


ABBREVIATION = re.compile(r"\b(e\.g|i\.e|cf|vs|Fig|fig|Eq|eq|No|al|approx|resp|p|pp|Vol)\.$")


def sentences(paragraph):
    text = re.sub(r"\s+", " ", re.sub(r"^([-*]|\d+\.|#+|>) ", "", paragraph))
    start = 0
    for match in re.finditer(r"[.!?][\"')*_]*(?= +[\"'(*_\[]*[A-Z0-9])|: +(?=[A-Z])", text):
        part = text[start:match.end()]
        if ABBREVIATION.search(part.rstrip("\"')*_")):
            continue
        yield part
        start = match.end()
    if text[start:].strip():
        yield text[start:]


def word_count(sentence):
    return sum(any(c.isalnum() for c in token) for token in sentence.split())


def lengths(text, prose=False):
    """(line, words, sentence) of a page; `prose`: without headings, cells of tables and items of lists."""
    kept = [(line, lines) for line, lines in blocks(text) if not (prose and is_no_prose(text, line))]
    return [(line, count, one) for line, lines in kept for one in sentences(" ".join(lines)) if (count := word_count(one))]


def is_no_prose(text, line):
    return re.match(r"\s*(\||#|[-*] |\d+\. )", text.splitlines()[line - 1]) is not None


def prose_lengths(text):
    """Words of each sentence of the prose. Labels such as `**Bound.**`, up to three words, do not count."""
    return [count for _, count, _ in lengths(text, prose=True) if count > 3]


def median_fault(counts):
    """What is wrong with the median of `counts`, or nothing."""
    middle = statistics.median(counts)
    if not MEDIAN[0] <= middle <= MEDIAN[1]:
        yield f"the median sentence of the docs has {middle:g} words: must be {MEDIAN[0]} to {MEDIAN[1]}"


def check_markdown(path, text):
    found = []
    for line, lines in blocks(text):
        for offset, one in enumerate(lines):
            for match in PATTERN.finditer(one):
                if not allowed(path, one, match):
                    found.append(Finding(f"{path}:{line + offset}", "word", f"`{match[0]}`: write {term_for(match[0])}"))
    if path not in GENERATED:
        for line, count, one in lengths(text):
            if count > MAX_WORDS:
                found.append(Finding(f"{path}:{line}", "sentence", f"{count} words: {' '.join(one.split()[:8])} ..."))
    return found


# --- C++ ------------------------------------------------------------------------------------------------------------

STRING_OR_COMMENT = re.compile(r"""//(?P<comment>[^\n]*)|/\*(?P<long>.*?)\*/|"(?P<string>(?:\\.|[^"\\\n])*)"|'(?:\\.|[^'\\\n])+'""", re.S)


def check_source(path, text, comments, strings):
    """Comments of headers, and string literals that hold prose: three words or more."""
    found = []
    for token in STRING_OR_COMMENT.finditer(text):
        prose = (token["comment"] or token["long"] or "") if comments else ""
        if strings and token["string"] and len(token["string"].split()) >= 3:
            prose = token["string"]
        prose = re.sub(r"`[^`]*`", "CODE", prose)
        for match in PATTERN.finditer(prose):
            if not allowed(path, prose, match):
                line = text.count("\n", 0, token.start()) + 1
                found.append(Finding(f"{path}:{line}", "word", f"`{match[0]}`: write {term_for(match[0])}"))
    return found


# --- all ------------------------------------------------------------------------------------------------------------

def pages():
    for path in sorted([ROOT / "README.md", ROOT / "CHANGELOG.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")]):
        if path.exists():
            yield path.relative_to(ROOT).as_posix(), path.read_text()


def findings():
    """Budget entry -> findings."""
    found = collections.defaultdict(list)
    for path, text in pages():
        for one in check_markdown(path, text):
            found[f"{path} {one.kind}s"].append(one)
    for folder in SOURCES:
        for path in sorted((ROOT / folder).rglob("*.[ch]pp")) if (ROOT / folder).is_dir() else []:
            if "vendor" in path.parts:
                continue
            name, text = path.relative_to(ROOT).as_posix(), path.read_text()
            if path.suffix == ".hpp":
                found["comments of headers"] += check_source(name, text, True, False)
            found["messages"] += check_source(name, text, False, True)
    return found


def budget_sum_at_base():
    """Sum of the budget at the merge base with main; None without git or without a budget there."""
    for other in "origin/main", "main":
        base = subprocess.run(["git", "merge-base", "HEAD", other], cwd=ROOT, capture_output=True, text=True)
        if base.returncode == 0:
            name = BUDGET.relative_to(ROOT).as_posix()
            old = subprocess.run(["git", "show", f"{base.stdout.strip()}:{name}"], cwd=ROOT, capture_output=True, text=True)
            return sum(json.loads(old.stdout).values()) if old.returncode == 0 else None
    return None


def failures(found, budget):
    for name, ones in sorted(found.items()):
        allowed_count = budget.get(name, 0)
        if len(ones) > allowed_count:
            yield f"{name}: {len(ones)} findings, budget {allowed_count}"
            shown = ones if allowed_count == 0 else ones[:20]
            yield from (f"  {one.place}: {one.text}" for one in shown)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="every finding")
    parser.add_argument("--statistics", action="store_true", help="sentence lengths of each page")
    parser.add_argument("--lower", action="store_true", help="lower the budget to what is there")
    parser.add_argument("pages", nargs="*", help="with --list and --statistics: only these")
    options = parser.parse_args()
    if options.statistics:
        everything = []
        for path, text in pages():
            counts = [count for _, count, one in lengths(text, prose=True) if count > 3]
            if not counts or (options.pages and path not in options.pages):
                continue
            everything += counts if path not in GENERATED else []
            over = sum(count > MAX_WORDS for count in counts)
            print(f"{path}: {len(counts)} sentences, median {statistics.median(counts):.0f}, above {MAX_WORDS}: {over}")
        if everything:
            share = sum(count > MAX_WORDS for count in everything) / len(everything)
            print(f"all: {len(everything)} sentences, median {statistics.median(everything):.0f}, above {MAX_WORDS}: {share:.1%}")
        return 0
    found = findings()
    if options.list:
        for name, ones in sorted(found.items()):
            for one in ones:
                if not options.pages or one.place.split(":")[0] in options.pages:
                    print(f"{one.place}: {one.text}")
        return 0
    budget = json.loads(BUDGET.read_text()) if BUDGET.exists() else {}
    if options.lower:
        known = budget or {name: len(ones) for name, ones in found.items()}
        lower = {name: min(count, len(found.get(name, []))) for name, count in known.items()}
        BUDGET.write_text(json.dumps({k: v for k, v in sorted(lower.items()) if v}, indent=1) + "\n")
        return 0
    bad = [*failures(found, budget),
           *median_fault([count for path, text in pages() if path not in GENERATED for count in prose_lengths(text)])]
    before = budget_sum_at_base()
    if before is not None and sum(budget.values()) > before:
        bad.append(f"{BUDGET.name}: its sum has risen from {before} to {sum(budget.values())}; a budget only shrinks")
    print("\n".join(bad) if bad else f"style: within the budget of {sum(budget.values())} findings")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
