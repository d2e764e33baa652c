#include "libdem/step/clumps.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "libdem/particles/rigid_rotation.hpp"
#include "libdem/step/active_region.hpp"

namespace subsoil::dem {
int Clumps::add_shape(ClumpShape shape) {
  if (shape.members.empty()) throw std::invalid_argument("clump " + shape.name + ": has no sphere");
  shares_.push_back(shares_by_volume(shape));
  widest_gap_ = std::max(widest_gap_, dem::widest_gap(shape));
  shapes_.push_back(std::move(shape));
  return static_cast<int>(shapes_.size()) - 1;
}

void Clumps::add(const ClumpSpec& in, ParticleStore& particles, int materials) {
  if (in.shape < 0 || in.shape >= static_cast<int>(shapes_.size()))
    throw std::invalid_argument("clump " + std::to_string(next_id_) + ": no such shape");
  const ClumpShape& shape = shapes_[static_cast<std::size_t>(in.shape)];
  Clump c;
  c.id = in.number.value_or(next_id_), c.shape = static_cast<std::uint32_t>(in.shape);
  next_id_ = std::max(next_id_, c.id + 1);
  c.material = static_cast<std::uint16_t>(in.material);
  c.position = in.position, c.velocity = in.velocity, c.attitude = in.attitude.normalized();
  c.angular_momentum = angular_momentum_of(c.attitude, shape.inertia, in.angular_velocity);
  bool first = true;
  std::optional<std::uint32_t> number = in.number;
  for (const ClumpMember& m : shape.members) {
    const Vec3 arm = c.attitude.rotate(m.at);
    particles.add({c.position + arm, c.velocity + cross(in.angular_velocity, arm), in.angular_velocity, m.radius,
                   shape.mass / sphere_volume(m.radius), in.material},
                  materials, number);
    if (number) ++*number;
    Sphere& s = particles.spheres().back();
    s.m = shape.mass *
          shares_.at(static_cast<std::size_t>(in.shape))[static_cast<std::size_t>(&m - shape.members.data())];
    s.kind = SphereKind::member;
    if (std::exchange(first, false)) c.first_sphere = s.id;
  }
  clumps_.push_back(c);
  number_spheres();
}

void Clumps::join(std::span<const Clump> clumps) {
  for (const Clump& c : clumps) {
    if (c.shape >= shapes_.size()) throw std::invalid_argument("clump " + std::to_string(c.id) + ": no such shape");
    clumps_.push_back(c);
    next_id_ = std::max(next_id_, c.id + 1);
  }
  number_spheres();
}

/// Only those that came last are new, unless clumps have left.
void Clumps::number_spheres() {
  for (std::size_t k = clumps_.size(); k-- > 0;) {
    const Clump& c = clumps_[k];
    const std::size_t end = c.first_sphere + shapes_[c.shape].members.size();
    if (of_id_.size() < end) of_id_.resize(end, kGone);
    if (of_id_[c.first_sphere] == k) break;
    std::fill(of_id_.begin() + c.first_sphere, of_id_.begin() + static_cast<std::ptrdiff_t>(end),
              static_cast<std::uint32_t>(k));
  }
}

double Clumps::volume_share(const Sphere& s) const {
  const Clump& c = clumps_[clump_of(s.id)];
  return shapes_[c.shape].volume * shares_[c.shape][s.id - c.first_sphere];
}

void Clumps::choose_leaving(std::span<const Sphere> spheres, double floor,
                            const std::function<bool(const Sphere&)>& gone) {
  leaving_.clear();
  if (!any()) return;
  leaving_.assign(clumps_.size(), 0);
  for (const Sphere& s : spheres) {
    const std::uint32_t c = clump_of(s.id);
    if (c == kGone || leaving_[c] == kFell) continue;
    if (s.x.y < floor)
      leaving_[c] = kFell;
    else if (gone && gone(s))
      leaving_[c] = kLeaves;
  }
}

std::function<bool(const Sphere&)> Clumps::with_whole_clumps(const std::function<bool(const Sphere&)>& gone) const {
  if (std::all_of(leaving_.begin(), leaving_.end(), [](char l) { return l == 0; })) return gone;
  return [this, gone](const Sphere& s) {
    const std::uint32_t c = clump_of(s.id);
    return c != kGone ? leaving_[c] != 0 : gone && gone(s);
  };
}

double Clumps::take_out(const Vec3& gravity) {
  double energy = 0;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < clumps_.size(); ++k) {
    const Clump& c = clumps_[k];
    if (leaving_[k] == 0) {
      clumps_[kept++] = c;
      continue;
    }
    const ClumpShape& shape = shapes_[c.shape];
    const Vec3 w = angular_velocity_of(c.attitude, shape.inertia, c.angular_momentum);
    energy += 0.5 * shape.mass * dot(c.velocity, c.velocity) + 0.5 * dot(w, c.angular_momentum) -
              shape.mass * dot(gravity, c.position);
  }
  leaving_.clear();
  if (kept == clumps_.size()) return energy;
  clumps_.resize(kept);
  of_id_.clear();
  number_spheres();
  return energy;
}

