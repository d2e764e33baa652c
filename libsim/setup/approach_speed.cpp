#include "libsim/setup/approach_speed.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "libmbd/elements.hpp"

namespace subsoil::sim {
namespace {

constexpr int kSamples = 4000;  ///< of a run

/// Farthest that a point of a surface in its own axes lies from `from`, m; 0 of a plane, which has no farthest point.
double reach_from(const dem::Bounds& box, const Vec3& from) {
  const double far = box.farthest(from);
  return std::isfinite(far) ? far : 0;
}

/// Moves of a boundary add up: at most the sum of what each gives its farthest point.
double fastest(const BoundarySection& b, const dem::Boundary& made, double end) {
  double most = 0;
  for (int k = 0; k <= kSamples; ++k) {
    const double t = end * k / kSamples;
    double speed = b.servo ? b.servo->limit : 0;
    for (const Move& m : b.moves) {
      if (t < m.from || t > m.until) continue;
      const Vec3 about = m.about ? *m.about : made.pose.position;
      const double reach = dem::norm(m.spin) > 0 ? reach_from(dem::bounds(made.shape), made.pose.to_local(about)) : 0;
      speed += std::abs(m.profile.value(t)) * (dem::norm(m.velocity) + dem::norm(m.spin) * reach);
    }
    most = std::max(most, speed);
  }
  return most;
}

/// The machine's surfaces as it starts, and what its drivers ask for at any time.
double fastest(const MachineSection& machine, const World& world, double end) {
  double most = machine.start.speed, reach = 0;
  for (const SurfaceRecord& r : world.surfaces) {
    if (r.owner != SurfaceRecord::Owner::machine) continue;
    const double far = reach_from(dem::bounds(world.bed->boundary(r.boundary).shape), {});
    const mbd::BodyState& body = world.machine->body(r.body);
    most = std::max(most, std::hypot(body.v.x, body.v.y) + std::abs(body.omega) * far);
    reach = std::max(reach, far);
  }
  for (const NamedDriver& d : machine.drivers)
    visit(
        [&](const auto& driver) {
          const double lever = driver.angular() ? reach : 1;
          for (int k = 0; k <= kSamples; ++k)
            most = std::max(most, lever * std::abs(driver.motion.rate(end * k / kSamples)));
        },
        d.element);
  return most;
}

/// The longest free fall in a box with these edges, m.
double fall_through(const Vec3& room, const Vec3& gravity) {
  double longest = std::numeric_limits<double>::infinity();
  for (int d = 0; d < 3; ++d)
    if (gravity[d] != 0)
      longest = std::min(longest, std::max(0.0, room[d]) * (dem::norm(gravity) / std::abs(gravity[d])));
  return std::isfinite(longest) ? longest : 0;
}

/// Of its spheres where they have fallen from the inlet's upper side to the container's floor, wherever gravity leads.
double speed_below(const InletSection& inlet, const Soil& soil, const Vec3& gravity) {
  Vec3 room{};
  for (int d = 0; d < 3 && soil.container; ++d) {
    const Container& c = *soil.container;
    const double at = inlet.box ? inlet.box->at[d] : inlet.disk->at[d], size = inlet.box ? inlet.box->size[d] : 0;
    room[d] = gravity[d] > 0 ? c.at[d] + c.size[d] - at : at + size - c.at[d];
  }
  return std::sqrt(dem::dot(inlet.velocity, inlet.velocity) + 2 * dem::norm(gravity) * fall_through(room, gravity));
}

}  // namespace

double expected_speed(const Scenario& s, const World& world) {
  const double end = s.time.end > 0 ? s.time.end : 0;  // a laboratory's sample has none
  double sphere = 0, surface = 0, fall = 0;
  for (const dem::Sphere& one : world.bed->spheres()) sphere = std::max(sphere, dem::norm(one.v));
  for (const SurfaceRecord& r : world.surfaces) {
    if (r.owner != SurfaceRecord::Owner::given) continue;
    for (const BoundarySection& b : s.boundaries)
      if (b.name == r.name) surface = std::max(surface, fastest(b, world.bed->boundary(r.boundary), end));
  }
  if (s.machine && world.machine) surface = std::max(surface, fastest(*s.machine, world, end));
  if (s.soil)
    for (const InletSection& inlet : s.soil->inlets) sphere = std::max(sphere, speed_below(inlet, *s.soil, s.gravity));
  if (s.soil && s.soil->container)
    fall = std::sqrt(2 * dem::norm(s.gravity) * fall_through(s.soil->container->size, s.gravity));
  return std::max({0.1, 2 * sphere, sphere + surface, fall});
}

namespace {

/// x since the start, m, at kSamples + 1 instants of a run.
using Path = std::vector<double>;

/// Of a driver, `factor` of its way: the trapezium rule, which is exact over whole periods.
Path path_of(const mbd::Motion& motion, double end, double factor) {
  Path out(kSamples + 1);
  double before = motion.rate(0);
  for (int k = 1; k <= kSamples; ++k) {
    const double now = motion.rate(end * k / kSamples);
    const auto at = static_cast<std::size_t>(k);
    out[at] = out[at - 1] + factor * 0.5 * (before + now) * (end / kSamples);
    before = now;
  }
  return out;
}

void add(Path& sum, const Path& other) {
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += other[k];
}

/// What a machine's drivers do to its bodies along x.
class DrivenWays {
 public:
  DrivenWays(const World& world, double end) : world_(world), end_(end) {
    double count = 0;
    Path sum(kSamples + 1);
    for (const auto& d : world.machine->system().model().drivers)
      if (const auto* x = d.element.get_if<mbd::CoordinateDriver>();
          x != nullptr && x->coordinate == mbd::Coordinate::x)
        add(sum, path_of(x->motion, end, 1)), ++count;
    for (double& x : sum) x /= std::max(count, 1.0);
    if (count > 0) towed_ = std::move(sum);
  }

