#include "libsim/setup/travel_direction.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "libmbd/elements.hpp"

namespace subsoil::sim {
namespace {

constexpr int kPathSamples = 4000;  ///< of a run

/// x since the start, m, at kPathSamples + 1 instants of a run.
using Path = std::vector<double>;

/// Of a driver, `factor` of its way: the trapezium rule, which is exact over whole periods.
Path path_of(const mbd::Motion& motion, double end, double factor) {
  Path out(kPathSamples + 1);
  double before = motion.rate(0);
  for (int k = 1; k <= kPathSamples; ++k) {
    const double now = motion.rate(end * k / kPathSamples);
    const auto at = static_cast<std::size_t>(k);
    out[at] = out[at - 1] + factor * 0.5 * (before + now) * (end / kPathSamples);
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
    Path sum(kPathSamples + 1);
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
    if (body == mbd::ground) return Path(kPathSamples + 1);
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
  Path sum(kPathSamples + 1);
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
