#include "libsim/run/columns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libmbd/forces/joint_friction.hpp"
#include "libsim/document/expression.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/run/column_table.hpp"
#include "libsim/scenario/mean_columns.hpp"
#include "libsim/setup/machine.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {

bool is_measure(const MachineSection& machine, const std::string& column) {
  const std::string owner = column.substr(0, column.find('.'));
  return std::any_of(machine.measures.begin(), machine.measures.end(),
                     [&](const NamedMeasure& m) { return m.name == owner; });
}

std::size_t Columns::add(const std::string& name, const std::string& unit, bool whole) {
  columns_.push_back({name, unit});
  whole_.push_back(whole);
  const auto unit_of = [&](const std::string& of) {
    const int found = find(of);
    return found < 0 ? std::string() : columns_[static_cast<std::size_t>(found)].unit;
  };
  mean_.push_back(is_mean_column(scenario_, name, unit_of));
  has_means_ = has_means_ || mean_.back() != 0;
  return columns_.size() - 1;
}

template <class Owner>
void Columns::add(const ColumnFamily<Owner>& family, const std::string& owner, const Owner& of) {
  for (const ColumnOf<Owner>& c : family.columns) {
    const std::size_t column = add(owner.empty() ? c.name : owner + "." + c.name, c.unit, c.whole);
    if (c.in_summary) summarised_.push_back(column);
    if (c.of_machine) of_machine_instant_.push_back(column);
    sources_[static_cast<int>(family.taken)].push_back({column, [from = ColumnSources{world_, simulation_, *buried_},
                                                                 of, value = c.value] { return value(from, of); }});
  }
}

namespace {
bool uses(const Watch& watch, const std::string& column) {
  if (watch.kind != Watch::Kind::formula) return watch.of == column;
  return std::any_of(watch.inputs.begin(), watch.inputs.end(), [&](const auto& i) { return i.second == column; });
}

/// Monitors as they are given, but those behind the ones that they use: an included file's come behind one's own.
std::vector<Watch> in_order_of_use(const Loaded& loaded) {
  std::vector<Watch> out, left = loaded.scenario.output.watch;
  while (!left.empty()) {
    const auto ready = std::find_if(left.begin(), left.end(), [&](const Watch& watch) {
      return std::none_of(left.begin(), left.end(),
                          [&](const Watch& other) { return other.name != watch.name && uses(watch, other.name); });
    });
    if (ready == left.end())
      throw ScenarioError(loaded.where("output.monitor." + left.front().name) +
                          ": uses monitors that use it: a circle; let one of them be of a column");
    out.push_back(*ready);
    left.erase(ready);
  }
  return out;
}
}  // namespace

Columns::Columns(const Loaded& loaded, World& world, coupling::Simulation& simulation)
    : world_(world),
      simulation_(simulation),
      scenario_(loaded.scenario),
      buried_(std::make_unique<BuriedFibres>(world)) {
  add("time", "s");
  if (world.machine) {
    machine_first_ = columns_.size();
    for (std::size_t i = 0; i < world.machine->column_names().size(); ++i) {
      const std::string& name = world.machine->column_names()[i];
      const std::size_t column = add(name, world.machine->column_units()[i], world.machine->column_is_whole(i));
      if (is_measure(*loaded.scenario.machine, name)) summarised_.push_back(column);
      if (!is_mean(column)) of_machine_instant_.push_back(column);
    }
    machine_values_.resize(world.machine->column_names().size());
  }
  if (world.bed) add_soil();
  for (const Watch& watch : in_order_of_use(loaded)) {
    add_watch(watch, loaded);
    watches_.back().of_machine = is_of_machine(watches_.back());
  }
  for (const SeriesColumn& c : columns_) {
    const auto same = [&](const SeriesColumn& other) { return other.unit == c.unit; };
    unit_of_.push_back(
        static_cast<std::size_t>(std::find_if(columns_.begin(), columns_.end(), same) - columns_.begin()));
  }
}

Columns::~Columns() = default;

