#include <stdexcept>
#include <unordered_map>

#include "libdem/bed_engine.hpp"
#include "libdem/step/bed_impl.hpp"
#include "libdem/step/surface_forces.hpp"

/// A bed whose spheres are stepped by an engine: what stays with the bed, and how spheres come back.
namespace subsoil::dem {

void Bed::step_by(std::unique_ptr<BedEngine> engine) {
  Impl& d = *impl_;
  const auto refuse = [](const char* what) {
    throw std::invalid_argument(std::string("a bed that another engine steps cannot have ") + what);
  };
  if (d.laws.any_bonds()) refuse("bonds");
  if (d.clumps.any()) refuse("clumps");
  if (d.region.on()) refuse("an active region");
  if (d.forces.any()) refuse("forces of a program on its spheres");
  if (d.options.periodic.any()) refuse("periodic sides");
  if (d.particles.is_mixed()) refuse("mixed precision");
  for (const Sphere& s : d.particles.spheres())
    if (is_fixed(s)) refuse("fixed spheres");
  for (const Boundary& b : d.boundaries)
    if (b.loads) refuse("surfaces that keep their loads");
  d.by_engine = {std::move(engine), false, false};
}

const char* Bed::engine_name() const { return impl_->by_engine.engine ? impl_->by_engine.engine->name() : nullptr; }

/// Hands over spheres and contacts; from here on one record of sums stands for all of them.
void Bed::Impl::begin_engine(const State& state) {
  by_engine.engine->begin(state, options, boundaries);
  by_engine.began = true;
  balance.fold(surfaces.chunks);
  contacts.clear(), surfaces.clear();
  criterion.invalidate();
  balance.begin_lists(1);
}

void Bed::Impl::step_by_engine(double dt, const Request& request) {
  for (Boundary& b : boundaries) b.wrench_before = b.wrench;
  const EngineSums sums = by_engine.engine->step({dt, now.dt_before, request.energy, request.snapshot}, boundaries);
  by_engine.ahead = true;
  add_boundary_work(boundaries, now.dt_before);
  BlockSums& all = balance.of_block.front();
  all.lost += sums.lost;
  all.stored = sums.stored, all.pairs = sums.pairs, all.overlap = sums.overlap;
  all.speed2 = sums.speed2, all.squares = sums.squares;
  if (request.energy) all.kinetic = sums.kinetic, all.rotational = sums.rotational, all.potential = sums.gravity;
  balance.removed += sums.removed;
  now.fallen += sums.fallen;
  now.rebuilds += sums.new_lists ? 1 : 0;
  balance.sum_extremes({});
  if (request.energy) balance.sum_energy({}, boundaries, 0, 0, {});
  if (!within_limits()) {  // which sphere it is, lists of our own say
    take_back(true);
    rebuild();
    check_faults();
  }
}

/// Spheres as the engine has them and, where wished for, contacts, which wait as those of a restart do.
void Bed::Impl::take_back(bool with_contacts) {
  const State state = by_engine.engine->collect(with_contacts);
  particles.clear();
  std::unordered_map<std::uint32_t, std::uint32_t> index;
  for (const Sphere& s : state.spheres) {
    if (with_contacts) index[s.id] = static_cast<std::uint32_t>(particles.size());
    particles.restore(checked(s));
  }
  contacts.clear(), surfaces.clear();
  if (with_contacts) take_contacts(state, [&](std::uint32_t id) { return index.at(id); });
  by_engine.ahead = false;
}

}  // namespace subsoil::dem
