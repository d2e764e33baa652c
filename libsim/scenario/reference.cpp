#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <string_view>

#include "libdem/laws/linear.hpp"
#include "libsim/keys/former_keys.hpp"
#include "libsim/keys/functions.hpp"
#include "libsim/keys/key_list.hpp"
#include "libsim/keys/printer.hpp"
#include "libsim/keys/registry.hpp"
#include "libsim/scenario/effects.hpp"
#include "libsim/scenario/load.hpp"

/// The explicit copy, `explain`, docs/reference/keys.md and `new`: all of them prints of the declarations.
namespace subsoil::sim {
namespace {

constexpr std::string_view kContents = "# contents of ";

std::string print(Scenario scenario, bool comments) {
  Node document = print_all([&](Fields& fields) { declare(fields, scenario); }, comments);
  drop_without_effect(document, scenario);
  return emit(document);
}

std::vector<KnownKey> make_keys() {
  std::vector<KnownKey> keys;
  KeyList list(keys, "");
  Scenario prototype;
  declare(list, prototype);
  declare_command_sections(list);
  // A function of time may stand wherever a key says so, and so may a characteristic; their forms are listed once.
  list_function_forms(keys);
  return keys;
}

std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts(1);
  for (const char c : path) {
    if (c == '.') {
      parts.emplace_back();
    } else if (c == '[') {
      break;  // contacts[0].mu: the index says nothing here
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

std::string without_indices(std::string path) {
  for (std::size_t open; (open = path.find('[')) != std::string::npos;) {
    path.erase(open, path.find(']', open) - open + 1);
  }
  return path;
}

/// Whether the row's path, from its part `from` on, begins with the query; `<name>` stands for any name.
bool matches(const std::vector<std::string>& row, std::size_t from, const std::vector<std::string>& query) {
  if (row.size() < from + query.size()) return false;
  for (std::size_t i = 0; i < query.size(); ++i) {
    if (row[from + i] != query[i] && row[from + i] != "<name>") return false;
  }
  return true;
}

std::string sentence(const KnownKey& row) {
  std::string text = row.path + "\n    " + row.meaning + "\n";
  if (!row.unit.empty()) text += fmt::format("    value:   {}\n", row.unit == "1" ? "number without unit" : row.unit);
  if (!row.fallback.empty()) text += fmt::format("    default: {}\n", row.fallback);
  if (!row.range.empty()) text += fmt::format("    range:   {}\n", row.range);
  return text;
}

constexpr const char* table_head = "| key | value | default | range | meaning |\n|---|---|---|---|---|\n";

std::string table_row(const KnownKey& row) {
  const auto cell = [](const std::string& raw) {
    std::string text;
    for (const char c : raw) {
      if (c == '|') text += '\\';
      text += c;
    }
    return text;
  };
  return fmt::format("| `{}` | {} | {} | {} | {} |\n", row.path, cell(row.unit == "1" ? "number" : row.unit),
                     cell(row.fallback), cell(row.range), cell(row.meaning));
}

/// Rows at or below a path, and how many parts of their paths lie at or above it.
struct Rows {
  std::vector<const KnownKey*> rows;
  std::size_t depth = 0;
};

/// The first two parts of a path where a scenario has them; empty where it has not.
std::vector<std::string> section_of(std::vector<std::string> parts) {
  if (parts.size() < 2) return {};
  parts.resize(2);
  const bool is_known = std::any_of(known_keys().begin(), known_keys().end(),
                                    [&](const KnownKey& k) { return matches(parts_of(k.path), 0, parts); });
  return is_known ? parts : std::vector<std::string>{};
}

/// How many parts of the row's path a query takes that leaves names of one's own out, as `soil.clumps.inertia` does of
/// `soil.clumps.<name>.inertia`; 0: it leaves none out, or does not fit.
std::size_t depth_without_names(const std::vector<std::string>& row, const std::vector<std::string>& query) {
  std::size_t depth = 0, taken = 0;
  for (; depth < row.size() && taken < query.size(); ++depth) {
    if (row[depth] == "<name>") continue;
    if (row[depth] != query[taken++]) return 0;
  }
  return taken == query.size() && depth > taken ? depth : 0;
}

/// A path that starts too high (`soil.contacts.wet.K_X`) loses its head until something fits; then it may begin
/// anywhere
/// (`wet.K_X`, `K_X`), but not outside of two parts that fit, such as `machine.forces`, and in its own section first.
Rows find_rows(const std::string& path) {
  std::vector<std::string> query = parts_of(without_indices(path));
  const std::vector<std::string> section = section_of(query);
  const std::string head = query[0];
  Rows without_names;
  for (const KnownKey& row : known_keys())
    if (const std::size_t depth = depth_without_names(parts_of(row.path), query); depth > 0)
      without_names.rows.push_back(&row), without_names.depth = depth;
  for (; !query.empty(); query.erase(query.begin())) {
    Rows exact{{}, query.size()}, anywhere, inside;
    for (const KnownKey& row : known_keys()) {
      const std::vector<std::string> parts = parts_of(row.path);
      if (matches(parts, 0, query)) exact.rows.push_back(&row);
      for (std::size_t from = 1; from < parts.size(); ++from) {
        if (from + query.size() != parts.size() || !matches(parts, from, query) || parts[from] != query[0]) continue;
        if (!matches(parts, 0, section)) continue;
        for (Rows* rows : {&anywhere, &inside}) {
          if (rows == &inside && parts[0] != head) continue;
          rows->rows.push_back(&row);
          rows->depth = std::max(rows->depth, parts.size());
        }
      }
    }
    if (!without_names.rows.empty()) return without_names;
    if (!exact.rows.empty()) return exact;
    if (!inside.rows.empty()) return inside;
    if (!anywhere.rows.empty()) return anywhere;
  }
  return {};
}

/// The key itself and one line for each key below it: of those with a name of one's own in their path, what stands
/// below the name.
std::string contents(const Rows& found) {
  std::string text;
  std::size_t depth = found.depth;
  for (const KnownKey* row : found.rows)
    if (parts_of(row->path).size() == depth) text += sentence(*row);
  std::vector<const KnownKey*> below;
  do {
    ++depth, below.clear();
    for (const KnownKey* row : found.rows)
      if (const std::vector<std::string> parts = parts_of(row->path); parts.size() == depth && parts.back() != "<name>")
        below.push_back(row);
  } while (below.empty() && depth < found.depth + 3);
  std::size_t width = 0;
  for (const KnownKey* row : below) width = std::max(width, row->path.size());
  text += "below it (`subsoil explain PATH` prints more):\n";
  for (const KnownKey* row : below) text += fmt::format("  {:<{}}  {}\n", row->path, width, row->meaning);
  return text;
}

}  // namespace

const std::vector<KnownKey>& known_keys() {
  static const std::vector<KnownKey> all = make_keys();
  return all;
}

std::string path_of_key(const std::string& key, const std::string& from) {
  const bool of_test = from.starts_with("test.");
  for (const KnownKey& k : known_keys()) {
    if (k.path.starts_with("test.") != of_test) continue;
    if (k.path == key || (k.path.ends_with("." + key) && k.unit != "type")) return k.path;
  }
  return {};
}

std::string write_scenario(const Scenario& scenario) {
  std::string text = print(scenario, false);
  for (const auto& [file, sum] : scenario.contents) text += fmt::format("{}{}: crc32 {:08x}\n", kContents, file, sum);
  return text;
}

std::map<std::string, std::string> contents_in(const std::string& text) {
  std::map<std::string, std::string> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (const std::size_t end = line.rfind(": "); line.starts_with(kContents) && end != std::string::npos)
      out[line.substr(kContents.size(), end - kContents.size())] = line.substr(end + 2);
  return out;
}

/// A plate pressed into a small cohesive bed: every section that a first soil scenario needs.
std::string new_scenario() {
  Scenario s;
  s.title = "a plate sinks into a small bed";
  s.materials = {{.name = "soil", .density = 1800, .young = {}, .poisson = {}},
                 {.name = "steel", .density = 7850, .young = {}, .poisson = {}}};
  dem::Linear soil;
  soil.k_n = 50e3, soil.restitution = 0.4, soil.friction.mu = 0.5, soil.friction.mu_r = 0.2;
  dem::Linear steel = soil;
  steel.friction.mu = 0.3;
  s.contacts = {{{"soil", "soil"}, soil}, {{"soil", "steel"}, steel}};
  Container container;
  container.size = {0.3, 0.3, 0.3}, container.at = {-0.15, -0.2, -0.15}, container.material = "steel";
  BedSection bed;
  bed.material = "soil";
  bed.radius = EqualRadius{0.01};
  bed.depth = 0.2;
  bed.settle.emplace().until_speed = 0.02;
  s.soil.emplace();
  s.soil->container = container;
  s.soil->surface = 0;
  s.soil->bed = bed;
  BoundarySection plate;
  plate.name = "plate", plate.material = "steel";
  plate.shape = BoxShape{{0.1, 0.01, 0.1}};
  plate.at = {0, 0.02, 0};
  plate.moves = {Move{}};
  plate.moves[0].velocity = {0, -0.1, 0};
  s.boundaries = {plate};
  s.time.end = 0.5;
  s.output.every = 0.02;
  s.output.watch = {{.name = "resistance", .kind = Watch::Kind::soil_force, .of = "plate", .along = {0, 1, 0}}};
  return "# A subsoil scenario. `subsoil explain KEY` prints more about a key, e.g. `subsoil explain "
         "contacts.linear.k_n`;\n"
         "# a `machine` section carries tools on a planar mechanism: `subsoil explain machine`.\n" +
         print(s, true);
}

std::string explain(const std::string& path) {
  if (path.empty()) {
    std::string text = "Sections of a scenario; `subsoil explain PATH` prints more.\n";
    for (const KnownKey& row : known_keys()) {
      if (row.path.find('.') == std::string::npos && !row.path.starts_with("function"))
        text += fmt::format("  {:<12} {}\n", row.path, row.meaning);
    }
    return text;
  }
  if (path == "include" || path.ends_with(".include"))
    return path +
           "\n    a file, or a list of files, merged into this mapping key by key; own keys win, of several files the\n"
           "    earlier one; a key without value removes an included one\n    value:   files\n";
  const Rows found = find_rows(path);
  if (found.rows.empty()) {
    const std::string_view renamed = present_of(parts_of(path).back());
    if (!renamed.empty()) {
      const std::string present = path.substr(0, path.size() - parts_of(path).back().size()) + std::string(renamed);
      if (!find_rows(present).rows.empty())
        return fmt::format("{} is called `{}` now.\n", path, renamed) + explain(present);
    }
    std::vector<std::string> keys, sections;
    const std::vector<std::string> section = section_of(parts_of(without_indices(path)));
    for (const KnownKey& row : known_keys()) {
      const std::vector<std::string> parts = parts_of(row.path);
      if (matches(parts, 0, section)) keys.push_back(parts.back());
      if (parts.size() == 1) sections.push_back(row.path);
    }
    const std::string last = parts_of(without_indices(path)).back();
    throw std::invalid_argument(fmt::format("{}: no key of a scenario{}", path,
                                            nearest(last, keys) ? suggestion(last, keys) : suggestion("", sections)));
  }
  constexpr std::size_t a_screen = 12;
  if (found.rows.size() > a_screen) return contents(found);
  std::string text;
  for (const KnownKey* row : found.rows) text += sentence(*row);
  return text;
}

std::string reference_markdown() {
  std::string text =
      "# The scenario file: every key\n\n"
      "Generated from the declarations that the reader uses (`subsoil reference`); do not edit.\n\n"
      "A value that has a dimension carries its unit: numbers first, then one unit expression (`16 kN/m`, `1 2 3 mm`,\n"
      "`8 deg`, `1434.81 kN/m^(n+1)`). Any unit of the same dimension will do; the column names the dimension.\n"
      "`include: other.yaml` merges another file into a mapping, key by key; own keys win, and a key without value "
      "takes\n"
      "an included one away. YAML's anchors and `<<` work too. Files named inside are found beside the scenario.\n"
      "`<name>` is a name of your own.\n";
  std::string section;
  for (const KnownKey& row : known_keys()) {
    const std::string head = parts_of(row.path)[0];
    const bool leaf = row.path == head && row.unit != "section" && !row.unit.ends_with("mappings");
    const std::string heading = leaf ? "Top level" : head;
    if (heading != section) {
      text += fmt::format("\n## {}\n\n", heading);
      if (heading == "function") {
        text +=
            "Stands wherever a key takes a function of time, without the word `function`: `velocity: {ramp: {to: 0.5 "
            "m/s}}`.\n"
            "U is that key's unit. A list of functions is their sum.\n\n";
      }
      if (heading == "characteristic") {
        text +=
            "Stands wherever a key takes a force over a relative measure, without the word `characteristic`: `spring "
            "curve:\n{polynomial: {c3: 2 kN/mm^3}}`. U is that key's unit, X the measure's.\n\n";
      }
      text += table_head;
    }
    section = heading;
    text += table_row(row);
  }
  for (const CommandFile& file : command_files()) {
    text += fmt::format("\n# {}\n\n{}\n\n{}", file.heading, file.introduction, table_head);
    std::vector<KnownKey> keys;
    KeyList list(keys, "");
    file.declare(list);
    for (const KnownKey& key : keys) text += table_row(key);
  }
  return text;
}

}  // namespace subsoil::sim
