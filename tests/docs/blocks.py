#!/usr/bin/env python3
"""Runs what a page of the documentation shows.

    tests/docs/blocks.py PROGRAM [--all] [PAGE...]

Of each page, in order and in one scratch folder per page:

    ```yaml     a scenario (it has `subsoil:`) is checked by `subsoil check`, a plan or study is read as YAML; with
                `<!-- file: NAME -->` before it, it is saved as NAME for the blocks below
    ```sh       every command is run by bash; each must end with exit code 0, or with N where `# exit code N` ends its line
    ```python   is run by python3 with the module of python on the path
    ```cpp      with `<!-- from: PATH -->` before it, stands in that file, apart from indentation

A comment before a block says otherwise:

    <!-- include: configs/tine.yaml -->  a fragment of a scenario: checked as a file that includes this one
    <!-- test: long -->                  run with --all only
    <!-- test: compiled -->              python that needs the compiled part of the module: skipped where it is not built
    <!-- test: skip, REASON -->          not run; only for what needs another machine, a screen or a package that is optional

A block of another language (`text`, `json`, ...) shows output and is not run; with `<!-- file: NAME -->` it is saved. An indented code block is an error: it has
no language. The last line of the output counts what ran, what waits for --all and what is skipped."""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import yaml

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SHOWN = {"text", "json", "csv", "ini", "cmake", "c", "math", "figure", "toctree", "bibtex", "list-table", "note", "tip", "warning",
         "important", "mermaid"}
# Debian's Python has h5py and pandas; another one on the PATH may lack them.
PYTHON = "/usr/bin/python3" if pathlib.Path("/usr/bin/python3").exists() else sys.executable
TIMEOUT = 900


class Block:
    def __init__(self, language, line, marks):
        self.language, self.line, self.marks, self.lines = language, line, marks, []

    @property
    def text(self):
        return "\n".join(self.lines) + "\n"


def blocks_of(text):
    """All fenced blocks of a page with the comments before them; raises ValueError on an indented code block."""
    found, marks, block, indent, fence = [], {}, None, "", ""
    before_blank, in_list = True, False
    for number, line in enumerate(text.splitlines(), 1):
        if block is not None:
            if line.strip() == fence:
                found.append(block)
                block, marks = None, {}
            else:
                block.lines.append(line.removeprefix(indent))
            continue
        opened = re.match(r"(\s*)(```+)\s*(\{?[\w-]*\}?)", line)
        mark = re.match(r"\s*<!--\s*(file|from|include|test):\s*(.*?)\s*-->\s*$", line)
        if opened:
            indent, fence = opened[1], opened[2]
            block = Block(opened[3].strip("{}") or "text", number, marks)
        elif mark:
            marks[mark[1]] = mark[2]
        elif line.strip():
            marks = {}
            if re.match(r"\s*([-*]|\d+\.) ", line):
                in_list = True
            elif not line.startswith(" "):
                in_list = False
            elif line.startswith("    ") and before_blank and not in_list:
                raise ValueError(f"line {number}: an indented code block; write ```sh, ```yaml or ```text")
        before_blank = not line.strip() or line.startswith("#")
    return found


