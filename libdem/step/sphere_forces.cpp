#include "libdem/step/sphere_forces.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "libdem/base/fault.hpp"

namespace subsoil::dem {

void SphereForces::add(std::string name, SphereForce force) {
  if (name.empty() || name.find('/') != std::string::npos)
    throw std::invalid_argument("force on spheres '" + name + "': its name must have a letter and no '/'");
  for (const NamedSphereForce& f : forces_)
    if (f.name == name) throw std::invalid_argument("force on spheres '" + name + "': the bed has one of this name");
  forces_.push_back({std::move(name), std::move(force)});
}

SphereForce& SphereForces::at(std::string_view name) {
  for (NamedSphereForce& f : forces_)
    if (f.name == name) return f.force;
  throw std::invalid_argument("force on spheres '" + std::string(name) + "': the bed has none of this name");
}

void SphereForces::begin_lists(std::size_t blocks) {
  for (const Work& w : blocks_) before_ += w.all();
  blocks_.assign(any() ? blocks : 0, {});
}

void SphereForces::begin_step(double time) {
  for (NamedSphereForce& f : forces_) f.force.begin_step(time);
}

Wrench SphereForces::sum(const SphereAt& s) const {
  Wrench total;
  for (const NamedSphereForce& f : forces_) {
    const Wrench w = f.force(s);
    if (!std::isfinite(dot(w.force, w.force) + dot(w.moment, w.moment))) {
      char text[400];
      std::snprintf(text, sizeof text,
                    "the force '%s' on sphere %u at (%.6g, %.6g, %.6g) m is (%.3g, %.3g, %.3g) N and (%.3g, %.3g, "
                    "%.3g) N m: both must be finite; look at what the program computes there",
                    f.name.c_str(), s.id, s.position.x, s.position.y, s.position.z, w.force.x, w.force.y, w.force.z,
                    w.moment.x, w.moment.y, w.moment.z);
      throw BedFault({BedFault::Kind::force, s.time, s.id}, text);
    }
    total += w;
  }
  return total;
}

Wrench SphereForces::on_free(SphereAt s, double push, double turn) {
  try {
    const Motion without{s.velocity, s.angular_velocity};
    Motion motion = without;
    Wrench load;
    const double ratio = find_motion(motion, [&](const Motion& at) {
      s.velocity = at.velocity, s.angular_velocity = at.angular_velocity;
      load = sum(s);
      return Motion{without.velocity + push * load.force, without.angular_velocity + turn * load.moment};
    });
    if (!(ratio < 0)) refuse_step(s, ratio);
    return load;
  } catch (...) {
    note_fault(s.id);
    return {};
  }
}

void SphereForces::refuse_step(const SphereAt& s, double ratio) {
  constexpr double most = 0.5;  // of 64 substitutions rounding is left
  char text[400];
  std::snprintf(
      text, sizeof text,
      "the forces of the program on sphere %u at (%.6g, %.6g, %.6g) m depend on its velocity too strongly for "
      "the step: substitutions converge by %.3g, must be below %.3g; shorten the step in proportion, and let "
      "no force jump with the velocity",
      s.id, s.position.x, s.position.y, s.position.z, ratio, most);
  throw BedFault({BedFault::Kind::force, s.time, s.id, ratio, most}, text);
}

void SphereForces::note_fault(std::uint32_t sphere) noexcept {
  static std::mutex one;
  const std::scoped_lock lock(one);
  if (fault_ != nullptr && faulty_ <= sphere) return;
  fault_ = std::current_exception(), faulty_ = sphere;
}

void SphereForces::throw_fault() {
  if (fault_ != nullptr) std::rethrow_exception(std::exchange(fault_, nullptr));
}

double SphereForces::work() const {
  double sum = before_ + clumps_.until;
  for (const Work& w : blocks_) sum += w.until;
  return sum;
}

void SphereForces::reset_work() {
  before_ = 0, clumps_ = {};
  std::fill(blocks_.begin(), blocks_.end(), Work{});
}

void SphereForces::archive(Archive& a) {
  std::vector<std::string> names;
  for (const NamedSphereForce& f : forces_) names.push_back(f.name);
  a("names", names);
  double done = before_ + clumps_.all();
  for (const Work& w : blocks_) done += w.all();
  a("work", done);
  if (a.reads()) reset_work(), before_ = done;
  for (const std::string& name : names) {
    const auto found = std::find_if(forces_.begin(), forces_.end(), [&](const auto& f) { return f.name == name; });
    if (found == forces_.end())
      throw std::invalid_argument("restart: the state was written with the force '" + name +
                                  "' of a program on its spheres; add it to the bed before the restart");
    a.group("state", [&] { a.group(name, [&] { found->force.archive(a); }); });
  }
}

void SphereForces::archive_lists(Archive& a) { a("before", before_)("on clumps", clumps_)("of blocks", blocks_); }

}  // namespace subsoil::dem
