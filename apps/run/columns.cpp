#include "apps/run/columns.hpp"

#include <algorithm>
#include <cmath>

namespace subsoil::app {

dem::Wrench wrench_at_reference(const dem::Boundary& boundary, const Vec3& reference) {
  return dem::about(boundary.wrench, boundary.pose.position, boundary.pose.to_world(reference));
}

bool is_measure(const MachineSection& machine, const std::string& column) {
  const std::string owner = column.substr(0, column.find('.'));
  return std::any_of(machine.measures.begin(), machine.measures.end(),
                     [&](const NamedMeasure& m) { return m.name == owner; });
}

namespace {
/// A boundary that a given motion moves: its place stands in the series, as a body's does.
bool on_path(const SurfaceRecord& s) { return s.owner == SurfaceRecord::Owner::given && s.moves; }
}  // namespace

std::size_t Columns::add(const std::string& name, const std::string& unit) {
  columns_.push_back({name, unit});
  mean_.push_back(!instant_forces_ && (unit == "N" || unit == "N m"));
  has_means_ = has_means_ || mean_.back() != 0;
  return columns_.size() - 1;
}

void Columns::add_wrench(const std::string& name) {
  for (const char* c : {".Fx", ".Fy", ".Fz"}) summarised_.push_back(add(name + c, "N"));
  for (const char* c : {".Mx", ".My", ".Mz"}) add(name + c, "N m");
}

Columns::Columns(const Loaded& loaded, World& world, coupling::Simulation& simulation)
    : world_(world), simulation_(simulation), instant_forces_(loaded.scenario.instant_forces()) {
  add("time", "s");
  if (world.machine) {
    machine_first_ = columns_.size();
    for (std::size_t i = 0; i < world.machine->column_names().size(); ++i) {
      const std::string& name = world.machine->column_names()[i];
      const std::size_t column = add(name, world.machine->column_units()[i]);
      if (is_measure(*loaded.scenario.machine, name)) summarised_.push_back(column);
    }
    machine_values_.resize(world.machine->column_names().size());
  }
  if (world.bed) {
    for (const coupling::BodySurface& s : world.body_surfaces)
      if (std::find(tool_bodies_.begin(), tool_bodies_.end(), s.body) == tool_bodies_.end())
        tool_bodies_.push_back(s.body);
    body_first_ = columns_.size();
    for (const int body : tool_bodies_) add_wrench(world.machine->system().body_name(body) + ".soil");
    surface_first_ = columns_.size();
    for (const SurfaceRecord& s : world.surfaces) add_wrench(s.name);
    path_first_ = columns_.size();
    for (const SurfaceRecord& s : world.surfaces)
      if (on_path(s))
        for (const char* c : {".x", ".y", ".z"}) add(s.name + c, "m");
    if (world.machine) {
      draft_ = static_cast<int>(add("soil.draft", "N"));
      summarised_.push_back(static_cast<std::size_t>(draft_));
      summarised_.push_back(add("soil.lift", "N"));
    }
    energy_first_ = columns_.size();
    for (const char* term :
         {"kinetic", "spin", "gravity", "stored", "damped", "slid", "rolled", "boundary work", "removed"})
      add(std::string("soil.") + term, "J");
    add("interface.on soil", "J");
    add("interface.on machine", "J");
    add("soil.fastest", "m/s");
    if (world.bed->has_bonding_laws()) {
      bonds_ = static_cast<int>(add("soil.bonds", "1"));
      add("soil.bonds broken in tension", "1");
      add("soil.bonds broken in shear", "1");
      add("soil.broken", "J");
    }
  }
  for (const Watch& watch : loaded.scenario.output.watch) add_watch(watch, loaded);
}

int Columns::find(const std::string& name) const {
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (columns_[i].name == name) return static_cast<int>(i);
  return -1;
}

int Columns::find_or_throw(const std::string& name, const Watch& watch, const Loaded& loaded) const {
  const int found = find(name);
  if (found >= 0) return found;
  std::vector<std::string> known;
  for (const SeriesColumn& c : columns_) known.push_back(c.name);
  throw ScenarioError(loaded.where("output.watch." + watch.name) + " = " + watch.of + ": no column '" + name + "'" +
                      suggestion(name, known));
}

void Columns::add_watch(const Watch& watch, const Loaded& loaded) {
  WatchSource source{.target = 0, .column = -1, .components = {}, .along = watch.along};
  const auto project = [&](const std::string& of, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) source.components.push_back(find_or_throw(of + part, watch, loaded));
  };
  switch (watch.kind) {
    case Watch::Kind::column:
      source.column = find_or_throw(watch.of, watch, loaded);
      break;
    case Watch::Kind::driver:
      source.column = find(watch.of + ".torque");
      if (source.column < 0) source.column = find_or_throw(watch.of + ".force", watch, loaded);
      break;
    case Watch::Kind::force:
      source.column = find(watch.of + ".torque");
      for (const char* name : {".moment", ".N", ".force"})
        if (const int c = find(watch.of + name); c >= 0) source.column = c;
      if (source.column < 0) source.column = find_or_throw(watch.of + ".force", watch, loaded);
      break;
    case Watch::Kind::joint:
      project(watch.of, {".fx", ".fy"});
      break;
    case Watch::Kind::soil_force:
      project(find(watch.of + ".soil.Fx") >= 0 ? watch.of + ".soil" : watch.of, {".Fx", ".Fy", ".Fz"});
      break;
    case Watch::Kind::soil_moment:
      project(find(watch.of + ".soil.Fx") >= 0 ? watch.of + ".soil" : watch.of, {".Mx", ".My", ".Mz"});
      break;
  }
  const int from = source.column >= 0 ? source.column : source.components.front();
  source.target = add(watch.name, columns_[static_cast<std::size_t>(from)].unit);
  source.along = source.along * (1 / dem::norm(source.along));
  summarised_.push_back(source.target);
  watches_.push_back(std::move(source));
}

