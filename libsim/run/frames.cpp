#include "libsim/run/frames.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "libsim/io/frame_parts.hpp"
#include "libsim/run/between.hpp"
#include "libsim/run/columns.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {

RunOptions frame_options(const Scenario& s) {
  RunOptions options;
  options.precision = s.output.precision == OutputPrecision::full ? FramePrecision::float64 : FramePrecision::rounded;
  options.columns.clear();
  for (const Column c : s.output.columns) options.columns.insert(column_names[static_cast<std::size_t>(c)]);
  if (s.output.region) options.region = FrameBox{s.output.region->at, s.output.region->at + s.output.region->size};
  options.compression = static_cast<int>(s.output.compression);
  options.title = s.title;
  return options;
}

double frame_interval(const Scenario& s) {
  if (s.output.every) return *s.output.every;
  if (!s.output.at.empty()) return 0;
  const double film = s.time.end / 200;
  if (s.has_bed()) return film;
  // Of a machine alone a step costs less than a frame.
  constexpr double usual = 5e-3, least = 20;
  return std::max(film, std::min(usual, s.time.end / least));
}

FrameOutput::FrameOutput(const std::filesystem::path& directory, const Scenario& scenario, const World& world,
                         const coupling::Simulation& simulation, const RunProgress* go_on)
    : world_(world),
      simulation_(simulation),
      holds_contacts_(world.bed != nullptr && scenario.output.contact_forces),
      loads_(world),
      drag_(world) {
  ParticleTable table;  // of the run's first instant
  std::vector<OutputSurface> surfaces;
  if (go_on != nullptr)
    table = go_on->particles;
  else
    list_particles(table, scenario);
  list_poured(table, scenario.time.end);
  list_surfaces(surfaces);
  if (scenario.machine) mechanism_.emplace(scenario);
  if (mechanism_) mechanism_->list(surfaces);
  if (table.id.empty() && surfaces.empty()) return;
  RunOptions options = frame_options(scenario);
  options.values = list_measures(scenario);
  writer_ = std::make_unique<RunWriter>(directory, std::move(table), std::move(surfaces), std::move(options),
                                        go_on != nullptr ? go_on->frames : WrittenFrames{}, world.frame_parts);
}

void FrameOutput::list_particles(ParticleTable& table, const Scenario& scenario) {
  for (const Material& m : scenario.materials) table.material_names.push_back(m.name);
  if (!world_.bed) return;
  if (world_.moving) return list_period(table);
  std::vector<const dem::Sphere*> by_id;
  for (const dem::Sphere& sphere : world_.bed->spheres()) by_id.push_back(&sphere);
  std::sort(by_id.begin(), by_id.end(), [](const auto* a, const auto* b) { return a->id < b->id; });
  for (const dem::Sphere* sphere : by_id) {
    table.id.push_back(sphere->id);
    table.radius.push_back(sphere->r);
    const long clump = world_.bed->clump_of(*sphere);
    table.density.push_back(dem::density(*sphere));
    table.material.push_back(sphere->material);
    if (!world_.fibres.empty()) table.fibre.push_back(fibre_of(world_.fibres, sphere->id));
    if (!has_clumps(world_)) continue;
    table.clump.push_back(
        clump < 0 ? -1 : static_cast<std::int32_t>(world_.bed->clumps()[static_cast<std::size_t>(clump)].id));
    table.volume.push_back(world_.bed->volume_of(*sphere));
  }
}

namespace {

template <class T>
void put_in_order(std::vector<T>& values, const std::vector<std::size_t>& order) {
  std::vector<T> out;
  if (values.size() != order.size()) return;  // a column that the table leaves out
  for (const std::size_t k : order) out.push_back(values[k]);
  values = std::move(out);
}

}  // namespace

/// Spheres, of clumps each one, that inlets pour until the end of the run, where the table has them not yet: a run that
/// is continued to a later end has more of them.
void FrameOutput::list_poured(ParticleTable& table, double end) const {
  if (world_.inlets.empty()) return;
  const std::set<std::int64_t> known(table.id.begin(), table.id.end());
  const std::vector<dem::ClumpShape>& shapes = world_.bed->clump_shapes();
  for (const PouredSoil& one : world_.inlets)
    for (const dem::InletGrain& grain : one.inlet.due_by(end + simulation_.step_length())) {
      if (known.contains(grain.body.id)) continue;
      for (const dem::Sphere& s : grain.spheres(shapes)) {
        table.id.push_back(s.id);
        table.radius.push_back(s.r);
        table.density.push_back(dem::density(s));
        table.material.push_back(s.material);
        if (!world_.fibres.empty()) table.fibre.push_back(-1);
        if (!has_clumps(world_)) continue;
        const dem::ClumpShape* const shape = grain.shape < 0 ? nullptr : &shapes[static_cast<std::size_t>(grain.shape)];
        table.clump.push_back(shape == nullptr ? -1 : static_cast<std::int32_t>(grain.body.id));
        table.volume.push_back(shape == nullptr ? dem::sphere_volume(s.r) : shape->volume * s.m / shape->mass);
      }
    }
  std::vector<std::size_t> order(table.id.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return table.id[a] < table.id[b]; });
  put_in_order(table.radius, order), put_in_order(table.density, order), put_in_order(table.material, order);
  put_in_order(table.fibre, order), put_in_order(table.clump, order), put_in_order(table.volume, order),
      put_in_order(table.id, order);
}

