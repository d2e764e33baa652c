#!/usr/bin/env python3
"""The checkers of docs fail when they should: python3 tests/docs/test_checkers.py"""
import importlib.machinery
import importlib.util
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import blocks
import links
import style


def kinds(text, path="docs/page.md"):
    return [one.kind for one in style.check_markdown(path, text)]


class Style(unittest.TestCase):
    def test_finds_each_private_word(self):
        examples = ["a dead point", "it looks back", "the grip of", "bodies that yield", "calm spheres", "frozen ones", "it lets go",
                    "a carved bed", "taken out", "goes on", "anew", "is told", "the program says", "by the clock", "in turn",
                    "the engine before", "the lever of", "the least pull", "the largest force", "strongest line", "a watch",
                    "a rehearsal", "a trial run", "a stand-in", "the usual case", "a foreign file", "is sought", "set aside",
                    "StepQuestion", "was mended", "the spin of", "a twin of", "the errand of"]
        for text in examples:
            self.assertEqual(kinds(text + " body."), ["word"], text)
        for pattern in style.WORDS:
            self.assertTrue(any(style.re.search(rf"\b(?:{pattern})\b", text, style.re.I) for text in examples)
                            or "singular" in pattern, pattern)

    def test_names_place_and_term(self):
        found = style.check_markdown("docs/page.md", "# Title\n\nOne line.\nThe soil is calm here.\n")
        self.assertEqual([(one.place, one.text) for one in found], [("docs/page.md:4", "`calm`: write sleep candidate")])

    def test_passes_the_terms_of_the_field(self):
        self.assertEqual(kinds("At least squares fits, at least two. The `soil.spin` column. `watch: {}` and spin-up. Sayings, latest."), [])

    def test_code_is_no_prose(self):
        self.assertEqual(kinds("```yaml\nwatch: {spin: 1}\n```\n\n~~~\nanew\n~~~\n\n    indented anew\n"), [])
        self.assertEqual(kinds("[text](anew.md) and $spin$.\n"), [])
        self.assertEqual(kinds("$$\n\\text{frozen}\n$$\n\n$$ calm $$\n\n$$ a\ncalm $$\nanew\n"), ["word"])

    def test_reads_tables_lists_and_headings(self):
        self.assertEqual(kinds("| a | told |\n|---|---|\n| calm | b |\n"), ["word", "word"])
        self.assertEqual(kinds("- one\n- two anew\n"), ["word"])
        self.assertEqual(kinds("## Going on\n"), ["word"])

    def test_sentence_of_41_words_fails_and_of_40_passes(self):
        self.assertEqual(kinds(" ".join(["word"] * 41) + ".\n"), ["sentence"])
        self.assertEqual(kinds(" ".join(["word"] * 40) + ".\n"), [])
        self.assertEqual(kinds(" ".join(["word"] * 30) + ".\n" + "Next " + " ".join(["word"] * 30) + ".\n"), [])
        self.assertEqual(kinds(" ".join(["word"] * 30) + " of eq. (3), e.g. " + " ".join(["word"] * 12) + ".\n"), ["sentence"])
        self.assertEqual(kinds("- " + " ".join(["word"] * 30) + "\n- " + " ".join(["word"] * 30) + "\n"), [])

    def test_median_of_prose(self):
        text = "# " + "word " * 5 + "\n\n| " + "word " * 5 + "|\n\n- " + "word " * 5 + "\n\n**Bound.** " + "Word " + "word " * 14 + "end.\n"
        self.assertEqual(style.prose_lengths(text), [16], "only the sentence is prose")
        self.assertFalse(list(style.median_fault([16])))
        self.assertTrue(list(style.median_fault([8, 9, 10])))
        self.assertTrue(list(style.median_fault([25])))

    def test_reads_comments_of_headers_and_messages(self):
        def source(text, comments, strings):
            return [one.text.split(":")[0] for one in style.check_source("libdem/a.hpp", text, comments, strings)]
        self.assertEqual(source("int calm;  // built anew\n", True, False), ["`anew`"])
        self.assertEqual(source('throw Error("the bed is calm now");  // anew\n', False, True), ["`calm`"])
        self.assertEqual(source('v.word("carve", "calm");\n', False, True), [], "a key is no prose")

    def test_budget(self):
        found = {"docs/a.md words": [style.Finding("docs/a.md:1", "word", "x")] * 2}
        self.assertTrue(list(style.failures(found, {})))
        self.assertTrue(list(style.failures(found, {"docs/a.md words": 1})))
        self.assertFalse(list(style.failures(found, {"docs/a.md words": 2})))