class Page:
    def __init__(self, path, program, everything):
        self.path, self.program, self.everything = path, program, everything
        self.ran = self.waiting = self.skipped = 0
        self.failures = []
        self.reasons = []

    def fail(self, block, text):
        self.failures.append(f"{self.path.relative_to(ROOT)}:{block.line}: {text}")

    def run(self, folder):
        for name in "configs", "scripts", "tests", "examples", "python":
            if (ROOT / name).exists():
                (folder / name).symlink_to(ROOT / name)
        (folder / "docs" / "pictures").mkdir(parents=True)  # what a page draws does not go into the repository
        binary = folder / ".bin"
        binary.mkdir()
        (binary / "subsoil").symlink_to(self.program)
        self.folder = folder
        self.environment = dict(os.environ, PATH=f"{binary}:{os.environ['PATH']}", OMP_NUM_THREADS="2", SUBSOIL=str(self.program),
                                PYTHONPATH=str(ROOT / "python"))
        for block in blocks_of(self.path.read_text()):
            test = block.marks.get("test", "")
            if test.startswith("skip"):
                reason = test.removeprefix("skip").strip(" ,")
                if not reason:
                    self.fail(block, "`test: skip` names no reason")
                self.skipped += 1
                self.reasons.append(f"{self.path.name}:{block.line}: {reason}")
            elif test == "long" and not self.everything:
                self.waiting += 1
            elif test == "compiled" and not list(ROOT.glob("build/release/python/subsoil/_core*.so")):
                self.skipped += 1
                self.reasons.append(f"{self.path.name}:{block.line}: the compiled part of the Python module is not built")
            elif test not in ("", "long", "compiled"):
                self.fail(block, f"`test: {test}`: write `long`, `compiled` or `skip, REASON`")
            elif block.language in ("yaml", "sh", "python", "cpp"):
                getattr(self, block.language)(block)
                self.ran += 1
            elif block.language in SHOWN and "file" in block.marks:
                (self.folder / block.marks["file"]).write_text(block.text)
            elif block.language not in SHOWN:
                self.fail(block, f"language `{block.language}` is not known here")

    def call(self, command, **options):
        try:
            return subprocess.run(command, cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=TIMEOUT,
                                  stdin=subprocess.DEVNULL, **options)
        except subprocess.TimeoutExpired:
            return subprocess.CompletedProcess(command, 124, "", f"took longer than {TIMEOUT} s")

    def yaml(self, block):
        text = block.text
        name = block.marks.get("file", "block.yaml")
        try:
            read = yaml.safe_load(text)
        except yaml.YAMLError as error:
            return self.fail(block, str(error))
        base = block.marks.get("include")
        if base:
            if not (ROOT / base).exists():
                return self.fail(block, f"include: {base}: there is no such file")
            text = f"include: [{ROOT / base}]\n" + text
            for mesh in (ROOT / base).parent.glob("*.stl"):  # a fragment names them as its scenario does
                if not (self.folder / mesh.name).exists():
                    (self.folder / mesh.name).symlink_to(mesh)
        (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
        (self.folder / name).write_text(text)
        if base or (isinstance(read, dict) and "subsoil" in read and ("time" in read or "machine" in read or "soil" in read)):
            done = self.call(["subsoil", "check", name])
            if done.returncode:
                self.fail(block, f"subsoil check: exit code {done.returncode}\n{done.stdout[-1500:]}{done.stderr[-1500:]}")
        elif not (isinstance(read, dict) and "subsoil" in read):
            self.fail(block, "a fragment: name the scenario that it belongs to by `<!-- include: FILE -->`")
        return None

    def sh(self, block):
        for command in re.sub(r"\\\n\s*", " ", block.text).splitlines():
            if not command.strip() or command.lstrip().startswith("#"):
                continue
            wanted = re.search(r"#.*exit code (\d+)", command)
            done = self.call(["bash", "-c", "set -e; shopt -s expand_aliases\n" + command])
            if done.returncode != (int(wanted[1]) if wanted else 0):
                self.fail(block, f"`{command.strip()}`: exit code {done.returncode}\n{done.stdout[-1500:]}{done.stderr[-1500:]}")

    def python(self, block):
        done = self.call([PYTHON, "-c", block.text])
        if done.returncode:
            self.fail(block, f"exit code {done.returncode}\n{done.stdout[-800:]}{done.stderr[-1500:]}")

    def cpp(self, block):
        name = block.marks.get("from")
        if not name:
            return self.fail(block, "C++ must stand in a file: `<!-- from: PATH -->`")
        if not (ROOT / name).exists():
            return self.fail(block, f"from: {name}: there is no such file")

        def squeezed(text):
            return re.sub(r"\s+", " ", text).strip()
        if squeezed(block.text) not in squeezed((ROOT / name).read_text()):
            self.fail(block, f"differs from {name}")
        return None


def all_pages():
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--all", action="store_true", help="run blocks marked `long` too")
    parser.add_argument("--reasons", action="store_true", help="print why blocks are skipped")
    parser.add_argument("pages", nargs="*", type=pathlib.Path)
    options = parser.parse_intermixed_args()  # options may stand between program and pages
    ran = waiting = skipped = 0
    failures = []
    for path in [one.resolve() for one in options.pages] or all_pages():
        page = Page(path, options.program.resolve(), options.all)
        with tempfile.TemporaryDirectory(prefix="subsoil-docs-") as folder:
            try:
                page.run(pathlib.Path(folder))
            except ValueError as error:
                page.failures.append(f"{path.relative_to(ROOT)}: {error}")
        ran, waiting, skipped = ran + page.ran, waiting + page.waiting, skipped + page.skipped
        failures += page.failures
        if options.reasons and page.reasons:
            print("\n".join(page.reasons))
    print("\n".join(failures))
    print(f"blocks: {ran} ran, {waiting} wait for --all, {skipped} skipped, {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
