#include "libsim/scenario/sections/output.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "libsim/base/input_limits.hpp"
#include "libsim/document/expression.hpp"
#include "libsim/document/units.hpp"
#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/key_list.hpp"
#include "libsim/keys/nodes.hpp"
#include "libsim/keys/printer.hpp"
#include "libsim/keys/reader.hpp"
#include "libsim/keys/schema.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

void describe(Fields& v, Window& w) {
  v.quantity("from", w.from, "s", "[0, inf)", "left out: the tool has travelled its length plus its depth in soil");
  v.quantity("until", w.until, "s", "(0, inf)", "left out: the tool's tip is one depth from the end wall");
}

void describe(Fields& v, CrossingSection& c) {
  v.text("column", c.column, "a column of the series, a monitor or a measure");
  v.level("at", c.at, "the value, with the column's unit: 30 deg; left out: 0");
  v.choice("direction", c.direction,
           {{"both", CrossingDirection::both},
            {"rising", CrossingDirection::rising},
            {"falling", CrossingDirection::falling}},
           "which passages count");
  v.count("stop after", c.stop_after, "[0, 1000000]", "ends the run at so many passages; 0: never");
}

namespace {

/// Words of `watch`, in the order of Watch::Kind.
constexpr std::array<const char*, 15> watch_words{"column",      "driver",  "force",    "joint",      "soil force",
                                                  "soil moment", "formula", "integral", "derivative", "mean",
                                                  "maximum",     "minimum", "count",    "time above", "time below"};
constexpr std::array<const char*, 3> direction_words{"both", "rising", "falling"};

bool has_window(Watch::Kind kind) {
  return kind == Watch::Kind::mean || kind == Watch::Kind::maximum || kind == Watch::Kind::minimum;
}
/// Of a direction of its own.
bool has_direction(Watch::Kind kind) { return kind >= Watch::Kind::force && kind <= Watch::Kind::soil_moment; }
bool has_level(Watch::Kind kind) { return kind >= Watch::Kind::count; }
bool has_duration(Watch::Kind kind) { return kind >= Watch::Kind::time_above; }

/// Columns of the series that the scenario names.
class WatchList final : public Compound {
 public:
  explicit WatchList(std::vector<Watch>& watches) : watches_(watches) {}
  void read(Reader& reader, const Field& field) override {
    reader.leaf(field, [&](const Node& node) {
      for (const Node::Entry& e : mapping_of(node).entries) {
        watches_.emplace_back().name = e.key;
        reader.check_name(e, reader.child(field.key));
        read_watch(reader, e.value, reader.child(field.key) + "." + e.key);
      }
    });
  }
  void print(Printer& printer, const Field& field) const override {
    if (!watches_.empty()) printer.leaf(field.key, node(), field.meaning, words());
  }
  void list(KeyList& keys, const Field& field) const override {
    keys.add(field.key, "named columns", KeyList::fallback(watches_.empty() ? Node{} : node(), false), words(),
             field.meaning);
  }
  void outline(Schema& schema, const Field& field) const override {
    Json keys = Json::object(), words = Json::array();
    for (const char* word : watch_words) {
      keys[word] = text_form();
      words.push_back({{"required", Json::array({word})}});
    }
    keys["along"] = either({numbers_form("1", 2), numbers_form("1", 3)});
    keys["of"] = {{"type", "object"}, {"additionalProperties", text_form()}};
    keys["unit"] = text_form();
    keys["within"] = number_form("s");
    keys["at"] = text_form();
    keys["direction"] = words_form({"both", "rising", "falling"});
    keys["unbroken"] = words_form({"yes", "no", "true", "false"});
    Json what{{"type", "object"}, {"properties", keys}, {"additionalProperties", false}, {"oneOf", words}};
    for (const char* word : {"of", "unit"}) what["dependencies"][word] = Json::array({"formula"});
    schema.add(field, schema.names_of(either({text_form(), what})));
  }

 private:
  static std::string words() { return fmt::format("{}", fmt::join(watch_words, ", ")); }

