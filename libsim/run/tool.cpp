#include "libsim/run/tool.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>

#include "libdem/packing/measure.hpp"
#include "libmbd/controllers.hpp"
#include "libmbd/elements.hpp"
#include "libmbd/system/given_functions.hpp"
#include "libsim/setup/moving_soil.hpp"
#include "libsim/setup/travel_direction.hpp"

namespace subsoil::sim {
namespace {

/// Points that a surface consists of, in its axes; of a plane none.
std::vector<Vec3> points_of(const World& world, const SurfaceRecord& s) {
  const dem::Shape& shape = world.bed->boundary(s.boundary).shape;
  if (std::holds_alternative<dem::Plane>(shape)) return {};
  return dem::drawing(shape, 1.0)[s.mesh].vertices();
}

constexpr double moved = 1e-9;  // m; less is the rounding of places

Vec3 level(const Vec3& v) { return {v.x, 0, v.z}; }

/// Along x or z, whichever is longer.
Vec3 main_direction(const Vec3& v) {
  if (std::abs(v.x) >= std::abs(v.z)) return {v.x < 0 ? -1.0 : 1.0, 0, 0};
  return {0, 0, v.z < 0 ? -1.0 : 1.0};
}

}  // namespace

Vec3 Tool::direction() const {
  // Back where it entered, as after an even number of strokes, it has come nowhere.
  if (dem::norm(gone) > std::max(came_nowhere * farthest, moved)) return main_direction(gone);
  return dem::norm(began) > 0 ? began : Vec3{1, 0, 0};
}

double Tool::travel(const Vec3& direction) const {
  return std::max(dem::dot(direction, direction.x + direction.z > 0 ? ahead : -1.0 * behind), 0.0);
}

ToolProgress::ToolProgress(World& world, const coupling::Simulation& simulation, const Scenario& scenario)
    : world_(world), simulation_(simulation), scenario_(scenario) {
  if (!world.bed) return;
  take_soil();
  for (std::size_t i = 0; i < world.surfaces.size(); ++i) {
    const SurfaceRecord& s = world.surfaces[i];
    if (s.owner == SurfaceRecord::Owner::machine) {
      const std::string& body = world.machine->system().body_name(s.body);
      add(body, body + ".soil", i);
    } else if (s.owner == SurfaceRecord::Owner::given && s.moves) {
      add(s.name, s.name, i);
      if (!tools_.empty() && tools_.back().name == s.name)
        tools_.back().passes = length_of_path(s, scenario.time.end) > 2 * radius_;
    }
  }
}

void ToolProgress::take_soil() {
  constexpr double far = std::numeric_limits<double>::infinity();
  low_ = {far, far, far}, high_ = {-far, -far, -far}, radius_ = 0;
  for (const dem::Sphere& s : world_.bed->spheres()) {
    low_ = {std::min(low_.x, s.x.x - s.r), std::min(low_.y, s.x.y - s.r), std::min(low_.z, s.x.z - s.r)};
    high_ = {std::max(high_.x, s.x.x + s.r), std::max(high_.y, s.x.y + s.r), std::max(high_.z, s.x.z + s.r)};
    radius_ += s.r / static_cast<double>(world_.bed->spheres().size());
  }
  if (world_.moving) (world_.moving->window.plan().direction > 0 ? high_.x = far : low_.x = -far);  // it has no end
}

/// Soil with what inlets have poured until now. What falls is not on it yet: it is faster than after a fall by a
/// diameter.
void ToolProgress::measure_poured_soil() {
  take_soil();
  const double fastest = std::sqrt(2 * dem::norm(scenario_.gravity) * 2 * radius_);
  std::vector<dem::Sphere> lie;
  for (const dem::Sphere& s : world_.bed->spheres())
    if (dem::norm(s.v) <= fastest) lie.push_back(s);
  if (lie.empty()) return;
  dem::Bounds region{low_, high_};
  if (const auto& container = scenario_.soil->container; container)
    region = {container->at, container->at + container->size};
  const dem::SurfaceHeight surface = dem::surface_height(lie, region);
  world_.soil.surface_mean = surface.mean, world_.soil.surface_spread = surface.spread;
}

void ToolProgress::add(const std::string& name, const std::string& column, std::size_t surface) {
  std::vector<Vec3> points = points_of(world_, world_.surfaces[surface]);
  if (points.empty()) return;
  auto tool = std::find_if(tools_.begin(), tools_.end(), [&](const Tool& t) { return t.column == column; });
  if (tool == tools_.end()) {
    tool = tools_.insert(tools_.end(), Tool{});
    tool->name = name, tool->column = column;
  }
  tool->surfaces.push_back(surface);
  tool->points.push_back(std::move(points));
}

/// Longest level distance from its start that a boundary reaches on its path.
double ToolProgress::length_of_path(const SurfaceRecord& surface, double end) const {
  for (const coupling::GivenMotion& m : world_.motions) {
    if (m.boundary != surface.boundary) continue;
    double longest = 0;
    for (int k = 1; k <= 200; ++k)
      longest = std::max(longest, dem::norm(level(m.pose(end * k / 200).position - m.pose(0).position)));
    return longest;
  }
  return 0;
}

bool ToolProgress::any_passes() const {
  return std::any_of(tools_.begin(), tools_.end(), [](const Tool& t) { return t.passes; });
}

std::pair<const Tool*, const Tool*> ToolProgress::opposed() const {
  for (const Tool& a : tools_)
    for (const Tool& b : tools_)
      if (a.travels() && b.travels() && dem::dot(a.direction(), b.direction()) < 0) return {&a, &b};
  return {nullptr, nullptr};
}

void ToolProgress::look_for_touch() {
  for (Tool& tool : tools_) {
    tool.touches = std::any_of(tool.surfaces.begin(), tool.surfaces.end(), [&](std::size_t s) {
      return world_.bed->boundary(world_.surfaces[s].boundary).contacts > 0;
    });
    tool.touched = tool.touched || tool.touches;
  }
}

void ToolProgress::count_look() {
  for (Tool& tool : tools_) {
    if (!tool.entry) continue;
    const double now = dem::dot(tool.gone, tool.along);
    if (tool.looks == 0) tool.reached = now, tool.gained = tool.fell_back = 0, tool.stands = 0;
    ++tool.looks, ++tool.stands, tool.out += tool.in_soil ? 0 : 1;
    if (now > tool.reached + moved) tool.gained += now - tool.reached, tool.reached = now, tool.stands = 0;
    tool.fell_back = std::max(tool.fell_back, tool.reached - now);
  }
}

void ToolProgress::forget_looks() {
  for (Tool& tool : tools_) tool.looks = tool.out = 0;
}

bool ToolProgress::any_travelled() const {
  return std::any_of(tools_.begin(), tools_.end(),
                     [&](const Tool& t) { return t.passes && t.travel(t.along) > 2 * radius_; });
}

void ToolProgress::follow() {
  turned_ = false;
  const auto any = [&](auto&& is) { return std::any_of(tools_.begin(), tools_.end(), is); };
  const bool poured = scenario_.soil && !scenario_.soil->inlets.empty();
  const bool measures = poured && any([](const Tool& t) { return t.touches; }) &&
                        !any([](const Tool& t) { return dem::norm(t.began) > 0; });
  if (measures) measure_poured_soil();
  for (Tool& tool : tools_) follow(tool, measures);
}

void ToolProgress::follow(Tool& tool, bool measured) {
  const double surface = world_.soil.surface_mean;
  const Vec3 place = simulation_.surface_pose(world_.surfaces[tool.surfaces.front()].boundary).position;
  double deepest = std::numeric_limits<double>::infinity(), lowest = deepest;
  dem::Bounds below;
  for (std::size_t k = 0; k < tool.surfaces.size(); ++k) {
    const SurfaceRecord& s = world_.surfaces[tool.surfaces[k]];
    const dem::Pose pose = simulation_.surface_pose(s.boundary);
    for (const Vec3& v : tool.points[k]) {
      const Vec3 p = pose.to_world(v);
      lowest = std::min(lowest, p.y);
      if (p.y > surface) continue;
      below.include(p);
      deepest = std::min(deepest, p.y);
    }
  }
  // It may be larger than the soil, with no point of it within.
  const bool below_soil = deepest < surface && below.low.x <= high_.x && below.high.x >= low_.x &&
                          below.low.z <= high_.z && below.high.z >= low_.z && below.high.y >= low_.y;
  const bool was_in_soil = tool.in_soil;
  tool.in_soil = below_soil || (tool.entry && lowest < surface + 2 * radius_ && tool.touches);
  if (!tool.in_soil) return;
  if (!tool.entry)
    tool.entry = place;
  else if (!was_in_soil)
    *tool.entry += place - tool.last;
  tool.last = place;
  if (!below_soil) return;
  tool.depth = measured ? surface - deepest : std::max(tool.depth, surface - deepest);
  const Vec3 gone = tool.gone = level(place - *tool.entry);
  tool.farthest = std::max(tool.farthest, dem::norm(gone));
  tool.ahead = {std::max(tool.ahead.x, gone.x), 0, std::max(tool.ahead.z, gone.z)};
  tool.behind = {std::max(tool.behind.x, -gone.x), 0, std::max(tool.behind.z, -gone.z)};
  tool.size = {std::max(tool.size.x, below.high.x - below.low.x), 0, std::max(tool.size.z, below.high.z - below.low.z)};
  if (dem::norm(tool.began) == 0 && dem::norm(gone) > moved) tool.began = main_direction(gone);
  // To and fro about its entry, a tool comes equally far both ways.
  const Vec3 now = main_direction(gone);
  if (dem::norm(gone) > radius_ && tool.travel(now) > (1 + came_nowhere) * tool.travel(tool.along)) {
    turned_ = turned_ || (tool.passes && dem::norm(tool.along) > 0 && dem::dot(now, tool.along) < 1);
    tool.along = now;
  }
  if (tool.along.x != 0) tool.room = tool.along.x > 0 ? high_.x - below.high.x : below.low.x - low_.x;
  if (tool.along.z != 0) tool.room = tool.along.z > 0 ? high_.z - below.high.z : below.low.z - low_.z;
}

std::size_t ToolProgress::entered() const {
  return static_cast<std::size_t>(
      std::count_if(tools_.begin(), tools_.end(), [](const Tool& t) { return t.passes && t.entry; }));
}

bool ToolProgress::steady() const {
  bool any = false;
  for (const Tool& t : tools_) {
    if (!t.passes || !t.entry) continue;  // a guard above the soil never enters it
    if (dem::norm(t.along) == 0 || t.travel(t.along) < t.length() + t.depth) return false;
    any = true;
  }
  return any;
}

bool ToolProgress::at_the_end() const {
  return std::any_of(tools_.begin(), tools_.end(),
                     [](const Tool& t) { return t.passes && t.entry && dem::norm(t.along) > 0 && t.room < t.depth; });
}

namespace {

void add_periods(const mbd::Function& f, std::vector<double>& out) {
  if (const auto* sum = f.get_if<mbd::SumFunction>())
    for (const mbd::Function& term : sum->terms) add_periods(term, out);
  const auto* harmonic = f.get_if<mbd::HarmonicFunction>();
  if (harmonic && harmonic->amplitude != 0) out.push_back(1 / harmonic->frequency);
  const auto* table = f.get_if<mbd::TableFunction>();
  if (table && table->periodic) out.push_back(table->times.back() - table->times.front());
}

constexpr double unsteady = std::numeric_limits<double>::quiet_NaN();

/// What f is from `from` on beside what repeats itself, its mean; NaN where it changes, or a formula says what it is.
double steady_value(const mbd::Function& f, double from) {
  if (const auto* sum = f.get_if<mbd::SumFunction>()) {
    double all = 0;
    for (const mbd::Function& term : sum->terms) all += steady_value(term, from);
    return all;
  }
  if (const auto* constant = f.get_if<mbd::ConstantFunction>()) return constant->value_;
  if (const auto* harmonic = f.get_if<mbd::HarmonicFunction>()) return harmonic->mean;
  if (const auto* ramp = f.get_if<mbd::RampFunction>()) return ramp->end <= from ? ramp->to : unsteady;
  if (const auto* polynomial = f.get_if<mbd::PolynomialFunction>())
    return std::all_of(polynomial->c + 1, std::end(polynomial->c), [](double c) { return c == 0; }) ? polynomial->c[0]
                                                                                                    : unsteady;
  if (const auto* table = f.get_if<mbd::TableFunction>()) {
    const double begin = table->times.front(), end = table->times.back();
    if (table->periodic) return (f.integral(end) - f.integral(begin)) / (end - begin);
    const bool level =
        std::adjacent_find(table->values.begin(), table->values.end(), std::not_equal_to<>()) == table->values.end();
    return level || end <= from ? table->values.back() : unsteady;
  }
  return unsteady;
}

/// The same of f', of what moves.
double steady_rate(const mbd::Function& f, double from) {
  if (const auto* sum = f.get_if<mbd::SumFunction>()) {
    double all = 0;
    for (const mbd::Function& term : sum->terms) all += steady_rate(term, from);
    return all;
  }
  if (const auto* polynomial = f.get_if<mbd::PolynomialFunction>())
    return std::all_of(polynomial->c + 2, std::end(polynomial->c), [](double c) { return c == 0; }) ? polynomial->c[1]
                                                                                                    : unsteady;
  return std::isnan(steady_value(f, from)) ? unsteady : 0;
}

void add_turn(double rate, std::vector<double>& out) {
  if (std::abs(rate) > 0) out.push_back(2 * std::numbers::pi / std::abs(rate));
}

}  // namespace

double period_of(const Scenario& scenario, double from) {
  std::vector<double> periods;
  for (const BoundarySection& b : scenario.boundaries)
    for (const Move& m : b.moves) {
      add_periods(m.profile, periods);
      add_turn(dem::norm(m.spin) * steady_value(m.profile, from), periods);
    }
  if (const MachineSection* machine = scenario.machine ? &*scenario.machine : nullptr) {
    const auto take = [&](const auto& element) {
      mbd::visit_given_functions(element, [&](const mbd::Function& f) { add_periods(f, periods); });
    };
    for (const NamedForce& f : machine->forces) visit(take, f.element);
    for (const NamedController& c : machine->controllers) visit(take, c.element);
    for (const NamedDriver& d : machine->drivers)
      visit(
          [&](const auto& driver) {
            take(driver);
            if (!driver.angular()) return;
            const mbd::Motion& motion = driver.motion;
            if (motion.velocity.is_set()) add_turn(steady_value(motion.velocity, from), periods);
            if (motion.position.is_set()) add_turn(steady_rate(motion.position, from), periods);
          },
          d.element);
  }
  const double longest = periods.empty() ? 0 : *std::max_element(periods.begin(), periods.end());
  // The least multiple of the longest that holds whole ones of the others, to a hundredth of them. Among more multiples
  // any two numbers have one.
  constexpr int multiples = 20;
  for (int n = 1; n <= multiples; ++n) {
    const double common = n * longest;
    if (std::all_of(periods.begin(), periods.end(),
                    [&](double p) { return p == 0 || std::abs(common / p - std::round(common / p)) < 0.01; }))
      return common;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace subsoil::sim