void Columns::take_watches(std::span<double> row) {
  for (const WatchSource& w : watches_) {
    if (w.column >= 0) {
      row[w.target] = row[static_cast<std::size_t>(w.column)];
      continue;
    }
    double sum = 0;
    for (std::size_t i = 0; i < w.components.size(); ++i)
      sum += w.along[static_cast<int>(i)] * row[static_cast<std::size_t>(w.components[i])];
    row[w.target] = sum;
  }
}

void Columns::take_machine(std::span<double> row, bool means) {
  if (!world_.machine) return;
  world_.machine->columns(machine_values_);
  for (std::size_t i = 0; i < machine_values_.size(); ++i)
    if (is_mean(machine_first_ + i) == means) row[machine_first_ + i] = machine_values_[i];
}

void Columns::take_instant(std::span<double> row) {
  row[0] = simulation_.time();
  take_machine(row, false);
  std::size_t at = path_first_;
  for (const SurfaceRecord& s : world_.surfaces)
    if (on_path(s)) {
      const Vec3 place = simulation_.surface_pose(s.boundary).position;
      for (int d = 0; d < 3; ++d) row[at++] = place[d];
    }
  take_watches(row);
}

void Columns::take_bonds(std::span<double> row, double energy) {
  const dem::BondCount b = world_.bed->bonds();
  const double values[] = {static_cast<double>(b.intact()), static_cast<double>(b.broken_in_tension),
                           static_cast<double>(b.broken_in_shear), energy};
  std::copy(std::begin(values), std::end(values), row.begin() + bonds_);
}

void Columns::take_step(std::span<double> row, bool energies) {
  if (has_means_) take_machine(row, true);
  if (world_.bed) {
    const auto put = [&](std::size_t at, const dem::Wrench& w) {
      for (int d = 0; d < 3; ++d) {
        row[at + static_cast<std::size_t>(d)] = w.force[d];
        row[at + 3 + static_cast<std::size_t>(d)] = w.moment[d];
      }
    };
    Vec3 total;
    for (std::size_t i = 0; i < tool_bodies_.size(); ++i) {
      const dem::Wrench& w = simulation_.soil_on_body(tool_bodies_[i]);
      put(body_first_ + 6 * i, w);
      total += w.force;
    }
    for (std::size_t i = 0; i < world_.surfaces.size(); ++i)
      put(surface_first_ + 6 * i,
          wrench_at_reference(world_.bed->boundary(world_.surfaces[i].boundary), world_.surfaces[i].reference));
    if (draft_ >= 0) {
      row[static_cast<std::size_t>(draft_)] = -total.x;
      row[static_cast<std::size_t>(draft_) + 1] = total.y;
    }
    if (energies) {
      const dem::BedEnergy& e = world_.bed->energy();
      const coupling::InterfaceWork work = simulation_.interface_work();
      const double values[] = {e.kinetic,      e.spin,         e.gravity,       e.stored,
                               e.lost.damping, e.lost.sliding, e.lost.rolling,  e.boundary_work,
                               e.removed,      work.on_soil,   work.on_machine, world_.bed->max_speed()};
      std::copy(std::begin(values), std::end(values), row.begin() + static_cast<std::ptrdiff_t>(energy_first_));
      if (bonds_ >= 0) take_bonds(row, e.lost.breaking);
    }
  }
  take_watches(row);
}

}  // namespace subsoil::app
