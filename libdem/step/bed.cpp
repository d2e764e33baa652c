#include "libdem/bed.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>

#include "libdem/step/bed_impl.hpp"

namespace subsoil::dem {

Bed::Impl::Impl(LawTable laws_in, BedOptions options_in)
    : laws(std::move(laws_in)), options(std::move(options_in)), kernel(choose_kernel(options.simd.c_str())) {
  threads = options.threads > 0 ? options.threads : omp_get_max_threads();
  update_laws();
}

void Bed::Impl::update_laws() {
  if (laws.laws.size() > 255) throw std::invalid_argument("more than 255 contact laws in one bed");
  pair_memory.clear(), surface_memory.clear();
  for (const Law& law : laws.laws) {
    pair_memory.push_back(MemoryShape::of(law, is_mixed()));
    surface_memory.push_back(MemoryShape::at_surface(law));
  }
  bonds_formed.resize(laws.laws.size(), 0);
  any_bonds = std::any_of(pair_memory.begin(), pair_memory.end(), [](const MemoryShape& m) { return m.bonds; });
}

void Bed::Impl::update_reach(double largest_radius) {
  law_reach.clear(), surface_reach.clear();
  for (const Law& law : laws.laws) {
    law_reach.push_back(law->pair_cutoff(largest_radius));
    surface_reach.push_back(law->cutoff(largest_radius));
  }
}

Bed::Bed(LawTable laws, BedOptions options) : impl_(std::make_unique<Impl>(std::move(laws), std::move(options))) {}
Bed::~Bed() = default;
Bed::Bed(Bed&&) noexcept = default;

void Bed::add(std::span<const SphereSpec> spheres) {
  impl_->fold_losses();
  impl_->sync_from_mixed();
  if (impl_->spheres.size() + spheres.size() > kMostSpheres)
    throw std::invalid_argument("a bed holds " + std::to_string(kMostSpheres) + " spheres at most");
  for (const SphereSpec& in : spheres) {
    const double m = in.density * sphere_volume(in.radius);
    if (!std::isfinite(dot(in.position, in.position) + dot(in.velocity, in.velocity) + dot(in.spin, in.spin)))
      throw std::invalid_argument("sphere " + std::to_string(impl_->next_id) +
                                  ": position, velocity and spin must be finite");
    if (!(in.radius > 0) || !(m > 0))
      throw std::invalid_argument("sphere " + std::to_string(impl_->next_id) + ": radius and density must be positive");
    if (in.material < 0 || in.material >= impl_->laws.materials)
      throw std::invalid_argument("sphere " + std::to_string(impl_->next_id) + ": no such material");
    impl_->spheres.push_back({in.position, in.radius, in.velocity, m, in.spin, impl_->next_id++,
                              static_cast<std::uint16_t>(in.material), 0});
  }
  impl_->stale = true;
}

int Bed::add(Boundary boundary) {
  boundary.pose_before = boundary.pose;
  impl_->boundaries.push_back(std::move(boundary));
  impl_->stale = true;
  return static_cast<int>(impl_->boundaries.size()) - 1;
}

std::size_t Bed::remove_if(const std::function<bool(const Sphere&)>& predicate) {
  const std::size_t before = impl_->spheres.size();
  impl_->rebuild(predicate);
  return before - impl_->spheres.size();
}

Boundary& Bed::boundary(int index) { return impl_->boundaries.at(static_cast<std::size_t>(index)); }
const Boundary& Bed::boundary(int index) const { return impl_->boundaries.at(static_cast<std::size_t>(index)); }
int Bed::boundary_count() const { return static_cast<int>(impl_->boundaries.size()); }
std::span<const Sphere> Bed::spheres() const {
  impl_->sync_from_mixed();
  return impl_->spheres;
}
std::size_t Bed::removed_count() const { return impl_->removed; }
std::size_t Bed::touching_pairs() const { return impl_->extremes.pairs; }

void Bed::step(double dt, const Request& request) {
  Impl& d = *impl_;
  if (!(dt > 0)) throw std::invalid_argument("the step of the bed must be positive");
  PhaseClock clock(d.measures_phases);
  const bool new_lists = !d.lists_hold();
  if (new_lists)
    d.rebuild();
  else
    d.divide_work_again();
  if (d.any_bonds && d.bonds_may_form) d.form_bonds(d.time + 0.5 * dt);
  double search = 0, sweep = 0;
  clock.end(search);
  d.plan_book(request, new_lists);
  d.run_sweep(dt, request);
  if (d.any_bonds) d.note_broken_bonds();
  if (d.any_bonds && request.snapshot != nullptr) d.count_bonds(*request.snapshot);
  d.sum_up(request);
  clock.end(sweep);
  if (d.measures_phases) d.sum_phases(search, sweep);
  d.check_faults();
  d.dt_before = dt;
  d.time += dt;
  ++d.steps;
}

double Bed::time() const { return impl_->time; }
const BedEnergy& Bed::energy() const { return impl_->energy; }

void Bed::reset_energy_book() {
  impl_->fold_losses();
  impl_->lost_before = {};
  impl_->removed_energy = 0;
  for (Boundary& b : impl_->boundaries) b.work = 0;
}

void Bed::set_laws(LawTable laws) {
  // The memory of contacts lies as the laws of now need it: take it out before they go.
  impl_->put_aside();
  impl_->laws = std::move(laws);
  impl_->update_laws();
}
const LawTable& Bed::laws() const { return impl_->laws; }
void Bed::set_gravity(const Vec3& gravity) { impl_->options.gravity = gravity; }

void Bed::shift(const Vec3& offset) {
  impl_->sync_from_mixed();
  for (Sphere& s : impl_->spheres) s.x += offset;
  impl_->stale = true;
}

void Bed::freeze() {
  impl_->sync_from_mixed();
  for (Sphere& s : impl_->spheres) s.v = s.w = {};
  impl_->sync_to_mixed();
  impl_->dt_before = 0;
}

void Bed::set_time(double time) { impl_->time = time; }
double Bed::max_speed() const { return std::sqrt(impl_->extremes.speed2); }
double Bed::max_overlap() const { return impl_->extremes.overlap; }
double Bed::kinetic_energy() const {
  double sum = 0;
  for (const Sphere& s : spheres()) sum += kinetic_energy_of(s);
  return sum;
}
long Bed::rebuilds() const { return impl_->rebuilds; }
long Bed::steps() const { return impl_->steps; }
void Bed::measure_phases(bool on) {
  impl_->measures_phases = on;
  impl_->phases = {};
}
Phases Bed::phases() const { return impl_->phases; }
const char* Bed::kernel_name() const { return impl_->kernel.name; }
int Bed::threads() const { return impl_->threads; }
const BedOptions& Bed::options() const { return impl_->options; }
void Bed::set_floor_drop(double y) { impl_->options.floor_drop = y; }
void Bed::surfaces_changed() { impl_->stale = true; }
void Bed::set_limits(double speed, double overlap) {
  impl_->options.speed_limit = speed;
  impl_->options.overlap_limit = overlap;
}

}  // namespace subsoil::dem