void Columns::add_soil() {
  std::vector<int> bodies;
  for (const coupling::BodySurface& s : world_.body_surfaces)
    if (std::find(bodies.begin(), bodies.end(), s.body) == bodies.end()) bodies.push_back(s.body);
  for (const int body : bodies)
    add(soil_on_body_columns, world_.machine->system().body_name(body) + ".soil", SoilOnBody{body});
  for (const SurfaceRecord& s : world_.surfaces) add(surface_columns, s.name, s);
  for (const FixedBody& f : world_.fixed) add(fixed_columns, f.name, f);
  for (const SurfaceRecord& s : world_.surfaces)
    if (s.owner == SurfaceRecord::Owner::given && s.moves) add(path_columns, s.name, s);
  for (const coupling::GivenMotion& m : world_.motions)
    if (m.servo)
      for (const SurfaceRecord& s : world_.surfaces)
        if (s.boundary == m.boundary) add(servo_columns, s.name, s);
  if (world_.machine) add(draft_columns, draft_columns.owner, SoilAsWhole{});
  add(bed_columns, bed_columns.owner, SoilAsWhole{});
  if (world_.bed->has_bonding_laws()) add(bond_columns, bond_columns.owner, SoilAsWhole{});
  if (!world_.bed->forces().empty()) add(force_columns, force_columns.owner, SoilAsWhole{});
  if (world_.bed->freezes()) add(frozen_columns, frozen_columns.owner, SoilAsWhole{});
  if (world_.moving) add(window_columns, window_columns.owner, SoilAsWhole{});
  for (std::size_t k = 0; k < world_.inlets.size(); ++k) add(inlet_columns, world_.inlets[k].name, InletOfWorld{k});
  for (std::size_t k = 0; k < world_.fibres.size(); ++k) add(fibre_columns, world_.fibres[k].name, FibresOfWorld{k});
}

int Columns::find(const std::string& name) const {
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (columns_[i].name == name) return static_cast<int>(i);
  return -1;
}

std::size_t Columns::find_or_throw(const std::string& name, const std::string& path, const Loaded& loaded) const {
  const int found = find(name);
  if (found >= 0) return static_cast<std::size_t>(found);
  std::vector<std::string> known;
  for (const SeriesColumn& c : columns_) known.push_back(c.name);
  throw ScenarioError(loaded.where(path) + " = " + name + ": no column '" + name + "'" + suggestion(name, known));
}

bool Columns::is_sum(std::size_t column) const {
  const auto& sums = sources_[static_cast<int>(Taken::sample)];
  const auto is_one = [&](std::size_t c) {
    return std::any_of(sums.begin(), sums.end(), [&](const Source& s) { return s.column == c; });
  };
  const auto of_sum = [&](std::size_t input) { return input < column && is_sum(input); };
  return is_one(column) || std::any_of(watches_.begin(), watches_.end(), [&](const WatchSource& w) {
           return w.target == column && ((w.column >= 0 && of_sum(static_cast<std::size_t>(w.column))) ||
                                         std::any_of(w.inputs.begin(), w.inputs.end(), of_sum));
         });
}

void Columns::add_formula(const Watch& watch, const Loaded& loaded) {
  WatchSource source{.target = 0, .column = -1, .components = {}, .along = {}};
  std::vector<std::string> names;
  std::vector<std::size_t> inputs;
  std::vector<Unit> units;  // a formula is of SI values; columns of monitors may be in other units
  for (const auto& [name, column] : watch.inputs) {
    names.push_back(name);
    inputs.push_back(find_or_throw(column, "output.monitor." + watch.name + ".of." + name, loaded));
    units.push_back(parse_unit(columns_[inputs.back()].unit));
  }
  source.inputs = inputs;
  source.formula = [formula = make_formula_of(watch.of, names), inputs, units, unit = parse_unit(watch.unit),
                    values = std::vector<double>(inputs.size())](std::span<const double> row) mutable {
    for (std::size_t i = 0; i < inputs.size(); ++i) values[i] = units[i].to_si(row[inputs[i]]);
    return unit.from_si(formula(values.data()));
  };
  source.target = add(watch.name, watch.unit);
  source.averaged = is_mean(source.target);
  has_averaged_ = has_averaged_ || source.averaged;
  summarised_.push_back(source.target);
  watches_.push_back(std::move(source));
}

double Columns::noise_of(std::size_t column) const {
  constexpr double share = 0.1;  // of the error asked for: what sticks has a hundredth of it left, or less
  const std::string& unit = columns_[column].unit;
  const bool moves = unit == "m" || unit == "rad" || unit == "m/s" || unit == "rad/s";
  if (!world_.machine || !moves) return 0;
  return share * atol_of(scenario_);
}

// Over less a difference of values of size 1 has fewer than seven digits, with steps of a millisecond.
constexpr double share_of_step = 1e-6;