  /// Its own driver's; that of the body against which a slide drives it, and the slide's; else the mean of all drivers
  /// of an x, which tow the machine. Empty: of no driver.
  Path of(int body) {
    if (body == mbd::ground) return Path(kSamples + 1);
    visited_.push_back(body);
    for (const auto& d : world_.machine->system().model().drivers)
      if (const auto* x = d.element.get_if<mbd::CoordinateDriver>();
          x != nullptr && x->coordinate == mbd::Coordinate::x && x->body == body)
        return path_of(x->motion, end_, 1);
    for (const auto& d : world_.machine->system().model().drivers) {
      const auto* slide = d.element.get_if<mbd::SlideDriver>();
      if (slide == nullptr || (slide->first != body && slide->second != body)) continue;
      const int other = slide->first == body ? slide->second : slide->first;
      if (std::count(visited_.begin(), visited_.end(), other) > 0) continue;
      const double along = std::cos(world_.machine->body(slide->first).angle + slide->angle_a);
      Path path = path_of(slide->motion, end_, slide->first == body ? -along : along);
      if (const Path base = of(other); !base.empty()) add(path, base);
      return path;
    }
    return towed_;
  }

 private:
  const World& world_;
  double end_;
  Path towed_;
  std::vector<int> visited_;
};

/// 1 or -1; 0 of a sum that is the rounding of its parts.
int sense_of(double sum, double parts) {
  constexpr double rounding = 1e-9, still = 1e-12;  // m/s or m/s^2
  return std::abs(sum) <= rounding * parts + still ? 0 : sum < 0 ? -1 : 1;
}

/// Bodies of the machine that carry surfaces, each once.
std::vector<int> bodies_with_surfaces(const World& world) {
  std::vector<int> out;
  for (const SurfaceRecord& r : world.surfaces)
    if (r.owner == SurfaceRecord::Owner::machine && std::find(out.begin(), out.end(), r.body) == out.end())
      out.push_back(r.body);
  return out;
}

}  // namespace

int way_of_drivers(const Scenario& s, const World& world) {
  if (!s.machine || !world.machine || !(s.time.end > 0)) return 0;
  Path sum(kSamples + 1);
  for (const int body : bodies_with_surfaces(world))
    if (const Path path = DrivenWays(world, s.time.end).of(body); !path.empty()) add(sum, path);
  double farthest = 0;
  for (const double x : sum) farthest = std::max(farthest, std::abs(x));
  const double net = sum.back();
  return std::abs(net) <= came_nowhere * farthest ? 0 : net < 0 ? -1 : 1;
}

int travel_direction(const Scenario& s, const World& world) {
  if (s.soil && s.soil->moving) return s.soil->moving->direction();
  if (!s.machine || !world.machine) return 1;
  if (const int way = way_of_drivers(s, world); way != 0) return way;
  double speed = s.machine->start.speed, parts = std::abs(speed), push = 0, pushes = 0;
  // From rest it goes where its forces push it.
  const Eigen::VectorXd& acceleration = world.machine->integrator().state().acceleration;
  for (const int body : bodies_with_surfaces(world)) {
    const double v = world.machine->body(body).v.x, a = acceleration[3 * (body - 1)];
    speed += v, parts += std::abs(v), push += a, pushes += std::abs(a);
  }
  if (const int sense = sense_of(speed, parts); sense != 0) return sense;
  const int sense = sense_of(push, pushes);
  return sense != 0 ? sense : 1;
}

}  // namespace subsoil::sim
