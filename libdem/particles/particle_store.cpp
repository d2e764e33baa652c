#include "libdem/particles/particle_store.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "libdem/particles/fixed.hpp"

namespace subsoil::dem {
namespace {

void copy_motion(const MixedSphere& from, Sphere& to) {
  to.x = from.x;
  for (int d = 0; d < 3; ++d) to.v[d] = static_cast<double>(from.v[d]), to.w[d] = static_cast<double>(from.w[d]);
}

}  // namespace

void ParticleStore::set_images(PeriodicImages images) {
  drop_images();
  const std::size_t count = spheres_.size();
  spheres_.resize(count + images.size());
  images_ = std::move(images);
  for (std::size_t k = 0; k < images_.size(); ++k) spheres_[count + k] = spheres_[images_.of[k]];
}

bool ParticleStore::drop_images() {
  const bool any = !images_.empty();
  spheres_.resize(size()), masses_.clear();
  images_ = {};
  return any;
}

void ParticleStore::renew_images(int threads) {
  if (images_.empty()) return;
  const auto number = static_cast<long>(images_.size());
  const std::size_t count = size();
  constexpr long worth_it = 4096;
#pragma omp parallel for num_threads(threads) schedule(static) if (number > worth_it)
  for (long n = 0; n < number; ++n) {
    const auto k = static_cast<std::size_t>(n);
    const auto renew = [&](auto& records) {
      records[count + k] = records[images_.of[k]];
      records[count + k].x += images_.shift[k];
    };
    is_mixed() ? renew(mixed_) : renew(spheres_);
  }
}

Sphere ParticleStore::now(std::uint32_t i) const {
  if (i >= size()) {
    Sphere s = now(images_.sphere(i));
    s.x += images_.shift[i - images_.spheres];
    return s;
  }
  Sphere s = spheres_[i];
  if (spheres_behind_) copy_motion(mixed_[i], s);
  return s;
}

void ParticleStore::stop(std::uint32_t i) {
  if (!is_mixed()) {
    spheres_[i].v = spheres_[i].w = {};
    return;
  }
  for (int d = 0; d < 3; ++d) mixed_[i].v[d] = mixed_[i].w[d] = 0;
}

void ParticleStore::sync_to_mixed(int threads) {
  if (!is_mixed()) return;
  mixed_.resize(spheres_.size());
  const auto count = static_cast<long>(spheres_.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (long k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    mixed_[i] = rounded(spheres_[i], mass_in_contact(static_cast<std::uint32_t>(i)));
  }
}

void ParticleStore::sync_from_mixed(int threads) {
  if (!spheres_behind_) return;
  spheres_behind_ = false;
  const auto count = static_cast<long>(spheres_.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (long i = 0; i < count; ++i)
    copy_motion(mixed_[static_cast<std::size_t>(i)], spheres_[static_cast<std::size_t>(i)]);
}

void ParticleStore::add(const SphereSpec& in, int materials, std::optional<std::uint32_t> number) {
  const double m = in.density * sphere_volume(in.radius);
  const std::uint32_t id = number.value_or(next_id_);
  const auto refuse = [&](const char* rule) {
    throw std::invalid_argument("sphere " + std::to_string(id) + ": " + rule);
  };
  if (!std::isfinite(dot(in.position, in.position) + dot(in.velocity, in.velocity) +
                     dot(in.angular_velocity, in.angular_velocity)))
    refuse("position, velocity and angular velocity must be finite");
  if (!(in.radius > 0) || !(m > 0)) refuse("radius and density must be positive");
  if (in.material < 0 || in.material >= materials) refuse("no such material");
  drop_images();
  slot_of_id_.clear();
  next_id_ = std::max(next_id_, id + 1);
  spheres_.push_back({in.position, in.radius, in.velocity, m, in.angular_velocity, id,
                      static_cast<std::uint16_t>(in.material), in.kind, 0});
}

void ParticleStore::find_masses(bool all_free, const std::function<double(std::uint32_t)>& of_clump) {
  masses_.clear();
  if (all_free) return;
  masses_.resize(spheres_.size());
  for (std::uint32_t i = 0; i < size(); ++i) {
    const Sphere& s = spheres_[i];
    masses_[i] = s.kind == SphereKind::fixed ? kUnyielding * s.m : s.kind == SphereKind::member ? of_clump(i) : s.m;
  }
  for (std::size_t k = 0; k < images_.size(); ++k)
    masses_[size() + k] = masses_[images_.sphere(images_.spheres + static_cast<std::uint32_t>(k))];
}

void ParticleStore::clear() {
  drop_images();
  spheres_.clear(), slot_of_id_.clear();
  spheres_behind_ = false;
  next_id_ = 0;
}

void ParticleStore::restore(const Sphere& s) {
  next_id_ = std::max(next_id_, s.id + 1);
  spheres_.push_back(s), masses_.clear(), slot_of_id_.clear();
}

std::vector<std::uint32_t> ParticleStore::take_out(double floor, const std::function<bool(const Sphere&)>& gone,
                                                   const std::function<void(const Sphere&, bool fell)>& leave,
                                                   int threads) {
  std::vector<std::uint32_t> kept;
  const auto count = static_cast<long>(spheres_.size());
  bool any = static_cast<bool>(gone);
#pragma omp parallel for num_threads(threads) schedule(static) reduction(|| : any)
  for (long i = 0; i < count; ++i) any = any || spheres_[static_cast<std::size_t>(i)].x.y < floor;
  if (!any) return kept;
  slot_of_id_.clear();
  kept.reserve(spheres_.size());
  for (std::uint32_t i = 0; i < spheres_.size(); ++i) {
    const Sphere& s = spheres_[i];
    const bool fell = s.x.y < floor;
    if (!fell && !(gone && gone(s))) {
      if (kept.size() < i) spheres_[kept.size()] = s;
      kept.push_back(i);
      continue;
    }
    leave(s, fell);
  }
  spheres_.resize(kept.size());
  return kept;
}

void ParticleStore::number_slots() {
  if (!slot_of_id_.empty()) return;
  std::uint32_t slot = 0;
  slot_of_id_.assign(next_id_, 0);
  for (const Sphere& s : spheres()) slot_of_id_[s.id] = 1;
  for (std::uint32_t& s : slot_of_id_) s = s != 0 ? slot++ : 0;
}

}  // namespace subsoil::dem