  void read_watch(Reader& reader, const Node& node, const std::string& path) {
    Watch& watch = watches_.back();
    reader.reading().places[path] = node.place;
    if (node.kind == Node::Kind::scalar) {
      watch.of = node.scalar;
      return;
    }
    if (node.kind != Node::Kind::mapping) {
      reader.fault(node, path, "must be a column such as shovel.angle, or {driver: H10}");
      return;
    }
    Reader inner(reader.reading(), node, path);
    for (std::size_t i = 0; i < watch_words.size(); ++i) {
      inner.know(watch_words[i]);
      if (!inner.holds(watch_words[i])) continue;
      watch.kind = static_cast<Watch::Kind>(i);
      if (watch.kind == Watch::Kind::soil_moment) watch.along = {0, 0, 1};
      if (watch.kind == Watch::Kind::formula)
        read_formula(inner, watch);
      else
        inner.reference(watch_words[i], watch.of, Family::body, "what is monitored");
    }
    inner.find_type(node, path, {watch_words.begin(), watch_words.end()});
    if (watch.over_time()) {
      read_over_time(inner, watch);
      return inner.finish();
    }
    inner.leaf({"along", "direction"}, [&](const Node& along) {
      if (!has_direction(watch.kind))
        throw Refusal("has no effect without `force`, `joint`, `soil force` or `soil moment`", "leave it out");
      const std::vector<double> d = numbers_of(along, "1", 0);
      if (d.size() != 2 && d.size() != 3) throw Refusal("must be two or three numbers");
      watch.along = {d[0], d[1], d.size() == 3 ? d[2] : 0};
      if (watch.along == Vec3{}) throw Refusal("a direction must not be the zero vector");
    });
    inner.finish();
  }

  static void read_over_time(Reader& inner, Watch& watch) {
    if (has_window(watch.kind))
      inner.quantity("within", watch.within, "s", "(0, inf)", "of the last seconds; left out: since the start");
    if (has_level(watch.kind)) inner.level("at", watch.at, "the value, with the column's unit; left out: 0");
    if (watch.kind == Watch::Kind::count)
      inner.choice("direction", watch.direction,
                   {{"both", CrossingDirection::both},
                    {"rising", CrossingDirection::rising},
                    {"falling", CrossingDirection::falling}},
                   "which passages count");
    if (has_duration(watch.kind)) inner.flag("unbroken", watch.unbroken, "only since it came there last");
  }

  static Node over_time_node(const Watch& watch) {
    Node item = Node::mapping(true);
    item.add(watch_words[static_cast<std::size_t>(watch.kind)], Node::of(watch.of));
    if (watch.within) item.add("within", Node::of(format_quantity(*watch.within, "s")));
    if (!watch.at.empty()) item.add("at", Node::of(watch.at));
    if (watch.direction != CrossingDirection::both)
      item.add("direction", Node::of(direction_words[static_cast<std::size_t>(watch.direction)]));
    if (watch.unbroken) item.add("unbroken", Node::of("yes"));
    return item;
  }

  static void read_formula(Reader& inner, Watch& watch) {
    inner.leaf({"formula", "of the names in `of`, in SI units"}, [&](const Node& text) {
      if (text.kind != Node::Kind::scalar) throw Refusal("must be a formula such as F*v");
      watch.of = text.scalar;
    });
    inner.leaf({"of", "columns that the names of the formula stand for"}, [&](const Node& of) {
      if (of.kind != Node::Kind::mapping) throw Refusal("must give names columns: {F: pull, v: trolley.vx}");
      for (const Node::Entry& e : of.entries) {
        if (e.value.kind != Node::Kind::scalar) throw Refusal("must give each name a column: {F: pull, v: trolley.vx}");
        watch.inputs.emplace_back(e.key, e.value.scalar);
      }
    });
    inner.leaf({"unit", "of the column, such as W or kPa; the formula itself has SI values"}, [&](const Node& unit) {
      if (unit.kind != Node::Kind::scalar) throw Refusal("must be a unit such as W or kPa");
      static_cast<void>(parse_unit(unit.scalar));
      watch.unit = unit.scalar;
    });
  }

  static Node formula_node(const Watch& watch) {
    Node item = Node::mapping(true), of = Node::mapping(true);
    item.add("formula", Node::of(watch.of));
    for (const auto& [name, column] : watch.inputs) of.add(name, Node::of(column));
    item.add("of", std::move(of));
    if (watch.unit != "1") item.add("unit", Node::of(watch.unit));
    return item;
  }

  Node node() const {
    Node node = Node::mapping();
    for (const Watch& watch : watches_) {
      Node item = Node::of(watch.of);
      if (watch.kind == Watch::Kind::formula) {
        item = formula_node(watch);
      } else if (watch.over_time()) {
        item = over_time_node(watch);
      } else if (watch.kind != Watch::Kind::column) {
        item = Node::mapping(true);
        item.add(watch_words[static_cast<std::size_t>(watch.kind)], Node::of(watch.of));
        const bool forces = watch.kind == Watch::Kind::joint || watch.kind == Watch::Kind::soil_force;
        const Vec3 usual = watch.kind == Watch::Kind::soil_moment ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
        if (forces || (has_direction(watch.kind) && watch.along != usual)) {
          const double along[3]{watch.along.x, watch.along.y, watch.along.z};
          item.add("along", Node::of(format_quantities(along, 3, "1")));
        }
      }
      node.add(watch.name, std::move(item));
    }
    return node;
  }
  std::vector<Watch>& watches_;
};

}  // namespace