double Clumps::go_round(const Sphere& member, const Vec3& periods, const Vec3& gravity) {
  Clump& c = clumps_[clump_of(member.id)];
  if (member.id != c.first_sphere) return 0;
  c.position += periods;
  return shapes_[c.shape].mass * dot(gravity, periods);
}

void Clumps::find(std::span<const Sphere> spheres, const PeriodicCell& cell) {
  places_.clear(), first_.clear(), clump_at_.clear();
  if (!any()) return;
  begin_.clear();
  std::uint32_t entries = 0;
  for (const Clump& c : clumps_) {
    begin_.push_back(entries);
    entries += static_cast<std::uint32_t>(shapes_[c.shape].members.size());
  }
  begin_.push_back(entries);
  loads_.assign(entries, {}), sphere_of_.assign(entries, kGone), periods_.assign(entries, {});
  clump_at_.reserve(spheres.size());
  for (std::uint32_t i = 0; i < spheres.size(); ++i) {
    const std::uint32_t c = clump_of(spheres[i].id);
    clump_at_.push_back(c);
    if (c == kGone) continue;
    const std::uint32_t entry = begin_[c] + (spheres[i].id - clumps_[c].first_sphere);
    places_.push_back({i, entry});
    sphere_of_[entry] = i;
    const Clump& of = clumps_[c];
    const Vec3 arm = of.attitude.rotate(shapes_[of.shape].members[spheres[i].id - of.first_sphere].at);
    periods_[entry] = cell.periods(spheres[i].x - of.position - arm);
  }
}

void Clumps::drop_pairs(NeighbourList& list, const PeriodicImages& images) const {
  if (!any()) return;
  list.keep_if([&](std::uint32_t i, std::uint32_t j) {
    return clump_at_[i] == kGone || clump_at_[images.sphere(j)] != clump_at_[i];
  });
}

void Clumps::begin_lists(std::span<const ParticleBlock> blocks) {
  if (places_.empty()) return;
  std::uint32_t k = 0;
  for (const ParticleBlock& b : blocks) {
    while (k < places_.size() && places_[k].sphere < b.begin) ++k;
    first_.push_back(k);
  }
  first_.push_back(static_cast<std::uint32_t>(places_.size()));
}

Clumps::Loaded Clumps::gathered(std::size_t clump) const {
  const Clump& c = clumps_[clump];
  Loaded sum;
  for (std::uint32_t e = begin_[clump]; e < begin_[clump + 1]; ++e) {
    const Vec3 arm = c.attitude.rotate(shapes_[c.shape].members[e - begin_[clump]].at);
    sum.force += loads_[e].force;
    sum.moment += loads_[e].torque + cross(arm, loads_[e].force);
  }
  return sum;
}

BodyEnergy Clumps::energy_of(std::size_t clump, const Vec3& gravity, double before, double dt) const {
  BodyEnergy out;
  const double half = 0.5 * before, ratio = before > 0 ? dt / before : 0;
  const Clump& c = clumps_[clump];
  const ClumpShape& shape = shapes_[c.shape];
  const Loaded sum = gathered(clump);
  const Vec3 gain = half * ((1 / shape.mass) * sum.force + gravity), v = c.velocity + gain;
  const Vec3 turn = half * sum.moment, l = c.angular_momentum + turn;
  out.kinetic = 0.5 * shape.mass * (dot(v, v) - ratio * dot(gain, gain));
  out.rotational = 0.5 * (dot(l, angular_velocity_of(c.attitude, shape.inertia, l)) -
                          ratio * dot(turn, angular_velocity_of(c.attitude, shape.inertia, turn)));
  out.potential = -shape.mass * dot(gravity, c.position);
  return out;
}

BodyEnergy Clumps::energy(const ActiveRegion& region, const Vec3& gravity, double before, double dt) const {
  BodyEnergy out;
  for (std::size_t k = 0; k < clumps_.size(); ++k) {
    const BodyEnergy one = energy_of(k, gravity, before, dt);
    if (region.clump_drifts(k)) out.kinetic += one.kinetic, out.rotational += one.rotational;
    out.potential += one.potential;
  }
  return out;
}

void Clumps::complete(Snapshot& out, const ActiveRegion& region, const ParticleStore& particles, const Vec3& gravity,
                      double before) const {
  for (std::size_t k = 0; k < clumps_.size(); ++k) {
    const Clump& c = clumps_[k];
    const ClumpShape& shape = shapes_[c.shape];
    const Loaded sum = gathered(k);
    const double half = region.clump_moves(k) ? 0.5 * before : 0;
    const Vec3 v = c.velocity + half * ((1 / shape.mass) * sum.force + gravity);
    const Vec3 w = angular_velocity_of(c.attitude, shape.inertia, c.angular_momentum + half * sum.moment);
    for (std::uint32_t e = begin_[k]; e < begin_[k + 1]; ++e) {
      const std::size_t m = e - begin_[k], slot = particles.slot_of(particles[sphere_of_[e]]);
      out.velocity[slot] = v + cross(w, c.attitude.rotate(shape.members[m].at));
      out.angular_velocity[slot] = w;
      out.force[slot] += (shape.mass * shares_[c.shape][m]) * gravity;
      if (!own_.empty()) out.force[slot] += own_[e].force, out.torque[slot] += own_[e].torque;
    }
  }
}