class Links(unittest.TestCase):
    def test_finds_what_is_not_there(self):
        here = pathlib.Path(__file__).resolve()
        page = here.with_name("page.md")
        def found(text):
            return len(list(links.faults({page: text})))
        self.assertEqual(found("[a](nowhere.md)"), 1)
        self.assertEqual(found("# A b\n\n[a](#a-b) [c](#c)"), 1)
        self.assertEqual(found(f"[a]({here.name}) `[x](y)` [w](https://example.org)\n\n```text\n[x](y)\n```\n"), 0)
        self.assertEqual(links.slug("7.2 Moving bed: `window`"), "72-moving-bed-window")

    def test_finds_pictures_that_are_not_shown_or_not_drawn(self):
        def found(drawn):
            return list(links.picture_faults(["a.png", "b.png"], "![a](../pictures/a.png)", drawn))
        self.assertEqual(found({"a.png", "b.png"}), ["docs/pictures/b.png: no page shows it"])
        self.assertEqual(len(found({"b.png"})), 2)
        drawn = links.pictures_drawn()
        self.assertLessEqual({"tutorial-draft.png", "impact-loop.png", "gallery-tine.png", "verify-pulls.png", "element-heap.png"}, drawn)
        self.assertFalse(drawn & set(links.BY_HAND), "a picture that a script draws is not drawn by hand")

    def test_finds_missing_headings(self):
        good = "".join(f"## {one}\n" for one in links.HEADINGS)
        self.assertEqual(list(links.heading_faults("a.md", good)), [])
        self.assertEqual(len(list(links.heading_faults("a.md", good.replace("## Defaults\n", "")))), 1)
        self.assertEqual(len(list(links.heading_faults("a.md", "## Example\n## Syntax\n"))), 1)


class Blocks(unittest.TestCase):
    def result(self, text, everything=False):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            program = folder / "subsoil"
            program.write_text("#!/bin/sh\ngrep -q fault \"$2\" && exit 2\nexit 0\n")
            program.chmod(0o755)
            path = style.ROOT / "README.md"
            page = blocks.Page(path, program, everything)
            page.path = type("P", (), {"read_text": lambda self: text, "relative_to": lambda self, root: path, "name": "p.md"})()
            (folder / "run").mkdir()
            page.run(folder / "run")
            return page

    def test_commands(self):
        self.assertFalse(self.result("```sh\ntrue\nfalse  # exit code 1\n```\n").failures)
        self.assertTrue(self.result("```sh\nfalse\n```\n").failures)
        self.assertTrue(self.result("```sh\ntrue  # exit code 2\n```\n").failures)
        self.assertTrue(self.result("```sh\nfalse | true; no-such-program\n```\n").failures)

    def test_scenarios(self):
        self.assertFalse(self.result("```yaml\nsubsoil: 1\ntime: {end: 1 s}\n```\n").failures)
        self.assertTrue(self.result("```yaml\nsubsoil: 1\ntime: {fault: 1 s}\n```\n").failures)
        self.assertTrue(self.result("```yaml\na: [\n```\n").failures)
        self.assertTrue(self.result("```yaml\nsoil: {}\n```\n").failures, "a fragment without its scenario")
        self.assertFalse(self.result("<!-- include: configs/tine.yaml -->\n```yaml\nsoil: {}\n```\n").failures)
        self.assertTrue(self.result("<!-- include: configs/none.yaml -->\n```yaml\nsoil: {}\n```\n").failures)
        self.assertFalse(self.result("<!-- file: a.yaml -->\n```yaml\nsubsoil: 1\n```\n\n```sh\ntest -e a.yaml\n```\n").failures)

    def test_python_and_cpp(self):
        self.assertFalse(self.result("```python\nimport math\n```\n").failures)
        self.assertTrue(self.result("```python\nassert False\n```\n").failures)
        self.assertTrue(self.result("```cpp\nint a;\n```\n").failures)
        self.assertTrue(self.result("<!-- from: tests/tools/paths.cpp -->\n```cpp\nint no_such_name;\n```\n").failures)

    def test_marks(self):
        page = self.result("<!-- test: long -->\n```sh\nfalse\n```\n\n<!-- test: skip, needs Slurm -->\n```sh\nfalse\n```\n")
        self.assertEqual((page.ran, page.waiting, page.skipped, page.failures), (0, 1, 1, []))
        self.assertTrue(self.result("<!-- test: long -->\n```sh\nfalse\n```\n", True).failures)
        self.assertTrue(self.result("<!-- test: skip -->\n```sh\nfalse\n```\n").failures, "no reason")
        self.assertTrue(self.result("<!-- test: later -->\n```sh\ntrue\n```\n").failures)
        self.assertTrue(self.result("```fortran\nend\n```\n").failures)
        with self.assertRaises(ValueError):
            self.result("Text:\n\n    subsoil run mine.yaml\n")
        with self.assertRaises(ValueError):
            self.result("## Syntax\n    subsoil run mine.yaml\n")


