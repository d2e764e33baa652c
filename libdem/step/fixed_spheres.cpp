#include "libdem/step/fixed_spheres.hpp"

#include <algorithm>
#include <stdexcept>

namespace subsoil::dem {

void FixedSpheres::find(std::span<const Sphere> spheres) {
  places_.clear(), spheres_.clear(), is_fixed_.clear(), first_.clear();
  for (std::uint32_t i = 0; i < spheres.size(); ++i)
    if (is_fixed(spheres[i])) places_.push_back({i, 0});
  if (places_.empty()) return;
  is_fixed_.assign(spheres.size(), false);
  for (const Place& p : places_) {
    const Sphere& s = spheres[p.sphere];
    is_fixed_[p.sphere] = true;
    const Before* const acted = before(s.id);
    spheres_.push_back(
        {s.id, s.x, s.v, s.w, acted != nullptr ? acted->force : Vec3{}, acted != nullptr ? acted->torque : Vec3{}});
  }
  std::sort(spheres_.begin(), spheres_.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  for (Place& p : places_) {
    const auto at = std::lower_bound(spheres_.begin(), spheres_.end(), spheres[p.sphere].id,
                                     [](const FixedSphere& f, std::uint32_t id) { return f.id < id; });
    p.entry = static_cast<std::uint32_t>(at - spheres_.begin());
  }
}

void FixedSpheres::drop_pairs(NeighbourList& list, const PeriodicImages& images) const {
  if (is_fixed_.empty()) return;
  list.keep_if([&](std::uint32_t i, std::uint32_t j) { return !is_fixed_[i] || !is_fixed_[images.sphere(j)]; });
}

void FixedSpheres::begin_lists(std::span<const ParticleBlock> blocks) {
  if (places_.empty()) return;
  first_.clear();
  std::uint32_t k = 0;
  for (const ParticleBlock& b : blocks) {
    while (k < places_.size() && places_[k].sphere < b.begin) ++k;
    first_.push_back(k);
  }
  first_.push_back(static_cast<std::uint32_t>(places_.size()));
}

const FixedSpheres::Before* FixedSpheres::before(std::uint32_t id) const {
  const auto at =
      std::lower_bound(before_.begin(), before_.end(), id, [](const Before& b, std::uint32_t i) { return b.id < i; });
  return at != before_.end() && at->id == id ? &*at : nullptr;
}

void FixedSpheres::add_work(double elapsed) {
  now_.clear();
  auto b = before_.begin();
  for (const FixedSphere& f : spheres_) {
    while (b != before_.end() && b->id < f.id) ++b;
    if (elapsed > 0 && b != before_.end() && b->id == f.id)
      work_ -= 0.5 * elapsed * (dot(f.force + b->force, f.velocity) + dot(f.torque + b->torque, f.angular_velocity));
    now_.push_back({f.id, f.force, f.torque});
  }
  std::swap(before_, now_);
}

void FixedSpheres::archive(Archive& a) { a("work", work_)("before", before_); }

}  // namespace subsoil::dem