void describe(Fields& v, Output& o) {
  v.quantity(
      "every", o.every, "s", "(0, inf)",
      "interval of frames; left out: a 200th of the end (of a machine alone 5 ms if that is longer, a 20th of the end "
      "at most), or none with `at`");
  v.quantities("at", o.at, "s", "[0, inf)",
               "further times of frames, which are of these times exactly, between steps too");
  v.quantity(
      "series every", o.series_every, "s", "(0, inf)",
      "interval of the rows of series.csv, which stand at its multiples exactly, shorter than the step too; left "
      "out: 1 ms, or none with `series at`");
  v.quantities("series at", o.series_at, "s", "[0, inf)", "further times of rows; the last row is of the end always");
  v.choice("series digits", o.digits, {{"9", SeriesDigits::nine}, {"all", SeriesDigits::all}},
           "digits of the series with soil; all: numbers that read back to their last bit, as without soil always");
  v.count("sample losses every", o.sample_losses_every, "[0, 1000]",
          "soil steps from one sample of what contacts between spheres and on flat faces lose to the next, which "
          "stands for all between; 0: every step up to 5,000 spheres, else every 32nd, some of the bed in each");
  v.choice(
      "forces", o.forces,
      {{"auto", ForceColumns::automatic}, {"mean", ForceColumns::mean}, {"instant", ForceColumns::instant}},
      "columns of forces and moments in series.csv: means over the interval since the row before, or the values at "
      "its instant; auto: mean with soil, instant without");
  v.words("columns", o.columns,
          {{"position", Column::position},
           {"velocity", Column::velocity},
           {"spin", Column::spin},
           {"force", Column::force},
           {"torque", Column::torque},
           {"contacts", Column::contacts}},
          "what a frame holds of each sphere; force: of contacts and gravity");
  v.flag(
      "contact forces", o.contact_forces,
      "frames hold every contact that carries a force, as a line with that force (force chains): some 40 bytes each");
  v.choice(
      "frames", o.frames,
      {{"auto", FrameFiles::automatic}, {"parts", FrameFiles::parts}, {"gathered", FrameFiles::gathered}},
      "with `engine: liggghts`: parts, each process writes the spheres that it has, or gathered, the first writes all; "
      "auto: parts on several processes");
  v.choice("precision", o.precision, {{"single", OutputPrecision::single}, {"double", OutputPrecision::full}},
           "of the frames");
  v.count("compression", o.compression, "[0, 9]", "0: none, 9: smallest and slowest");
  v.section("region", o.region, "only spheres in this box; left out: all");
  v.quantity("state every", o.state_every, "s", "(0, inf)",
             "interval of full states to start again from; left out: none");
  v.choice("state", o.state, {{"full", State::full}, {"none", State::none}}, "full state at the end");
  WatchList watches(o.watch);
  v.visit_compound({"monitor",
                    "named columns of the series: shovel.angle, {driver: H10}, {soil force: shovel, along: -1 0} "
                    "(along x unless given, a moment about z), "
                    "{formula: F*v, of: "
                    "{F: pull, v: trolley.vx}, unit: W} of columns and of monitors before it, in SI units; over time: "
                    "{integral: power}, {derivative: depth}, {mean: pull, within: 0.5 s}, {maximum: lift}, {minimum: "
                    "lift, within: 1 s}, {count: rod.angle, at: 30 deg, direction: rising}, {time above: pull, at: 3 "
                    "kN, unbroken: yes}"},
                   watches);
  v.named("crossings", o.crossings,
          "instants at which columns pass values, counted in the summary with their times and mean interval, by name: "
          "{bottom: {column: rod.angle, at: -90 deg, direction: falling}}");
  v.section("window", o.window, "time over which the summary takes means");
}

namespace {

struct OutputChecks : Checks {
  const Scenario& s;

  void output() {
    const Output& o = s.output;
    for (const auto& [path, times] : {std::pair("output.at", &o.at), std::pair("output.series at", &o.series_at)})
      for (const double time : *times)
        if (time > s.time.end)
          refuse(path, fmt::format("{} s", time), fmt::format("is after the end of the run at {} s", s.time.end));
    if (s.runs_in_time() && s.time.end > 0) sizes(o);
    if (o.region) positive("output.region.size", o.region->size);
    if (o.window.from && o.window.until && *o.window.from >= *o.window.until) {
      refuse("output.window.until", "must be later than `from`");
    }
    if (s.runs_in_time() && s.time.end > 0) window(o.window);
    for (const Watch& watch : o.watch) this->watch("output.monitor." + watch.name, watch);
  }