void Columns::add_history(const Watch& watch, const Loaded& loaded) {
  const std::string path = "output.monitor." + watch.name;
  WatchSource source{.target = 0, .column = -1, .components = {}, .along = {}};
  const std::size_t of = find_or_throw(watch.of, path, loaded);
  const std::string unit = columns_[of].unit;
  History::Rule rule{.kind = watch.kind,
                     .unbroken = watch.unbroken,
                     .held = is_mean(of),
                     .noise = noise_of(of),
                     .shortest = share_of_step * simulation_.step_length()};
  if (watch.within) rule.within = *watch.within;
  rule.rising = watch.direction != CrossingDirection::falling;
  rule.falling = watch.direction != CrossingDirection::rising;
  try {
    if (!watch.at.empty()) rule.level = parse_quantity_in(watch.at, unit);
  } catch (const UnitError& error) {
    throw ScenarioError(loaded.where(path + ".at") + " = " + watch.at + ": " + error.what());
  }
  source.kind = watch.kind;
  source.column = static_cast<int>(of);
  source.history = static_cast<int>(histories_.size());
  histories_.emplace_back(rule);
  const bool time = watch.kind == Watch::Kind::time_above || watch.kind == Watch::Kind::time_below;
  source.target = add(watch.name, watch.kind == Watch::Kind::integral     ? unit_times_second(unit)
                                  : watch.kind == Watch::Kind::derivative ? unit_per_second(unit)
                                  : watch.kind == Watch::Kind::count      ? "1"
                                  : time                                  ? "s"
                                                                          : unit);
  summarised_.push_back(source.target);
  watches_.push_back(std::move(source));
}

/// Owners of the columns that hold what the soil does to a body, a boundary, a wall, or to all walls of the container.
std::vector<std::string> Columns::borne_by(const std::string& of) const {
  if (of != "container") return {find(of + ".soil.Fx") >= 0 ? of + ".soil" : of};
  std::vector<std::string> walls;
  for (const SurfaceRecord& s : world_.surfaces)
    if (s.owner == SurfaceRecord::Owner::container) walls.push_back(s.name);
  return walls;
}

// Of a force with two components; empty: it is one number.
std::vector<std::string> Columns::force_components(const std::string& of) const {
  for (const std::vector<std::string>& parts : {std::vector<std::string>{".fx", ".fy"}, {".force x", ".force y"}})
    if (find(of + parts[0]) >= 0) return parts;
  return {};
}

int Columns::force_column(const Watch& watch, const Loaded& loaded) const {
  const std::string path = "output.monitor." + watch.name;
  if (watch.along != dem::Vec3{1, 0, 0})
    throw ScenarioError(loaded.where(path) + ": `along` is for forces with components; that of `" + watch.of +
                        "` is one number");
  const auto& forces = world_.machine->system().model().forces;
  const auto it = std::find_if(forces.begin(), forces.end(), [&](const auto& f) { return f.name == watch.of; });
  const auto* const friction = it == forces.end() ? nullptr : it->element.get_if<mbd::JointFriction>();
  if (friction != nullptr && !friction->slides) return find(watch.of + ".torque");
  for (const char* name : {".force", ".torque", ".N", ".normal force"})
    if (const int c = find(watch.of + name); c >= 0) return c;
  std::string known;
  for (const SeriesColumn& c : columns_)
    if (c.name.rfind(watch.of + ".", 0) == 0) known += (known.empty() ? "" : ", ") + c.name;
  throw ScenarioError(loaded.where(path) + " = " + watch.of +
                      ": it has no force of one kind; monitor one of its columns, " + known);
}

void Columns::add_watch(const Watch& watch, const Loaded& loaded) {
  if (watch.kind == Watch::Kind::formula) return add_formula(watch, loaded);
  if (watch.over_time()) return add_history(watch, loaded);
  WatchSource source{.target = 0, .column = -1, .components = {}, .along = watch.along};
  const auto index_of = [&](const std::string& name) {
    return static_cast<int>(find_or_throw(name, "output.monitor." + watch.name, loaded));
  };
  const auto project = [&](const std::string& of, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) source.components.push_back(index_of(of + part));
  };
  switch (watch.kind) {
    case Watch::Kind::column:
      source.column = index_of(watch.of);
      break;
    case Watch::Kind::driver:
      source.column = find(watch.of + ".torque");
      if (source.column < 0) source.column = index_of(watch.of + ".force");
      break;
    case Watch::Kind::force:
      if (const std::vector<std::string> parts = force_components(watch.of); !parts.empty())
        project(watch.of, parts);
      else
        source.column = force_column(watch, loaded);
      break;
    case Watch::Kind::joint:
      project(watch.of, {".fx", ".fy"});
      break;
    case Watch::Kind::soil_force:
      for (const std::string& of : borne_by(watch.of)) project(of, {".Fx", ".Fy", ".Fz"});
      break;
    case Watch::Kind::soil_moment:
      for (const std::string& of : borne_by(watch.of)) project(of, {".Mx", ".My", ".Mz"});
      break;
    default:
      break;
  }
  const int from = source.column >= 0 ? source.column : source.components.front();
  source.target = add(watch.name, columns_[static_cast<std::size_t>(from)].unit);
  source.along = source.along * (1 / dem::norm(source.along));
  summarised_.push_back(source.target);
  watches_.push_back(std::move(source));
}

