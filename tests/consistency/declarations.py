"""Keys of a scenario as the program declares them: rows of the tables of `subsoil reference`.

The generator draws from these rows alone, so that a joint, force, law or shape which is added to the program is drawn too.
"""
import dataclasses
import re
import subprocess

ROW = re.compile(r"^\| `(.+?)` \| (.*?) \| (.*?) \| (.*?) \| (.*) \|$")


@dataclasses.dataclass(frozen=True)
class Key:
    """One row: path without its section, type or unit, default, range and meaning."""
    path: str
    type: str
    default: str
    range: str
    meaning: str

    @property
    def name(self):
        return self.path.rsplit(".", 1)[-1]

    @property
    def required(self):
        return self.default == "required"

    @property
    def words(self):
        return [word.strip() for word in self.range.split(" | ")]

    def bounds(self):
        """Least and largest value, and whether each belongs to the range; None where the range is no interval."""
        found = re.match(r"^([\[(])(\S+), (\S+?)([\])])", self.range)
        if not found:
            return None
        return float(found[2]), float(found[3]), found[1] == "[", found[4] == "]"


class Declarations:
    """Sections of the scenario file: section -> {path: Key}."""

    def __init__(self, text):
        self.sections = {}
        rows = None
        for line in text.splitlines():
            if line.startswith("# The file of"):
                break  # plans of other commands
            if line.startswith("## "):
                rows = self.sections.setdefault(line[3:].strip(), {})
            found = ROW.match(line.replace("\\|", "\x00"))
            if found and rows is not None:
                fields = [field.replace("\x00", "|").strip() for field in found.groups()]
                rows[fields[0]] = Key(*fields)
        if "machine" not in self.sections or "soil" not in self.sections:
            raise ValueError("the reference has no sections `machine` and `soil`: its format is another one")

    def below(self, path):
        """Keys whose path begins with `path.`, by the rest of their path."""
        rows = self.sections[path.split(".", 1)[0]]
        return {name[len(path) + 1:]: key for name, key in rows.items() if name.startswith(path + ".")}

    def children(self, path):
        """Keys exactly one level below `path`."""
        return {name: key for name, key in self.below(path).items() if "." not in name}

    def elements(self, path):
        """Element types of a list of elements, such as machine.joints: name -> Key of the type itself."""
        return {name: key for name, key in self.children(path).items() if name != "<name>"}

    def types(self, path):
        """Types of a section such as `function`, or laws of `contacts`: rows whose type is `type`, `section` or a required form."""
        return {name: key for name, key in self.children(path).items() if key.type in ("type", "section") or key.required}


def of_program(program):
    done = subprocess.run([program, "reference"], capture_output=True, text=True, timeout=60)
    if done.returncode:
        raise RuntimeError(f"`{program} reference` ends with exit code {done.returncode}: {done.stderr}")
    return Declarations(done.stdout)