/// Spheres of the first period stand for all others.
void FrameOutput::list_period(ParticleTable& table) const {
  const dem::MovingBed& moving = world_.moving->window;
  const dem::PeriodicBlock& block = moving.block();
  const std::vector<long> clump_of = block.clump_of_spheres();
  for (std::size_t i = 0; i < block.size(); ++i) {
    table.id.push_back(static_cast<std::int64_t>(i));
    table.radius.push_back(block.sphere(i).r);
    table.density.push_back(dem::density(block.sphere(i)));
    table.material.push_back(block.sphere(i).material);
    if (!world_.fibres.empty()) table.fibre.push_back(fibre_of(world_.fibres, static_cast<std::uint32_t>(i)));
    if (!block.clumps.empty()) {
      const dem::Sphere& s = block.sphere(i);
      const dem::Clump* const clump = clump_of[i] < 0 ? nullptr : &block.clumps[static_cast<std::size_t>(clump_of[i])];
      const dem::ClumpShape* const shape = clump == nullptr ? nullptr : &block.shapes[clump->shape];
      table.clump.push_back(clump == nullptr ? -1 : static_cast<std::int32_t>(clump->first_sphere));
      table.volume.push_back(shape == nullptr ? dem::sphere_volume(s.r) : shape->volume * s.m / shape->mass);
    }
    table.at_rest.push_back(moving.place_at_rest(static_cast<std::uint32_t>(i)));
  }
  table.period = moving.plan().direction * block.length;
}

void FrameOutput::list_surfaces(std::vector<OutputSurface>& surfaces) {
  const auto add = [&](const std::string& name, const dem::TriangleMesh& mesh, bool moves, const dem::Pose& pose) {
    OutputSurface out{name, mesh.vertices(), {}, moves};
    if (!moves)
      for (Vec3& v : out.vertices) v = pose.to_world(v);
    for (const dem::Triangle& t : mesh.triangles())
      out.triangles.push_back({static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2])});
    surfaces.push_back(std::move(out));
  };
  for (const SurfaceRecord& r : world_.surfaces) {
    const dem::Boundary& b = world_.bed->boundary(r.boundary);
    if (!b.active) continue;  // an opened wall is not there
    shown_.push_back(r.boundary);
    loads_.show(r, surfaces.size());
    add(r.name, dem::drawing(b.shape, 1.0)[r.mesh], r.moves, b.pose);
    surfaces.back().wall = r.owner == SurfaceRecord::Owner::container && r.moves;
  }
  for (const DrawnSurface& d : world_.drawn) add(d.name, d.mesh, true, {});
}

std::vector<FrameValue> FrameOutput::list_measures(const Scenario& scenario) {
  std::vector<FrameValue> values;
  if (!scenario.machine || scenario.machine->measures.empty()) return values;
  const std::vector<std::string>& names = world_.machine->column_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!is_measure(*scenario.machine, names[i])) continue;
    measures_.push_back(i);
    values.push_back({names[i], world_.machine->column_units()[i]});
  }
  return values;
}

/// Everything that is drawn of the machine but what touches soil, whose poses the simulation knows.
void FrameOutput::take_poses(const Poses& poses) {
  for (const DrawnSurface& d : world_.drawn)
    poses_.push_back(coupling::pose_of(poses[static_cast<std::size_t>(d.body)]));
  if (mechanism_) mechanism_->take(poses, poses_, deformed_);
}

dem::Snapshot* FrameOutput::begin(double t) {
  begin_instant(t);
  if (world_.moving) now_.rear = world_.moving->window.rear(), now_.front = world_.moving->window.front();
  for (const int boundary : shown_) now_.surfaces.push_back(simulation_.surface_pose(boundary));
  if (world_.machine) {
    for (int body = 0; body < world_.machine->system().bodies(); ++body) now_.bodies.push_back(simulation_.body(body));
    take_values(world_.machine->now());
  }
  return world_.bed ? &now_.spheres : nullptr;
}

void FrameOutput::begin(double t, const mbd::Instant& at) {
  begin_instant(t);
  for (int body = 0; body < at.system.bodies(); ++body) now_.bodies.push_back(at.body(body));
  take_values(at);
}

void FrameOutput::begin_instant(double t) {
  std::swap(before_, now_);
  now_.t = t;
  now_.surfaces.clear(), now_.bodies.clear(), now_.values.clear();
}

void FrameOutput::take_values(const mbd::Instant& at) {
  if (measures_.empty()) return;
  std::vector<double> columns(world_.machine->column_names().size());
  world_.machine->columns(at, columns);
  for (const std::size_t i : measures_) now_.values.push_back(columns[i]);
}

void FrameOutput::write_poses(double time, const Poses& poses) {
  Instant given;
  given.bodies = poses;
  write_instant(given, {}, time, 0);
}

