#!/usr/bin/env python3
"""Random scenarios against relations that need no oracle; see README.md beside this file.

  python3 tests/consistency --program build/release/apps/subsoil                 fixed seeds, two minutes
  python3 tests/consistency --program ... --seeds 1000: --seconds 1800           new seeds, half an hour
  python3 tests/consistency --program ... --seeds 17 --relation rotation         one case again
"""
import argparse
import json
import pathlib
import re
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import declarations  # noqa: E402
import degenerate  # noqa: E402
import scenario as scenarios  # noqa: E402
from geometry import render  # noqa: E402
from program import SLOW, Program, dump  # noqa: E402
from relations import RELATIONS, Case, last_line  # noqa: E402
from shrink import shrink  # noqa: E402

FIXED = range(1, 100000)


def options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, help="the built subsoil")
    parser.add_argument("--seeds", default="1:", help="FIRST:LAST, FIRST: or one seed")
    parser.add_argument("--seconds", type=float, default=120, help="wall time after which no new scenario begins")
    parser.add_argument("--relation", action="append", help="only this one (may be repeated)")
    parser.add_argument("--without", action="append", default=[], help="not this relation (may be repeated)")
    parser.add_argument("--kind", choices=["machine", "soil", "coupled"], help="only scenarios of this kind")
    parser.add_argument("--no-shrink", action="store_true", help="report violations as they are found")
    parser.add_argument("--finds", default="", help="folder for the reduced scenarios of violations")
    parser.add_argument("--results", default="", help="JSON file for the counts")
    parser.add_argument("--coverage", action="store_true", help="print how often each declared element was accepted")
    parser.add_argument("--print", action="store_true", help="print the scenario of each seed and run nothing")
    parser.add_argument("--list", action="store_true", help="list the relations")
    return parser.parse_args()


def seeds_of(text):
    first, colon, last = text.partition(":")
    if not colon:
        return range(int(first), int(first) + 1)
    return range(int(first), int(last) if last else 10**9)


class Session:
    def __init__(self, o):
        self.o = o
        self.program = Program(o.program)
        self.declared = declarations.of_program(o.program)
        self.passed = self.failed = self.accepted = self.drawn = self.slow = 0
        self.coverage = {}
        self.start = time.monotonic()

    def left(self):
        return self.o.seconds - (time.monotonic() - self.start)

    def wanted(self, kind):
        return [(name, function) for name, (kinds, function) in RELATIONS.items()
                if kind in kinds and name not in self.o.without and (not self.o.relation or name in self.o.relation)]

    def one(self, seed):
        drawn = scenarios.draw(seed, self.declared, self.o.kind)
        case = Case(self.program, drawn)
        self.drawn += 1
        case.base  # noqa: B018  (runs)
        if self.program.last > SLOW and case.base.code in (0, 3):
            self.slow += 1
            return
        self.accepted += case.base.ended
        for element in drawn.used:
            counts = self.coverage.setdefault(element, [0, 0, ""])
            counts[0] += 1
            counts[1] += case.base.ended
            counts[2] = counts[2] if case.base.ended else last_line(case.base.text)
        for name, function in self.wanted(drawn.kind):
            if case.base.code == 2 and name not in ("sentences", "check against run"):
                continue  # refused: nothing moved
            violations = function(case)
            self.judge(seed, name, function, drawn, violations)
        if "degenerate" not in self.o.without and (not self.o.relation or "degenerate" in self.o.relation):
            self.degenerate(seed, drawn)
        for folder in self.program.home.iterdir():
            remove(folder)

    def judge(self, seed, name, function, drawn, violations):
        if not violations:
            self.passed += 1
            return
        self.failed += 1
        print(f"\nseed {seed} ({drawn.kind}), {name}:")
        for line in violations:
            print(f"  {line}")
        if self.o.no_shrink:
            return
        kinds = {line.split(" differs")[0].split(":")[0] for line in violations}

        def violates(tree):
            again = function(Case(self.program, scenarios.Scenario(seed, drawn.kind, tree, [])))
            return any(line.split(" differs")[0].split(":")[0] in kinds for line in again)

        self.report(seed, name, shrink(drawn.tree, violates))

    def report(self, seed, name, tree):
        document = dump(render(tree))
        print("  reduced:\n" + "".join(f"    {line}\n" for line in document.splitlines()), flush=True)
        if self.o.finds:
            folder = pathlib.Path(self.o.finds)
            folder.mkdir(parents=True, exist_ok=True)
            (folder / f"{name.replace(' ', '-')}-{seed}.yaml").write_text(f"# relation: {name}; seed {seed}\n{document}")

    def degenerate(self, seed, drawn):
        for k in range(3):
            tree, faults = degenerate.mutated(drawn.tree, seed * 10 + k)
            violations = broken(self.program, tree)
            if violations:
                self.failed += 1
                print(f"\nseed {seed} ({drawn.kind}), degenerate: {'; '.join(faults)}\n  " + "\n  ".join(violations))
                if not self.o.no_shrink:
                    self.report(seed, "degenerate", shrink(tree, lambda t: bool(broken(self.program, t)), tries=80))
            else:
                self.passed += 1

    def end(self):
        if self.o.coverage:
            for element, (drawn, ended, why) in sorted(self.coverage.items()):
                print(f"{ended:5d} of {drawn:5d}  {element}" + (f"   {why}" if not ended else ""))
        took = time.monotonic() - self.start
        print(f"consistency: {self.drawn} scenarios, {self.accepted} of them ran, {self.slow} were left out as slow, {self.program.runs} runs in {took:.0f} s")
        print(f"{self.passed} passed, {self.failed} failed")
        if self.o.results:
            pathlib.Path(self.o.results).write_text(json.dumps({"passed": self.passed, "failed": self.failed}))
        self.program.close()
        return 1 if self.failed or not self.accepted else 0


def broken(program, tree):
    """What no input may cause: a crash, a hang, an end without a word, a number that is none."""
    run = program.run(tree)
    if run.code == "hang":
        found = re.search(r"^steps +(\d+)", program.check(tree).text, re.MULTILINE)
        told = found and int(found[1]) > 10**7 or re.search(r"% .*remaining ", run.text)  # `check` or the run says how long it takes
        return [] if told else [last_line(run.stderr)]
    if run.code not in (0, 2, 3):
        return [f"exit code {run.code}: {last_line(run.text)}"]
    if run.code:
        return [] if len(last_line(run.text)) > 15 else [f"exit code {run.code} without a sentence"]
    import numpy
    bad = [name for name, values in run.table().items() if not numpy.isfinite(values).all()]
    return [f"{name} is not finite, exit code 0" for name in bad[:3]]


def remove(folder):
    import shutil
    shutil.rmtree(folder, ignore_errors=True)


def main():
    o = options()
    if o.list:
        for name, (kinds, function) in RELATIONS.items():
            print(f"{name}: {', '.join(kinds)}. {(function.__doc__ or '').strip()}")
        return 0
    session = Session(o)
    if o.print:
        for seed in seeds_of(o.seeds):
            print(dump(render(scenarios.draw(seed, session.declared, o.kind).tree)))
        session.program.close()
        return 0
    for seed in seeds_of(o.seeds):
        if session.left() < 0:
            break
        session.one(seed)
    return session.end()


if __name__ == "__main__":
    sys.exit(main())
