#include "libsim/studies/laboratory/specimen.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/step/stability.hpp"

namespace subsoil::sim {
namespace {

constexpr double local_damping = 0.7;

dem::BedOptions options_of(const Sample& sample) {
  dem::BedOptions options;
  options.gravity = {0, -sample.gravity, 0};
  options.threads = 1;
  options.simd = sample.simd;
  options.speed_limit = sample.speed_limit;
  options.overlap_limit = sample.overlap_limit;
  options.sample_every = 1000;  // a test reads no losses
  return options;
}

/// Safe share of the stable step over grains, walls and smooth walls; a fall of ten diameters is expected anyway.
double step_of(const Sample& sample, double speed) {
  const dem::StepQuestion question{.smallest_radius = dem::least_radius(sample.sizes),
                                   .largest_radius = dem::largest_radius(sample.sizes),
                                   .density = sample.density,
                                   .speed = std::max(speed, std::sqrt(20 * sample.gravity * sample.diameter)),
                                   .neighbours = 12};
  const auto law = [&](int other) -> const dem::Law& {
    return sample.laws.laws[static_cast<std::size_t>(sample.laws.of(sample.grain, other))];
  };
  double limit = std::min({dem::stable_step(law(sample.grain), question).step,
                           dem::stable_step_at_surface(law(sample.wall), question).step,
                           dem::stable_step_at_surface(law(sample.smooth), question).step});
  for (const dem::ClumpShape& shape : sample.shapes)
    limit = std::min({limit, dem::stable_step(law(sample.grain), shape, question).step,
                      dem::stable_step_at_surface(law(sample.wall), shape, question).step,
                      dem::stable_step_at_surface(law(sample.smooth), shape, question).step});
  if (sample.step && *sample.step >= limit)
    throw std::invalid_argument(fmt::format(
        "`time.soil step` of {:.4g} s must be below the stable step {:.4g} s; use `auto`", *sample.step, limit));
  return sample.step.value_or(sample.safety * limit);
}

}  // namespace

Specimen::Specimen(const Sample& sample, double speed)
    : sample_(sample), bed_(sample.laws, options_of(sample)), dt_(step_of(sample, speed)) {
  for (const dem::ClumpShape& shape : sample.shapes) bed_.add_shape(shape);
}

int Specimen::plane(const std::string& name, const Vec3& point, const Vec3& normal, Wall wall) {
  dem::Boundary boundary;
  boundary.name = name;
  boundary.shape = dem::Plane({}, normal);
  boundary.pose.position = point;
  boundary.material = wall == Wall::rough ? sample_.wall : sample_.smooth;
  return bed_.add(std::move(boundary));
}

int Specimen::surface(const std::string& name, std::span<const dem::TriangleMesh> meshes, Wall wall) {
  dem::Boundary boundary;
  boundary.name = name;
  boundary.shape = dem::MeshSurface(meshes);
  boundary.material = wall == Wall::rough ? sample_.wall : sample_.smooth;
  return bed_.add(std::move(boundary));
}

Specimen::BoxWalls Specimen::box(double length, double width, Wall sides) {
  BoxWalls walls{};
  walls.left = plane("wall -x", {}, {1, 0, 0}, sides);
  walls.right = plane("wall +x", {length, 0, 0}, {-1, 0, 0}, sides);
  walls.floor = plane("floor", {}, {0, 1, 0}, Wall::rough);
  walls.front = plane("wall -z", {}, {0, 0, 1}, sides);
  walls.back = plane("wall +z", {0, 0, width}, {0, 0, -1}, sides);
  return walls;
}

dem::SettlePlan Specimen::plan(bool staged) const {
  dem::SettlePlan plan;
  plan.step = dt_;
  plan.at_most = sample_.at_most;
  plan.staged = staged;
  plan.lowered = sample_.lowered;
  plan.ramp = sample_.ramp;
  plan.spins = false;
  return plan;
}

dem::SettleReport Specimen::fill(const dem::Bounds& region, double depth, std::uint64_t seed) {
  dem::RandomFill fill;
  fill.region = region;
  fill.radius = sample_.sizes;
  fill.shares = sample_.shares;
  fill.clumps = sample_.clumps;
  fill.of = {sample_.density, sample_.grain};
  fill.seed = seed;
  fill.depth = depth;
  return dem::fill_at_random(bed_, sample_.laws, fill, plan(true));
}

std::vector<long> Specimen::steps_of_rows(double way, double speed, int rows) const {
  const long all = std::max(1L, std::lround(way / (speed * dt_)));
  if (all < rows)
    throw std::invalid_argument(
        fmt::format("the path of {:.4g} m at {:.4g} m/s takes {} steps of {:.3g} s, fewer than its {} rows; a lower "
                    "`speed`, or a longer `path`",
                    way, speed, all, dt_, rows));
  std::vector<long> out;
  for (long row = 0; row < rows; ++row) out.push_back((row + 1) * all / rows - row * all / rows);
  return out;
}

void Specimen::rest() { dem::settle(bed_, sample_.laws, plan(false), {{}, {1, 1, 1}}); }

void Specimen::move(int boundary, const Vec3& velocity) {
  dem::Boundary& b = bed_.boundary(boundary);
  b.velocity = velocity;
  b.pose.position += velocity * dt_;
}

void Specimen::turn(int boundary, const Vec3& angular_velocity) {
  dem::Boundary& b = bed_.boundary(boundary);
  b.angular_velocity = angular_velocity;
  b.pose.attitude = (dem::Quaternion::from_rotation_vector(angular_velocity * dt_) * b.pose.attitude).normalized();
}

double Specimen::mass() const {
  double sum = 0;
  for (const dem::Sphere& s : bed_.spheres()) sum += s.m;
  return sum;
}

double Specimen::top() const {
  double top = 0;
  for (const dem::Sphere& s : bed_.spheres()) top = std::max(top, s.x.y + s.r);
  return top;
}

double Specimen::rms_speed() const {
  double sum = 0;
  for (const dem::Sphere& s : bed_.spheres()) sum += dem::dot(s.v, s.v);
  return bed_.spheres().empty() ? 0 : std::sqrt(sum / static_cast<double>(bed_.spheres().size()));
}

Lid::Lid(Specimen& specimen, Wall wall)
    : specimen_(specimen),
      boundary_(specimen.plane("lid", {0, specimen.top() + 0.1 * specimen.sample().diameter, 0}, {0, -1, 0}, wall)),
      mass_(0.5 * specimen.mass()),
      largest_speed_(0.1 * specimen.sample().fall_speed()) {}

void Lid::follow(double load) {
  const double off = force() - load;
  const double damped = off - local_damping * std::abs(off) * (speed_ > 0 ? 1 : speed_ < 0 ? -1 : 0);
  speed_ = std::clamp(speed_ + damped / mass_ * specimen_.dt(), -largest_speed_, largest_speed_);
  drive(speed_);
}

void Lid::consolidate(double load) {
  const double hold = specimen_.sample().fall_time(), still = 1e-2 * largest_speed_;
  double held = 0;
  for (double t = 0; held < hold; t += specimen_.dt()) {
    if (t > specimen_.sample().at_most)
      throw std::runtime_error(
          fmt::format("after {:.3g} s under the load the lid still moves, at {:.3g} m/s with {:.4g} N of {:.4g} N; a "
                      "softer load, or stiffer contacts, or a longer `test.at most`",
                      t, speed_, force(), load));
    specimen_.step();
    follow(load);
    held = std::abs(force() - load) < 0.01 * load && std::abs(speed_) < still ? held + specimen_.dt() : 0;
  }
}

}  // namespace subsoil::sim
