#include "libdem/bed.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "libdem/particles/rigid_rotation.hpp"
#include "libdem/step/bed_impl.hpp"
#include "libdem/step/surface_forces.hpp"

namespace subsoil::dem {

Bed::Impl::Impl(LawTable laws_in, BedOptions options_in)
    : options(std::move(options_in)),
      kernel(choose_kernel(options.simd.c_str())),
      threads(options.threads > 0 ? options.threads : omp_get_max_threads()),
      laws(std::move(laws_in), options.precision == Precision::mixed),
      particles(options.precision) {
  bonds.resize(laws);
}

namespace {

/// Throws std::invalid_argument for a table that names laws it does not have, or not the same for (a, b) and (b, a).
LawTable checked(LawTable laws) {
  const auto fail = [](const std::string& text) { throw std::invalid_argument("LawTable: " + text); };
  if (laws.materials < 0) fail("materials = " + std::to_string(laws.materials) + ": must not be negative");
  const auto count = static_cast<std::size_t>(laws.materials);
  if (laws.index.size() != count * count)
    fail("index has " + std::to_string(laws.index.size()) + " entries; " + std::to_string(laws.materials) +
         " materials need " + std::to_string(count * count));
  for (int a = 0; a < laws.materials; ++a)
    for (int b = 0; b < laws.materials; ++b) {
      const std::string pair = "index of materials " + std::to_string(a) + " and " + std::to_string(b);
      if (laws.of(a, b) < -1 || laws.of(a, b) >= static_cast<int>(laws.laws.size()))
        fail(pair + " = " + std::to_string(laws.of(a, b)) + ": there are " + std::to_string(laws.laws.size()) +
             " laws, counted from 0; -1 is none");
      if (laws.of(a, b) != laws.of(b, a)) fail(pair + " is another than the other way round; a pair has one law");
    }
  return laws;
}

}  // namespace

Bed::Bed(LawTable laws, BedOptions options)
    : impl_(std::make_unique<Impl>(checked(std::move(laws)), std::move(options))) {}
Bed::~Bed() = default;
Bed::Bed(Bed&&) noexcept = default;

void Bed::add(std::span<const SphereSpec> spheres) {
  Impl& bed = *impl_;
  bed.balance.fold(bed.surfaces.chunks);
  bed.particles.sync_from_mixed(bed.threads);
  if (bed.particles.size() + spheres.size() > kMostSpheres)
    throw std::invalid_argument("a bed holds " + std::to_string(kMostSpheres) + " spheres at most");
  for (const SphereSpec& in : spheres) bed.particles.add(in, bed.laws.table().materials);
  bed.criterion.invalidate();
}

namespace {

/// Throws std::invalid_argument where a clump asks for a number that a sphere has, or that another asks for.
void require_free_numbers(const Bed::Impl& bed, std::span<const ClumpSpec> clumps) {
  const std::vector<ClumpShape>& shapes = bed.clumps.shapes();
  std::vector<std::array<std::uint32_t, 2>> asked;  // begin and end
  for (const ClumpSpec& c : clumps)
    if (c.number && c.shape >= 0 && static_cast<std::size_t>(c.shape) < shapes.size())
      asked.push_back({*c.number, *c.number + static_cast<std::uint32_t>(
                                                  shapes[static_cast<std::size_t>(c.shape)].members.size())});
  if (asked.empty()) return;
  const auto refuse = [](std::uint32_t id) {
    throw std::invalid_argument("the bed has a sphere of number " + std::to_string(id) + " already");
  };
  std::sort(asked.begin(), asked.end());
  for (std::size_t k = 1; k < asked.size(); ++k)
    if (asked[k][0] < asked[k - 1][1]) refuse(asked[k][0]);
  for (const Sphere& s : bed.particles.spheres()) {
    const auto after = std::upper_bound(asked.begin(), asked.end(), s.id,
                                        [](std::uint32_t id, const auto& range) { return id < range[0]; });
    if (after != asked.begin() && s.id < (*std::prev(after))[1]) refuse(s.id);
  }
}

}  // namespace

int Bed::add_shape(ClumpShape shape) { return impl_->clumps.add_shape(std::move(shape)); }

void Bed::add(std::span<const ClumpSpec> clumps) {
  if (clumps.empty()) return;
  Impl& bed = *impl_;
  bed.balance.fold(bed.surfaces.chunks);
  bed.particles.sync_from_mixed(bed.threads);
  require_free_numbers(bed, clumps);
  for (const ClumpSpec& in : clumps) {
    bed.clumps.add(in, bed.particles, bed.laws.table().materials);
    if (bed.particles.size() > kMostSpheres)
      throw std::invalid_argument("a bed holds " + std::to_string(kMostSpheres) + " spheres at most");
  }
  bed.criterion.invalidate();
}

std::span<const Clump> Bed::clumps() const { return impl_->clumps.all(); }
const std::vector<ClumpShape>& Bed::clump_shapes() const { return impl_->clumps.shapes(); }
long Bed::clump_of(const Sphere& s) const {
  const std::uint32_t c = impl_->clumps.clump_of(s.id);
  return c == kGone ? -1 : static_cast<long>(c);
}
double Bed::mass_of_body(const Sphere& s) const {
  const std::uint32_t clump = impl_->clumps.clump_of(s.id);
  return clump == kGone ? s.m : impl_->clumps.mass_at(clump);
}
double Bed::volume_of(const Sphere& s) const {
  return clump_of(s) < 0 ? sphere_volume(s.r) : impl_->clumps.volume_share(s);
}

int Bed::add(Boundary boundary) {
  const int materials = impl_->laws.table().materials;
  if (boundary.material < 0 || boundary.material >= materials)
    throw std::invalid_argument("boundary '" + boundary.name + "': material " + std::to_string(boundary.material) +
                                ": the laws are of " + std::to_string(materials) + ", counted from 0");
  boundary.pose_before = boundary.pose;
  impl_->boundaries.push_back(std::move(boundary));
  impl_->criterion.invalidate();
  return static_cast<int>(impl_->boundaries.size()) - 1;
}

std::size_t Bed::remove_if(const std::function<bool(const Sphere&)>& predicate) {
  const std::size_t before = impl_->particles.size();
  impl_->rebuild(predicate);
  return before - impl_->particles.size();
}

/// change(sphere) for every sphere, between two steps; how many it has changed. Lists are built anew where any was.
template <class Change>
std::size_t Bed::Impl::change_spheres(const Change& change) {
  balance.fold(surfaces.chunks);
  particles.sync_from_mixed(threads);
  std::size_t count = 0;
  for (Sphere& s : particles.spheres()) count += change(s) ? 1 : 0;
  if (count > 0) criterion.invalidate();
  return count;
}

std::size_t Bed::fix_if(const std::function<bool(const Sphere&)>& predicate) {
  Impl& bed = *impl_;
  bed.particles.sync_from_mixed(bed.threads);
  bed.clumps.choose_leaving(bed.particles.spheres(), -std::numeric_limits<double>::infinity(), predicate);
  const std::size_t count = bed.change_spheres([&](Sphere& s) {
    const std::uint32_t clump = bed.clumps.clump_of(s.id);
    if (is_fixed(s) || !(clump != kGone ? bed.clumps.leaves(clump) : predicate(s))) return false;
    if (clump == kGone) bed.balance.removed += kinetic_energy_of(s) - s.m * dot(bed.options.gravity, s.x);
    s.kind = SphereKind::fixed, s.v = s.w = {};
    return true;
  });
  if (bed.clumps.any()) bed.balance.removed += bed.clumps.take_out(bed.options.gravity);
  return count;
}

void Bed::join(std::span<const Clump> clumps) {
  if (clumps.empty()) return;
  Impl& bed = *impl_;
  std::vector<Clump> added(clumps.begin(), clumps.end());
  for (Clump& c : added) c.velocity = c.angular_momentum = {};
  bed.clumps.join(added);
  const std::size_t joined = bed.change_spheres([&](Sphere& s) {
    const std::uint32_t clump = bed.clumps.clump_of(s.id);
    if (clump == kGone || !is_fixed(s)) return false;
    s.kind = SphereKind::member, s.v = s.w = {};
    return true;
  });
  std::size_t members = 0;
  for (const Clump& c : added) {
    const ClumpShape& shape = bed.clumps.shapes()[c.shape];
    members += shape.members.size();
    bed.balance.removed += shape.mass * dot(bed.options.gravity, c.position);
  }
  if (joined != members)
    throw std::invalid_argument("clumps are joined of " + std::to_string(members) + " spheres, of which " +
                                std::to_string(joined) + " are there and fixed");
}

std::size_t Bed::release_if(const std::function<bool(const Sphere&)>& predicate) {
  return impl_->change_spheres([&](Sphere& s) {
    if (!is_fixed(s) || !predicate(s)) return false;
    s.kind = SphereKind::free, s.v = s.w = {};
    impl_->balance.removed += s.m * dot(impl_->options.gravity, s.x);
    return true;
  });
}

void Bed::count_removed(double energy) { impl_->balance.removed += energy; }

Boundary& Bed::boundary(int index) { return impl_->boundaries.at(static_cast<std::size_t>(index)); }
const Boundary& Bed::boundary(int index) const { return impl_->boundaries.at(static_cast<std::size_t>(index)); }
int Bed::boundary_count() const { return static_cast<int>(impl_->boundaries.size()); }
std::span<const Sphere> Bed::spheres() const {
  if (impl_->by_engine.ahead) impl_->take_back(false);
  impl_->particles.sync_from_mixed(impl_->threads);
  return impl_->particles.spheres();
}
std::shared_ptr<const void> Bed::release_spheres() {
  auto released = std::make_shared<ParticleStore>(impl_->particles);
  std::swap(*released, impl_->particles);
  return released;
}
std::span<const FixedSphere> Bed::fixed_spheres() const { return impl_->fixed.spheres(); }
std::size_t Bed::removed_count() const { return impl_->now.fallen; }
std::size_t Bed::touching_pairs() const { return impl_->balance.extremes().pairs; }

void Bed::step(double dt, const Request& request) {
  if (!(dt > 0)) throw std::invalid_argument("the step of the bed must be positive");
  Impl& bed = *impl_;
  StepCount& now = bed.now;
  const auto end = [&] {
    now.dt_before = dt;
    now.time += dt;
    ++now.steps;
  };
  if (bed.by_engine.engine) {
    if (!bed.by_engine.began) bed.begin_engine(save());
    bed.step_by_engine(dt, request);
    return end();
  }
  PhaseClock clock(bed.measures_phases);
  double search = 0, sweep = 0;

  const bool new_lists = bed.update_neighbours();
  bed.particles.renew_images(bed.threads);
  bed.form_due_bonds(now.time + 0.5 * dt);
  clock.end(search);

  const bool state_asked_for = request.energy || request.snapshot != nullptr;
  bed.balance.plan(bed.options, bed.particles.size(), now.steps, new_lists, state_asked_for || now.steps == 0);
  bed.region.plan(now.steps, dt, norm(bed.options.gravity), new_lists, request.energy, request.snapshot != nullptr,
                  bed.boundaries, bed.particles, bed.balance.of_block, bed.contacts);
  if (bed.forces.any()) bed.forces.begin_step(now.time);
  bed.observed.keep(bed.region, bed.contacts, bed.surfaces, bed.laws, bed.balance.of_block);
  bed.place_boundaries(now.dt_before);
  bed.begin_records(request.contacts);
  bed.sweep(dt, request);  // forces of boundaries, forces of pairs, integrate: fused, particle block by particle block
  bed.observed.put_back_histories(bed.contacts, bed.surfaces);
  bed.move_clumps(dt, request);
  bed.record_broken_bonds(request.snapshot);
  bed.end_records(request.contacts);
  bed.observed.put_back_unasked_sums(bed.surfaces, bed.balance.of_block);
  bed.sum_up(request.energy);
  bed.observed.put_back_sums(bed.surfaces, bed.balance.of_block);
  clock.end(sweep);
  bed.sum_phases(search, sweep);

  bed.forces.throw_fault();
  bed.check_faults();
  end();
}

/// Clumps, whose forces are complete once the sweep is.
void Bed::Impl::move_clumps(double dt, const Request& request) {
  const bool forced = forces.any() && clumps.any();
  SphereForces::Work& work_of_forces = forces.of_clumps();
  if (forced) {
    clumps.add_forces(forces, particles, options.gravity, now.time, now.dt_before, threads);
    work_of_forces.begin_step();
    work_of_forces.until += 0.5 * now.dt_before * clumps.power_of_forces(particles);
  }
  if (request.energy) energy_of_clumps = clumps.energy(region, options.gravity, now.dt_before, dt);
  if (!clumps.any()) return;
  if (request.snapshot != nullptr)
    clumps.complete(*request.snapshot, region, particles, options.gravity, now.dt_before);
  balance.frozen_before += clumps.move(region, particles, options.gravity, now.dt_before, dt, threads);
  if (forced) work_of_forces.ahead = 0.5 * dt * clumps.power_of_forces(particles);
  clumps.extremes(region, contacts.particle_blocks, particles, threads,
                  [&](std::size_t k, double speed2, double squares) {
                    balance.of_block[k].speed2 = speed2, balance.of_block[k].squares = squares;
                    paths.moved(k, std::sqrt(speed2) * dt);
                  });
}

void Bed::Impl::form_due_bonds(double until) {
  if (laws.any_bonds() && bonds.may_form) bonds.form_due(until, contacts, particles, laws);
}

void Bed::Impl::record_broken_bonds(Snapshot* snapshot) {
  if (!laws.any_bonds()) return;
  const std::size_t known = bonds.broken.size();
  bonds.record_broken(now.time, contacts, particles, laws, balance.lost_before.breaking);
  for (std::size_t k = known; k < bonds.broken.size(); ++k)
    bonds.broken[k].position = options.periodic.wrapped(bonds.broken[k].position);
  cut_bonds();
  if (snapshot != nullptr) count_bonds(contacts, laws, particles, *snapshot);
}

void Bed::Impl::cut_bonds() {
  std::vector<EdgeContact> at_edges;
  for (const SurfaceChunk& c : surfaces.chunks) at_edges.insert(at_edges.end(), c.at_edges.begin(), c.at_edges.end());
  if (!at_edges.empty()) bonds.cut(at_edges, contacts, particles, laws, options.periodic);
}

/// Sums over particle blocks and surfaces, in their order.
void Bed::Impl::sum_up(bool energy) {
  balance.sum_extremes(surfaces.chunks);
  criterion.add_path(paths.add_step(contacts.particle_blocks));
  sum_wrenches(boundaries, surfaces, now.dt_before);
  if (fixed.any()) fixed.add_work(now.dt_before);
  if (energy) balance.sum_energy(surfaces.chunks, boundaries, fixed.work(), forces.work(), energy_of_clumps);
}

/// What the threads spent, and what of their time by the clock is left over.
void Bed::Impl::sum_phases(double search, double sweep) {
  if (!measures_phases) return;
  phases.search += search * threads;
  double spent = 0;
  for (const Worker& w : work.workers) {
    phases.pairs += w.spent.pairs, phases.surfaces += w.spent.surfaces, phases.move += w.spent.move;
    spent += w.spent.pairs + w.spent.surfaces + w.spent.move;
  }
  phases.rest += sweep * threads - spent;
}

double Bed::time() const { return impl_->now.time; }
const BedEnergy& Bed::energy() const { return impl_->balance.energy(); }

void Bed::reset_energy_balance() {
  impl_->balance.fold(impl_->surfaces.chunks);
  impl_->balance.reset();
  for (Boundary& b : impl_->boundaries) b.work = 0;
  impl_->fixed.reset_work();
  impl_->forces.reset_work();
}

void Bed::set_laws(LawTable laws) {
  // Histories lie as the laws of now need it: take them out before these go.
  impl_->set_histories_aside();
  impl_->laws.replace(std::move(laws));
  impl_->bonds.resize(impl_->laws);
}
const LawTable& Bed::laws() const { return impl_->laws.table(); }
void Bed::set_gravity(const Vec3& gravity) {
  impl_->options.gravity = gravity;
  impl_->region.check_all();
}

void Bed::set_active(const std::optional<ActiveRule>& rule) {
  if (rule && !(rule->within >= 0 && rule->below >= 0))
    throw std::invalid_argument("active bed: `within` and `below` must be 0 or more");
  if (rule && rule->below == 0 && impl_->options.gravity == Vec3{})
    throw std::invalid_argument("active bed: without gravity `below` must be given");
  if (rule && impl_->forces.any())
    throw std::invalid_argument(
        "active bed: forces of a program on its spheres may change while these sleep; leave one of them out");
  impl_->region.set_rule(rule);
  for (Sphere& s : impl_->particles.spheres()) s.calm = 0;
  impl_->criterion.invalidate();  // what is known of blocks comes with new lists
}
bool Bed::freezes() const { return impl_->region.on(); }
std::size_t Bed::frozen_count() const { return impl_->region.frozen_spheres(); }

void Bed::add_force(std::string name, SphereForce force) {
  const auto refuse = [&](const char* why) { throw std::invalid_argument("force on spheres '" + name + "': " + why); };
  if (impl_->region.on()) refuse("spheres of an active region may sleep; take the active region away");
  if (impl_->by_engine.engine) refuse("another engine steps the spheres; let the bed step them itself");
  impl_->forces.add(std::move(name), std::move(force));
  impl_->criterion.invalidate();  // its work is summed by block of the lists
}
SphereForce& Bed::force(std::string_view name) { return impl_->forces.at(name); }
std::span<const NamedSphereForce> Bed::forces() const { return impl_->forces.all(); }

void Bed::shift(const Vec3& offset) {
  impl_->particles.sync_from_mixed(impl_->threads);
  for (Sphere& s : impl_->particles.spheres()) s.x += offset;
  impl_->clumps.shift(offset);
  impl_->criterion.invalidate();
}

void Bed::freeze() {
  impl_->particles.sync_from_mixed(impl_->threads);
  for (Sphere& s : impl_->particles.spheres()) s.v = s.w = {};
  impl_->clumps.stop();
  impl_->particles.sync_to_mixed(impl_->threads);
  impl_->now.dt_before = 0;
}

void Bed::set_time(double time) { impl_->now.time = time; }
double Bed::max_speed() const { return std::sqrt(impl_->balance.extremes().speed2); }
double Bed::max_overlap() const { return impl_->balance.extremes().overlap; }
std::uint32_t Bed::deepest_sphere() const {
  impl_->particles.sync_from_mixed(impl_->threads);
  return impl_->particles[impl_->deepest_sphere()].id;
}
double Bed::kinetic_energy() const {
  double sum = 0;
  for (const Sphere& s : spheres())
    if (s.kind == SphereKind::free) sum += kinetic_energy_of(s);
  for (const Clump& c : clumps()) {
    const ClumpShape& shape = clump_shapes()[c.shape];
    sum += 0.5 * shape.mass * dot(c.velocity, c.velocity) +
           0.5 * dot(c.angular_momentum, angular_velocity_of(c.attitude, shape.inertia, c.angular_momentum));
  }
  return sum;
}
long Bed::rebuilds() const { return impl_->now.rebuilds; }
long Bed::steps() const { return impl_->now.steps; }
void Bed::measure_phases(bool on) {
  impl_->measures_phases = on;
  impl_->phases = {};
}
Phases Bed::phases() const { return impl_->phases; }
const char* Bed::kernel_name() const { return impl_->kernel.name; }
int Bed::threads() const { return impl_->threads; }
const BedOptions& Bed::options() const { return impl_->options; }
void Bed::set_floor_drop(double y) { impl_->options.floor_drop = y; }
void Bed::surfaces_changed() { impl_->criterion.invalidate(); }
void Bed::set_limits(double speed, double overlap) {
  impl_->options.speed_limit = speed;
  impl_->options.overlap_limit = overlap;
}

void Bed::let_bonds_form() { impl_->bonds.may_form = true; }

void Bed::form_bonds() {
  if (!impl_->lists_hold()) impl_->rebuild();
  impl_->bonds.may_form = true;
  impl_->bonds.form_due(std::numeric_limits<double>::infinity(), impl_->contacts, impl_->particles, impl_->laws);
}

bool Bed::has_bonding_laws() const { return impl_->laws.any_bonds(); }
BondCount Bed::bonds() const { return impl_->bonds.count; }
std::span<const BrokenBond> Bed::broken_bonds() const { return impl_->bonds.broken; }

std::vector<std::array<std::uint32_t, 2>> Bed::bonded_pairs() const {
  std::vector<std::array<std::uint32_t, 2>> out;
  const auto take = [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t i = impl_->particles[a].id, j = impl_->particles[b].id;
    out.push_back({std::min(i, j), std::max(i, j)});
  };
  if (impl_->contacts.empty()) {
    for (const auto& part : impl_->contacts.waiting())
      for (const BondHistory& b : part.bonds) take(b.i, b.j);
  } else {
    each_bond(impl_->contacts, impl_->laws, take);
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace subsoil::dem