void FrameOutput::write(double time, long step) { write_instant(at(time), between(time), time, step); }

void FrameOutput::write_instant(const Instant& now, const Between& between, double time, long step) {
  if (!writer_) return;
  poses_ = now.surfaces;
  if (!now.bodies.empty()) take_poses(now.bodies);
  const dem::Snapshot& spheres = now.spheres;
  Frame frame;
  frame.time = time;
  frame.step = step;
  const std::vector<std::int64_t> ids(spheres.id.begin(), spheres.id.end());
  frame.between = between;
  if (world_.frame_parts == nullptr &&
      (writer_->particles().repeats() || !world_.inlets.empty() || ids.size() != writer_->particles().id.size()))
    frame.id = ids;
  if (world_.moving) frame.window = {{now.rear, now.front}};
  frame.position = spheres.position;
  frame.velocity = spheres.velocity;
  frame.spin = spheres.angular_velocity;
  frame.force = spheres.force;
  frame.torque = spheres.torque;
  frame.contacts = spheres.contacts;
  frame.bonds = spheres.bonds;
  frame.surfaces = poses_;
  frame.deformed = deformed_;
  frame.values = now.values;
  const ContactLines lines = holds_contacts_ ? contact_lines(now.contacts, spheres, cell()) : ContactLines{};
  if (holds_contacts_) frame.contact_forces = &lines, drag_.take(time, now.contacts);
  const std::vector<std::vector<FrameField>> loads = loads_.take(now_.t, frame.surfaces.size());
  frame.loads = loads;
  writer_->write(frame);
}

Between FrameOutput::between(double time) const {
  constexpr double close = 1e-6;
  const double step = now_.t - before_.t, w = step > 0 ? (now_.t - time) / step : 0;
  return {step, !(w > close) ? 0 : w > 1 - close ? 1 : w};
}

const FrameOutput::Instant& FrameOutput::at(double time) {
  const auto [step, w] = between(time);
  if (w == 0) return now_;
  if (w == 1) return before_;
  between_.spheres = interpolate(before_.spheres, now_.spheres, step, w, cell(), std::move(between_.spheres));
  between_.rear = before_.rear, between_.front = before_.front;
  between_.surfaces.clear(), between_.bodies.clear(), between_.values.clear();
  for (std::size_t i = 0; i < now_.surfaces.size(); ++i)
    between_.surfaces.push_back(interpolate(before_.surfaces[i], now_.surfaces[i], w));
  for (std::size_t i = 0; i < now_.bodies.size(); ++i)
    between_.bodies.push_back(interpolate(before_.bodies[i], now_.bodies[i], w));
  for (std::size_t i = 0; i < now_.values.size(); ++i)
    between_.values.push_back(w * before_.values[i] + (1 - w) * now_.values[i]);
  const bool same_spheres = before_.spheres.id == now_.spheres.id;
  if (holds_contacts_) between_.contacts = w > 0.5 || !same_spheres ? before_.contacts : now_.contacts;
  return between_;
}

void FrameOutput::archive(Archive& a, bool needed) {
  a.group("frames", [&] {
    a("needed", needed);
    if (needed) archive_now(a);
    if (needed && holds_contacts_) a.group("contacts", [&] { archive_contacts(now_.contacts, a); });
    a("loads", loads_)("fibre drag", drag_);
  });
}

/// Spheres that lie on many processes are here only while a state is made of them.
void FrameOutput::archive_now(Archive& a) {
  FrameParts* const parts = world_.frame_parts;
  if (parts != nullptr && !a.reads()) now_.spheres = parts->gather();
  now_.archive(a);
  if (parts != nullptr && a.reads()) parts->restore(now_.spheres);
  if (parts != nullptr) now_.spheres = {};
}

void FrameOutput::Instant::archive(Archive& a) {
  a("t", t)("rear", rear)("front", front);
  a("id", spheres.id)("radius", spheres.radius)("material", spheres.material)("position", spheres.position)(
      "velocity", spheres.velocity)("angular velocity", spheres.angular_velocity);
  a("force", spheres.force)("torque", spheres.torque)("contacts", spheres.contacts)("bonds", spheres.bonds)("values",
                                                                                                            values);
  std::size_t poses = surfaces.size(), states = bodies.size();
  a("poses", poses)("states", states);
  surfaces.resize(poses), bodies.resize(states);
  for (dem::Pose& p : surfaces) a.group("surfaces", [&] { a("position", p.position)("attitude", p.attitude); });
  for (mbd::BodyState& b : bodies)
    a.group("bodies", [&] { a("r", b.r)("angle", b.angle)("v", b.v)("omega", b.omega); });
}

void FrameOutput::publish(RunProgress& progress) {
  if (!writer_) return;
  progress.frames = writer_->publish();
  progress.particles = writer_->particles();
}

void FrameOutput::finish() {
  if (!writer_) return;
  if (world_.bed) writer_->write_broken_bonds(world_.bed->broken_bonds());
  writer_->finish();
}

}  // namespace subsoil::sim