  /// A window beyond the end would be cut, or never open, in silence.
  void window(const Window& w) {
    if (w.from && *w.from >= s.time.end)
      refuse("output.window.from", fmt::format("{} s", *w.from),
             fmt::format("is not before the end of the run at {} s: there would be no means", s.time.end));
    else if (w.until && *w.until > s.time.end * (1 + 1e-9))
      refuse("output.window.until", fmt::format("{} s", *w.until),
             fmt::format("is after the end of the run at {} s; leave it out for a window up to the end", s.time.end));
  }

  /// What is written is counted before the first step.
  void sizes(const Output& o) {
    const auto most_rows = static_cast<double>(input_limits().rows);
    const auto most_frames = static_cast<double>(input_limits().frames);
    const double rows = o.row_interval() > 0 ? s.time.end / o.row_interval() : 0,
                 frames = o.every ? s.time.end / *o.every : 0;
    if (rows > most_rows)
      refuse("output.series every", fmt::format("{} s", o.row_interval()),
             fmt::format(
                 "makes {:.3g} rows of series.csv until {} s; at most {:.0e}: make it longer, or the run shorter{}",
                 rows, s.time.end, most_rows, allow_more("rows")));
    if (frames > most_frames)
      refuse("output.every", fmt::format("{} s", *o.every),
             fmt::format("makes {:.3g} frames until {} s; at most {:.0e}: make it longer, or the run shorter{}", frames,
                         s.time.end, most_frames, allow_more("frames")));
  }

  void formula(const std::string& path, const Watch& watch) {
    Names names;
    for (const auto& [name, column] : watch.inputs) names.push_back(name);
    try {
      make_formula_of(watch.of, names);
    } catch (const UnitError& error) {
      refuse(path + ".formula", watch.of, error.what());
    }
  }

  void watch(const std::string& path, const Watch& watch) {
    const MachineSection none, &m = s.machine ? *s.machine : none;
    Names bodies = names_of(m.bodies), joints = names_of(m.joints), drivers = names_of(m.drivers),
          forces = names_of(m.forces), measures = names_of(m.measures), controllers = names_of(m.controllers);
    Names touched = bodies;
    for (const BoundarySection& b : s.boundaries) touched.push_back(b.name);
    for (const Surface& surface : m.surfaces)
      if (surface.touches_soil) touched.push_back(surface.name);
    if (s.soil && s.soil->container) {
      if (watch.kind == Watch::Kind::soil_force) touched.push_back("container");  // all its walls
      for (const std::string& wall : wall_names(*s.soil->container)) touched.push_back(wall);
    }
    if (s.soil && s.soil->bed)
      for (const Particle& p : s.soil->bed->particles)
        if (!p.fixed.empty()) touched.push_back(p.fixed);
    if (s.soil && s.soil->bed && s.soil->bed->rough_floor) touched.emplace_back(rough_floor_name);
    switch (watch.kind) {
      case Watch::Kind::driver:
        refer(path, watch.of, drivers, "driver");
        break;
      case Watch::Kind::force:
        refer(path, watch.of, forces, "force");
        break;
      case Watch::Kind::joint:
        refer(path, watch.of, joints, "joint");
        break;
      case Watch::Kind::soil_force:
      case Watch::Kind::soil_moment:
        refer(path, watch.of, touched, "body or boundary");
        break;
      case Watch::Kind::formula:
        formula(path, watch);
        break;
      default: {
        const std::size_t dot = watch.of.find('.');
        if (dot == std::string::npos) break;  // a column of the whole run, such as an energy
        Names all = touched;
        all.insert(all.end(), {"soil", "energy", "interface"});
        if (s.soil && s.soil->moving) all.emplace_back("window");
        if (s.soil)
          for (const InletSection& inlet : s.soil->inlets) all.push_back(inlet.name);
        if (s.soil && s.soil->bed)
          for (const FibreSection& f : s.soil->bed->fibres) all.push_back(f.name);
        for (const Names* more : {&joints, &drivers, &forces, &measures, &controllers})
          all.insert(all.end(), more->begin(), more->end());
        const std::string owner = watch.of.substr(0, dot);
        if (!holds(all, owner)) {
          refuse(path, watch.of, fmt::format("nothing is named `{}`{}", owner, suggestion(owner, all)));
        }
        break;
      }
    }
  }
};

}  // namespace

void check_output(Checks& checks, const Scenario& s) { OutputChecks{checks, s}.output(); }

}  // namespace subsoil::sim