bool Columns::is_of_machine(const WatchSource& w) const {
  const auto one = [&](std::size_t column) {
    return std::find(of_machine_instant_.begin(), of_machine_instant_.end(), column) != of_machine_instant_.end() ||
           std::any_of(watches_.begin(), watches_.end(),
                       [&](const WatchSource& other) { return other.target == column && other.of_machine; });
  };
  return !w.averaged && ((w.column >= 0 && one(static_cast<std::size_t>(w.column))) ||
                         std::any_of(w.inputs.begin(), w.inputs.end(), one) ||
                         std::any_of(w.components.begin(), w.components.end(),
                                     [&](int c) { return one(static_cast<std::size_t>(c)); }));
}

double Columns::value_of(const WatchSource& w, std::span<const double> row) const {
  if (w.history >= 0) return w.kind == Watch::Kind::count ? std::floor(row[w.target] + 1e-9) : row[w.target];
  if (w.column >= 0) return row[static_cast<std::size_t>(w.column)];
  if (w.formula) return w.formula(row);
  double sum = 0;
  for (std::size_t i = 0; i < w.components.size(); ++i)
    sum += w.along[static_cast<int>(i % 3)] * row[static_cast<std::size_t>(w.components[i])];
  return sum;
}

void Columns::take_watches(std::span<double> row) const {
  for (const WatchSource& w : watches_)
    if (!w.averaged) row[w.target] = value_of(w, row);
}

bool Columns::of_history(std::size_t column) const {
  return std::any_of(watches_.begin(), watches_.end(), [&](const WatchSource& w) {
    if (w.target != column) return false;
    const auto is = [&](std::size_t input) { return input < column && of_history(input); };
    return w.history >= 0 || (w.column >= 0 && is(static_cast<std::size_t>(w.column))) ||
           std::any_of(w.inputs.begin(), w.inputs.end(), is);
  });
}

bool Columns::history_needs_sums() const {
  return std::any_of(watches_.begin(), watches_.end(), [&](const WatchSource& w) {
    return w.history >= 0 && is_sum(static_cast<std::size_t>(w.column));
  });
}

void Columns::follow(double t, std::span<double> row, std::span<double> middle) {
  for (const WatchSource& w : watches_) {
    if (w.averaged) continue;
    if (w.history < 0) {
      row[w.target] = value_of(w, row);
      if (!middle.empty()) middle[w.target] = value_of(w, middle);
      continue;
    }
    const auto of = static_cast<std::size_t>(w.column);
    History& history = histories_[static_cast<std::size_t>(w.history)];
    const double before = history.value();
    if (machine_stands_ || !w.of_machine)
      history.add(t, row[of], middle.empty() ? std::numeric_limits<double>::quiet_NaN() : middle[of]);
    row[w.target] = history.value();
    if (!middle.empty()) middle[w.target] = 0.5 * (before + history.value());
  }
}

void Columns::follow_back(double t, std::span<double> row, bool of_machine) const {
  for (const WatchSource& w : watches_) {
    if (w.averaged) continue;
    if (w.history >= 0 && w.of_machine == of_machine)
      row[w.target] = histories_[static_cast<std::size_t>(w.history)].at(t);
    row[w.target] = value_of(w, row);
  }
}

