#include <atomic>
#include <stdexcept>

#include "libdem/step/bed_impl.hpp"

/// Checkpoints in memory. A copy of the parts, with the lists, in place of numbers that lists are built from again
/// (state.cpp): a coupling that iterates restores a bed several times per step.
namespace subsoil::dem {
namespace {

/// All but what no step changes: a shape may have many triangles.
void copy_motion(const Boundary& from, Boundary& to) {
  to.pose = from.pose, to.velocity = from.velocity, to.angular_velocity = from.angular_velocity;
  to.active = from.active;
  to.wrench = from.wrench, to.meshes = from.meshes;
  to.work = from.work, to.contacts = from.contacts;
  to.loads = from.loads;
  to.wrench_before = from.wrench_before, to.pose_before = from.pose_before;
}

}  // namespace

/// What is left out is of one step alone (observed contacts, jobs, records), of time and threads, or the user's.
void Bed::Impl::copy(const Impl& from) {
  const bool same_lists = contacts.lists() == from.contacts.lists();
  threads = from.threads;
  laws = from.laws;  // cutoffs follow from the spheres of the lists
  particles = from.particles;
  boundaries.resize(from.boundaries.size());
  for (std::size_t b = 0; b < boundaries.size(); ++b) copy_motion(from.boundaries[b], boundaries[b]);
  criterion.copy(from.criterion, same_lists);
  paths = from.paths;
  contacts.copy(from.contacts);
  surfaces.copy(from.surfaces, same_lists);
  bonds = from.bonds;
  balance = from.balance;
  fixed = from.fixed;
  clumps = from.clumps;
  forces = from.forces;
  region = from.region;
  const long sweeps = now.sweeps;
  now = from.now;
  now.sweeps = sweeps;
  energy_of_clumps = from.energy_of_clumps;
}

Bed::Checkpoint::Checkpoint() = default;
Bed::Checkpoint::Checkpoint(Checkpoint&&) noexcept = default;
Bed::Checkpoint& Bed::Checkpoint::operator=(Checkpoint&&) noexcept = default;
Bed::Checkpoint::~Checkpoint() = default;

bool Bed::Checkpoint::is_of(const Bed& bed) const { return bed_ != nullptr && bed_->number == bed.impl_->number; }

Bed::State Bed::Checkpoint::state() const {
  if (bed_ == nullptr) throw std::invalid_argument("the checkpoint is empty");
  return bed_->state();
}

void Bed::save(Checkpoint& out) const {
  const Impl& d = *impl_;
  if (d.by_engine.engine) throw std::invalid_argument("checkpoint: spheres are stepped by an engine of their own");
  if (!out.is_of(*this)) {
    out.bed_ = std::make_unique<Impl>(d.laws.table(), d.options);
    out.bed_->number = d.number;
  }
  out.bed_->copy(d);
}

void Bed::restore(const Checkpoint& to) {
  if (!to.is_of(*this)) throw std::invalid_argument("checkpoint: is of another bed");
  Impl& d = *impl_;
  const bool same_lists = d.contacts.lists() == to.bed_->contacts.lists();
  d.copy(*to.bed_);
  if (!same_lists && !d.contacts.empty())
    d.work.begin_lists(d.contacts, d.surfaces, d.region, d.particles.is_mixed(), d.threads);
}

std::uint64_t Bed::Impl::next_number() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

}  // namespace subsoil::dem