void Clumps::check(ActiveRegion& region, std::size_t clump, const Vec3& gravity) const {
  const Clump& c = clumps_[clump];
  const ClumpShape& shape = shapes_[c.shape];
  const Loaded sum = gathered(clump);
  region.check_clump(clump, (1 / shape.mass) * sum.force + gravity,
                     shape.reach * angular_velocity_of(c.attitude, shape.inertia, sum.moment));
}

double Clumps::move(ActiveRegion& region, ParticleStore& particles, const Vec3& gravity, double before, double dt,
                    int threads) {
  const double kick = 0.5 * (dt + before);
  const auto count = static_cast<long>(clumps_.size());
  double frozen = 0;
  for (std::size_t k = 0; k < clumps_.size(); ++k) {
    if (!region.clump_freezes(k)) continue;
    const BodyEnergy had = energy_of(k, gravity, before, dt);
    frozen += had.kinetic + had.rotational;
    clumps_[k].velocity = clumps_[k].angular_momentum = {};
    for (const std::uint32_t i : members(k)) particles.stop(i);
  }
#pragma omp parallel for num_threads(threads) schedule(static)
  for (long n = 0; n < count; ++n) {
    const auto k = static_cast<std::size_t>(n);
    if (region.checks_clump(k)) check(region, k, gravity);
    if (!region.clump_drifts(k)) continue;
    Clump& c = clumps_[k];
    const ClumpShape& shape = shapes_[c.shape];
    const Loaded sum = gathered(k);
    c.velocity += kick * ((1 / shape.mass) * sum.force + gravity);
    c.angular_momentum += kick * sum.moment;
    c.position += dt * c.velocity;
    const Quaternion was = c.attitude;
    const RotationStep turned = rotate_freely(was, shape.inertia, c.angular_momentum, dt);
    c.attitude = turned.attitude;
    for (std::uint32_t e = begin_[k]; e < begin_[k + 1]; ++e) {
      const Vec3& at = shape.members[e - begin_[k]].at;
      const Vec3 arm = c.attitude.rotate(at), middle = 0.5 * (was.rotate(at) + arm);
      Sphere& s = particles.spheres()[sphere_of_[e]];
      s.x = c.position + arm + periods_[e];
      s.v = c.velocity + cross(turned.angular_velocity, middle);
      s.w = turned.angular_velocity;
      if (particles.is_mixed()) particles.mixed()[sphere_of_[e]] = rounded(s, particles.mass_in_contact(sphere_of_[e]));
    }
  }
  return frozen;
}

void Clumps::extremes(const ActiveRegion& region, std::span<const ParticleBlock> blocks, const ParticleStore& particles,
                      int threads, const std::function<void(std::size_t, double, double)>& use) const {
  const auto count = static_cast<long>(blocks.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (long n = 0; n < count; ++n) {
    const auto b = static_cast<std::size_t>(n);
    if (of_block(b).empty() || !region.moves(b)) continue;
    double speed2 = 0, squares = 0;
    for (std::uint32_t i = blocks[b].begin; i < blocks[b].end; ++i) {
      const Sphere s = particles.now(i);
      const double v2 = dot(s.v, s.v);
      if (exceeds(v2, speed2)) speed2 = v2;
      squares += v2 + dot(s.w, s.w);
    }
    use(b, speed2, squares);
  }
}

void Clumps::shift(const Vec3& offset) {
  for (Clump& c : clumps_) c.position += offset;
}

void Clumps::stop() {
  for (Clump& c : clumps_) c.velocity = c.angular_momentum = {};
}

void Clumps::archive(Archive& a) {
  a("next id", next_id_);
  std::size_t count = clumps_.size();
  a("count", count);
  if (a.reads()) clumps_.clear(), of_id_.clear(), leaving_.clear();
  for (std::size_t k = 0; k < count; ++k) {
    if (a.reads()) clumps_.emplace_back();
    Clump& c = clumps_[k];
    c.archive(a);
    if (c.shape >= shapes_.size())
      throw std::invalid_argument(
          "restart: the state has clumps of a shape that the scenario lacks; use the scenario it was written from");
  }
}

void Clumps::archive_lists(Archive& a) {
  std::vector<Load> loads = loads_;
  a("loads", loads);
  if (loads.size() != loads_.size()) Archive::refuse("loads");
  loads_ = std::move(loads);
}

void Clumps::find_members(const std::function<bool(std::uint32_t)>& there) {
  for (const Clump& c : clumps_)
    for (std::size_t m = 0; m < shapes_[c.shape].members.size(); ++m)
      if (!there(c.first_sphere + static_cast<std::uint32_t>(m)))
        throw std::invalid_argument(
            "restart: a clump of the state lacks spheres: the file is damaged, or the scenario has other shapes");
  number_spheres();
}

}  // namespace subsoil::dem