void Columns::rounding_of(const mbd::Instant& at, std::span<const double> row, std::vector<double>& out) const {
  constexpr double share = 1e-12;
  const Eigen::VectorXd& reactions = at.state.lambda;
  const double force = reactions.size() > 0 ? reactions.cwiseAbs().maxCoeff() : 0;
  out.assign(row.size(), 0);
  for (std::size_t i = 0; i < row.size(); ++i) {
    double& largest = out[unit_of_[i]];
    if (columns_[i].unit == "N" || columns_[i].unit == "N m") largest = std::max(largest, force);
    if (std::isfinite(row[i])) largest = std::max(largest, std::abs(row[i]));
  }
  for (std::size_t i = row.size(); i-- > 0;) out[i] = share * out[unit_of_[i]];
}

void Columns::request(std::vector<mbd::Request>& out) const {
  for (const WatchSource& w : watches_)
    if (w.history >= 0 && !of_history(static_cast<std::size_t>(w.column)))
      histories_[static_cast<std::size_t>(w.history)].request(static_cast<std::size_t>(w.column), out);
}

void Columns::archive_histories(Archive& a) {
  if (histories_.empty()) return;  // runs without are kept as they always were
  a("histories", histories_);
}

void Columns::take_machine(const mbd::Instant& at, std::span<double> row, bool means) {
  world_.machine->columns(at, machine_values_);
  for (std::size_t i = 0; i < machine_values_.size(); ++i)
    if (is_mean(machine_first_ + i) == means) row[machine_first_ + i] = machine_values_[i];
}

void Columns::take(Taken when, std::span<double> row) const {
  buried_->begin_instant();
  for (const Source& s : sources_[static_cast<int>(when)]) row[s.column] = s.value();
}

void Columns::take_instant(std::span<double> row) {
  machine_stands_ = simulation_.window_begins();
  if (world_.machine) return take_instant(simulation_.time(), world_.machine->now(), row);
  row[0] = simulation_.time();
  keep_step_begin(row);
  take(Taken::instant, row);
  take_watches(row);
}

void Columns::take_instant(double t, const mbd::Instant& at, std::span<double> row) {
  row[0] = t;
  take_machine(at, row, false);
  keep_step_begin(row);
  take(Taken::instant, row);
  take_watches(row);
}

void Columns::keep_step_begin(std::span<double> row) {
  if (!has_averaged_) return;
  step_begin_.resize(row.size());
  for (std::size_t i = 0; i < machine_values_.size(); ++i) step_begin_[machine_first_ + i] = machine_values_[i];
}

// Without soil forces change within the step: that of its middle is their mean to second order, whatever jumps at its
// ends.
void Columns::take_machine_means(std::span<double> row) {
  if (!world_.machine) return;
  const double begin = row[0], end = simulation_.time();
  if (world_.bed || !(end > begin)) return take_machine(world_.machine->now(), row, true);
  if (!middle_) middle_ = std::make_unique<mbd::Evaluation>(world_.machine->evaluation());
  take_machine(middle_->evaluate(world_.machine->dense_output(), 0.5 * (begin + end)), row, true);
}

void Columns::take_step(std::span<double> row, bool energies) {
  if (has_means_) take_machine_means(row);
  take(Taken::step, row);
  if (energies) take(Taken::sample, row);
  take_watches(row);
  if (has_averaged_) take_averaged(row);
}

// Without soil both rows are of the middle of the step, as the forces are: machine_values_ holds it.
void Columns::take_middle(std::span<const double> row) {
  step_begin_.assign(row.begin(), row.end());
  step_begin_[0] = 0.5 * (row[0] + simulation_.time());
  std::copy(machine_values_.begin(), machine_values_.end(),
            step_begin_.begin() + static_cast<std::ptrdiff_t>(machine_first_));
  step_end_ = step_begin_;
}

void Columns::take_ends(std::span<const double> row) {
  const std::size_t machine_end = machine_first_ + machine_values_.size();
  for (std::size_t c = 0; c < row.size(); ++c)
    if (machine_values_.empty() || c < machine_first_ || c >= machine_end) step_begin_[c] = row[c];
  step_end_.assign(row.begin(), row.end());
  step_end_[0] = simulation_.time();
  if (world_.machine) take_machine(world_.machine->now(), step_end_, false);
  take(Taken::instant, step_end_);
}

void Columns::take_averaged(std::span<double> row) {
  world_.bed ? take_ends(row) : take_middle(row);
  for (const WatchSource& w : watches_) {
    if (w.history >= 0) continue;
    step_begin_[w.target] = value_of(w, step_begin_), step_end_[w.target] = value_of(w, step_end_);
    if (w.averaged) row[w.target] = 0.5 * (step_begin_[w.target] + step_end_[w.target]);
  }
}

}  // namespace subsoil::sim