def script(name):
    loader = importlib.machinery.SourceFileLoader(name, str(style.ROOT / "scripts" / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


class Release(unittest.TestCase):
    def faults(self, **changed):
        files = {"CMakeLists.txt": "project(subsoil VERSION 0.2.0 LANGUAGES CXX)\n", "CITATION.cff": "version: 0.2.0\n",
                 "docs/start.md": "subsoil_0.2.0_amd64.deb\n", "CHANGELOG.md": "## Unreleased\n\n## 0.2.0 - 2026-01-31\n- One.\n"}
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "docs").mkdir()
            for name, text in (files | {key.replace("_", "."): text for key, text in changed.items()}).items():
                (root / name).write_text(text)
            return list(script("release").disagreements("0.2.0", root))

    def test_agreement(self):
        self.assertEqual(self.faults(), [])

    def test_disagreements(self):
        changes = [("CMakeLists_txt", "project(subsoil VERSION 0.1.0)\n"), ("CITATION_cff", "version: 0.1.0\n"), ("CITATION_cff", ""),
                   ("CHANGELOG_md", "## 0.1.0 - 2026-01-31\n"), ("CHANGELOG_md", "## 0.2.0 - unreleased\n"),
                   ("CHANGELOG_md", "## Unreleased\n- New.\n\n## 0.2.0 - 2026-01-31\n"),
                   ("CHANGELOG_md", "## 0.2.0 - 2026-01-31\n- " + "x" * 120 + "\n")]
        for name, text in changes:
            self.assertEqual(len(self.faults(**{name: text})), 1, text)


class Site(unittest.TestCase):
    def test_dead_links_and_network(self):
        docs = script("docs")
        with tempfile.TemporaryDirectory() as folder:
            site = pathlib.Path(folder)
            (site / "a.html").write_text('<a href="b.html#x">b</a><h1 id="y"></h1><a href="https://example.org">w</a>')
            (site / "b.html").write_text('<p id="x"></p><a href="a.html#z"></a><img src="none.png"><a href="#x"></a>')
            self.assertEqual(sorted(one.split(": ")[1] for one in docs.dead_links(site, False)), ["a.html#z", "none.png"])
            self.assertEqual(list(docs.asks_for_network(site)), [])
            (site / "c.html").write_text('<script src="https://example.org/m.js"></script>')
            self.assertEqual(len(list(docs.asks_for_network(site))), 1)


if __name__ == "__main__":
    unittest.main()
