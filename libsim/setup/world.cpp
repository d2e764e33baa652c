#include "libsim/setup/world.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "libdem/particles/particles.hpp"
#include "libsim/base/input_limits.hpp"
#include "libsim/setup/active_rule.hpp"
#include "libsim/setup/approach_speed.hpp"
#include "libsim/setup/clearing.hpp"
#include "libsim/setup/laws.hpp"
#include "libsim/setup/machine.hpp"
#include "libsim/setup/moving_soil.hpp"
#include "libsim/setup/servo.hpp"
#include "libsim/setup/shapes.hpp"
#include "libsim/setup/soil.hpp"
#include "libsim/setup/travel_direction.hpp"
#include "libsim/setup/yielding.hpp"

namespace subsoil::sim {
namespace {

/// Integral of a move's factor between its limits up to t: what path its velocity has made.
double travelled(const Move& move, double t) {
  const double begin = std::min(std::max(t, move.from), move.until);
  if (!(begin > move.from)) return 0;
  return move.profile.integral(begin) - move.profile.integral(move.from);
}

/// Surfaces of one body that touch soil, by material: meshes of one body and material are one boundary of the bed, so
/// that faces that lie on each other are no contact twice. Each keeps its name and its share of the wrench.
void add_body_surfaces(World& world, const Loaded& loaded) {
  const Scenario& s = loaded.scenario;
  if (!s.machine) return;
  struct Group {
    int body;
    std::string material;
    std::vector<std::string> names;
    std::vector<dem::TriangleMesh> meshes;
    std::vector<dem::CuttingEdge> edges;
  };
  std::vector<Group> groups;
  const auto wear_of = [&](const std::string& name) {
    const auto& all = s.machine->surfaces;
    return std::find_if(all.begin(), all.end(), [&](const Surface& one) { return one.name == name; })->wear;
  };
  const auto add = [&](int body, const std::string& material, const std::vector<std::string>& names, dem::Shape shape,
                       std::vector<dem::CuttingEdge> edges) {
    dem::Boundary boundary;
    boundary.edges = std::move(edges);
    boundary.name = fmt::format("{}", fmt::join(names, ", "));
    if (std::any_of(names.begin(), names.end(), [&](const std::string& name) { return wear_of(name).has_value(); }))
      boundary.loads.emplace(shape);
    boundary.shape = std::move(shape);
    boundary.material = material_index(s, material);
    boundary.pose = coupling::pose_of(world.machine->body(body));
    const int index = world.bed->add(std::move(boundary));
    for (std::size_t mesh = 0; mesh < names.size(); ++mesh)
      world.surfaces.push_back({.name = names[mesh],
                                .owner = SurfaceRecord::Owner::machine,
                                .boundary = index,
                                .mesh = mesh,
                                .body = body,
                                .moves = true,
                                .wear = wear_of(names[mesh])});
    world.body_surfaces.push_back({body, index});
  };
  for (std::size_t i = 0; i < s.machine->surfaces.size(); ++i) {
    const Surface& surface = s.machine->surfaces[i];
    const dem::Pose place = place_in_body(surface, *s.machine);
    try {
      if (!surface.touches_soil || world.bed == nullptr) {
        world.drawn.push_back({surface.name, surface.body_index, drawn_mesh(surface, *s.machine)});
      } else if (!is_mesh(surface.shape)) {
        add(surface.body_index, surface.material, {surface.name}, contact_shape(surface.shape, place), {});
      } else {
        auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) {
          return g.body == surface.body_index && g.material == surface.material;
        });
        if (group == groups.end())
          group = groups.insert(groups.end(), {surface.body_index, surface.material, {}, {}, {}});
        group->meshes.push_back(mesh_of(surface.shape, place));
        if (surface.cutting) {
          const auto edges = dem::cutting_edges(group->meshes.back(), *surface.cutting);
          group->edges.insert(group->edges.end(), edges.begin(), edges.end());
        }
        group->names.push_back(surface.name);
      }
    } catch (const std::exception& error) {
      throw ScenarioError(loaded.where("machine.surfaces." + surface.name) + ": " + error.what());
    }
  }
  for (const Group& g : groups) add(g.body, g.material, g.names, dem::MeshSurface(g.meshes), g.edges);
}

void add_given_boundaries(World& world, const Loaded& loaded) {
  const Scenario& s = loaded.scenario;
  for (std::size_t i = 0; i < s.boundaries.size(); ++i) {
    const BoundarySection& b = s.boundaries[i];
    dem::Boundary out;
    out.name = b.name;
    out.material = material_index(s, b.material);
    out.pose = motion_of(b)(0);
    out.meets_fixed = b.is_moved();
    try {
      out.shape = contact_shape(b.shape, {});
      if (b.cutting) out.edges = dem::cutting_edges(mesh_of(b.shape, {}), *b.cutting);
    } catch (const std::exception& error) {
      throw ScenarioError(loaded.where(fmt::format("boundaries[{}]", i)) + ": " + error.what());
    }
    if (b.wear) out.loads.emplace(out.shape);
    std::optional<coupling::Servo> servo;
    if (b.servo)
      servo = servo_of(*b.servo, out, world.bed->options().periodic, s.time.end,
                       loaded.where(fmt::format("boundaries[{}].servo", i)));
    const Vec3 reference = b.reference ? out.pose.to_local(*b.reference) : Vec3{};
    const int index = world.bed->add(std::move(out));
    world.surfaces.push_back({.name = b.name,
                              .owner = SurfaceRecord::Owner::given,
                              .boundary = index,
                              .reference = reference,
                              .moves = b.is_moved(),
                              .wear = b.wear});
    if (b.is_moved()) world.motions.push_back({index, motion_of(b), servo});
  }
}

void limit_step(StepReport& report, const dem::StableStep& limit, const std::string& between) {
  if (report.limit.cause.empty() || limit.step < report.limit.step)
    report.limit = {limit.step, limit.cause + ", law between " + between};
}

/// Impacts of the smallest and the largest spheres on bodies of the machine that are not much heavier than they are.
void add_yielding(World& world, const Scenario& scenario, const dem::Law& law, const dem::StepQuestion& question,
                  int sphere, int material, const std::string& between) {
  const int soil_steps = static_cast<int>(scenario.time.machine.soil_steps);
  std::vector<double> radii{question.smallest_radius};
  if (question.largest_radius > 1.01 * question.smallest_radius) radii.push_back(question.largest_radius);
  for (const double radius : radii) {
    const double mass = question.density * dem::sphere_volume(radius);
    for (const YieldingBody& y : yielding_bodies(world, scenario, mass)) {
      if (y.material != material) continue;
      dem::StepQuestion one = question;
      one.smallest_radius = radius, one.body_mass = y.free_mass, one.body_steps = soil_steps;
      const std::string& name = world.machine->system().body_name(y.body);
      limit_step(world.step, dem::stable_step_at_surface(law, one), between + ", on `" + name + "`");
      world.step.impacts.push_back({law, one, true, sphere, material, between, name, y.start_mass});
    }
  }
}

/// A sphere in a fibre has the bonds of its own law and contacts of another at once: in a mode of both, squares of
/// frequencies add up.
class FibreLimits {
 public:
  explicit FibreLimits(const Scenario& s) : s_(s), own_(s.materials.size()), other_(s.materials.size()) {}
  /// The stable step of the law between two materials.
  void take(std::size_t a, std::size_t b, const dem::StableStep& limit, bool at_surface) {
    for (const std::size_t m : {a, b}) {
      if (!is_of_fibres_only(s_, static_cast<int>(m))) continue;
      if (a == b && !at_surface) {
        own_[m] = limit.step;
      } else if (other_[m].step == 0 || limit.step < other_[m].step) {
        other_[m] = {limit.step, s_.materials[m == a ? b : a].name};
      }
      if (at_surface) break;  // b is what it touches
    }
  }
  void limit(StepReport& report) const {
    for (std::size_t m = 0; m < own_.size(); ++m) {
      if (!(own_[m] > 0) || !(other_[m].step > 0)) continue;
      const double both = 1 / std::hypot(1 / own_[m], 1 / other_[m].step);
      if (both < report.limit.step)
        report.limit = {both, fmt::format("bonds of {} and contacts with {} together, {:.4g} s and {:.4g} s alone",
                                          s_.materials[m].name, other_[m].of, own_[m], other_[m].step)};
    }
  }

 private:
  struct Other {
    double step = 0;  ///< s; 0: there is none
    std::string of;
  };
  const Scenario& s_;
  std::vector<double> own_;
  std::vector<Other> other_;
};

/// Counted before the first one.
void refuse_steps_without_number(const World& world, const Loaded& loaded, double smallest_radius) {
  const Scenario& s = loaded.scenario;
  const double count = s.time.end / world.step.soil_step;
  const auto most = static_cast<double>(input_limits().steps);
  if (!s.runs_in_time() || !(count > most)) return;
  const std::string many = fmt::format(
      "{:.3g} s makes {:.3g} steps until {:.6g} s; at most {:.0e}: ", world.step.soil_step, count, s.time.end, most);
  if (s.time.soil_step)
    throw ScenarioError(fmt::format("{} = {}make it longer, or leave it out for a step by the impacts",
                                    loaded.where("time.soil step"), many));
  throw ScenarioError(fmt::format(
      "{}: the soil step of {}it follows from the smallest sphere, of radius {:.3g} m ({}); is the unit of the radius "
      "right? Make it larger, its contacts softer, or the run shorter{}",
      loaded.where("time.end"), many, smallest_radius, world.step.limit.cause, allow_more("steps")));
}

}  // namespace

void choose_step(World& world, const Loaded& loaded, dem::StepQuestion all) {
  const Scenario& s = loaded.scenario;
  StepReport& report = world.step;
  report.impacts.clear();
  all.speed = expected_speed(s, world);
  std::vector<bool> soil(s.materials.size(), false), surface(s.materials.size(), false);
  std::vector<bool> several(s.materials.size(), world.bed->spheres().empty());
  for (const dem::Sphere& sphere : world.bed->spheres()) {
    several[sphere.material] = several[sphere.material] || soil[sphere.material];
    soil[sphere.material] = true;
  }
  // Of a bed that is still to come; a state in which all have fallen out has none.
  if (world.bed->spheres().empty() && s.soil && s.soil->bed && all.largest_radius > 0) {
    const auto expect = [&](const std::string& name) {
      if (!name.empty()) soil[static_cast<std::size_t>(material_index(s, name))] = true;
    };
    expect(s.soil->bed->material);
    for (const Layer& l : s.soil->bed->layers) expect(l.material);
  }
  if (s.soil)
    for (const InletSection& inlet : s.soil->inlets) {
      const auto m = static_cast<std::size_t>(material_index(s, material_of(inlet, s.soil->bed)));
      soil[m] = several[m] = true;
    }
  if (s.soil && s.soil->bed)
    for (const FibreSection& f : s.soil->bed->fibres) {
      const auto m = static_cast<std::size_t>(material_index(s, f.material));
      soil[m] = several[m] = true;
    }
  for (const SurfaceRecord& r : world.surfaces)
    surface[static_cast<std::size_t>(world.bed->boundary(r.boundary).material)] = true;
  FibreLimits of_fibres(s);
  for (std::size_t a = 0; a < soil.size(); ++a)
    for (std::size_t b = 0; b < soil.size(); ++b) {
      const int law = world.laws.of(static_cast<int>(a), static_cast<int>(b));
      if (!soil[a] || !(soil[b] || surface[b])) continue;
      if (a == b && !several[a] && !surface[a] && law < 0) continue;  // a sphere of its material alone meets no other
      if (law < 0)  // materials that only a bed's file names; the others are checked with the scenario
        throw ScenarioError(fmt::format("{}: spheres of {} can meet {}, but there is no law; add `- between: [{}, {}]`",
                                        loaded.where("contacts"), s.materials[a].name, s.materials[b].name,
                                        s.materials[a].name, s.materials[b].name));
      const dem::StepQuestion question = question_between(s, all, static_cast<int>(a), static_cast<int>(b));
      const std::string between = s.materials[a].name + " and " + s.materials[b].name;
      const dem::Law& l = world.laws.laws[static_cast<std::size_t>(law)];
      if (l->bond() != nullptr && !soil[b])
        throw ScenarioError(
            fmt::format("{}: bonds join spheres, and {} is of surfaces only; leave the bond out of this "
                        "entry",
                        loaded.where(fmt::format("contacts[{}].law", law)), s.materials[b].name));
      try {
        for (const dem::ClumpShape& shape : world.bed->clump_shapes()) {
          if (!uses_clump(s, shape.name)) continue;
          if (soil[b]) limit_step(report, dem::stable_step(l, shape, question), between);
          if (surface[b]) limit_step(report, dem::stable_step_at_surface(l, shape, question), between);
        }
        if (soil[b] && question.neighbours > 0) {
          const dem::StableStep limit = dem::stable_step(l, question);
          limit_step(report, limit, between), of_fibres.take(a, b, limit, false);
          report.impacts.push_back({l, question, false, static_cast<int>(a), static_cast<int>(b), between});
        }
        if (surface[b]) {
          const dem::StableStep limit = dem::stable_step_at_surface(l, question);
          limit_step(report, limit, between), of_fibres.take(a, b, limit, true);
          report.impacts.push_back({l, question, true, static_cast<int>(a), static_cast<int>(b), between});
          add_yielding(world, s, l, question, static_cast<int>(a), static_cast<int>(b), between);
        }
      } catch (const std::invalid_argument& error) {
        throw ScenarioError(fmt::format("{}: {}", loaded.where(fmt::format("contacts[{}].law", law)), error.what()));
      }
    }
  of_fibres.limit(report);
  if (report.limit.cause.empty()) report.limit = {1e-4 / s.time.safety, "nothing touches: 0.1 ms taken"};
  report.expected_speed = all.speed;
  report.accurate = report.at_speed(all.speed, s.time.accuracy, s.time.safety * report.limit.step);
  report.soil_step = s.time.soil_step ? *s.time.soil_step : report.accurate.step;
  if (report.soil_step >= report.limit.step)
    throw ScenarioError(
        fmt::format("{} = {:.4g} s: must be below the stable step {:.4g} s, set by {}; use `auto`, softer contacts or "
                    "heavier spheres",
                    loaded.where("time.soil step"), report.soil_step, report.limit.step, report.limit.cause));
  refuse_steps_without_number(world, loaded, all.smallest_radius);
}

namespace {

constexpr double default_lag_steps = 20;  // of a servo

/// A fixed step is that of the motion alone: rows between its ends come from dense output, and change no bit. Methods
/// of variable step only hand out what they have at the rows; instants of which rows of means take the mean are a whole
/// part of the series interval, of 1 ms at most.
double machine_step_alone(const Scenario& s) {
  const double every = s.output.row_interval() > 0 ? s.output.row_interval() : 1e-3;
  const bool fixed = s.analysis == Analysis::dynamics && integrator_of(s) == mbd::IntegratorKind::adams_moulton;
  if (const auto& step = s.time.machine.step) return fixed ? *step : std::min(*step, every);
  if (fixed) return 1e-3;
  return s.output.forces == ForceColumns::mean ? every / std::ceil(every / 1e-3 - 1e-9) : every;
}

/// Of the restitution of an impact at a speed, m/s, with steps of a length, s.
double error_of(const PossibleImpact& i, double speed, double step, double stable) {
  dem::StepQuestion question = i.question;
  question.speed = speed;
  return dem::restitution_error(i.law, question, i.at_surface, step, stable);
}

}  // namespace

dem::AccurateStep StepReport::at_speed(double speed, double tolerance, double longest) const {
  dem::AccurateStep worst{.step = longest};
  std::vector<const PossibleImpact*> resolved;
  for (const PossibleImpact& i : impacts) {
    dem::StepQuestion question = i.question;
    question.speed = speed;
    dem::AccurateStep one = dem::accurate_step(i.law, question, i.at_surface, tolerance, longest);
    if (one.error <= tolerance) resolved.push_back(&i);
    if (one.step > worst.step || (one.step == worst.step && one.error < worst.error)) continue;
    one.cause += (i.at_surface ? ", a surface, law between " : ", law between ") + i.between;
    if (!i.body.empty()) one.cause += ", on `" + i.body + "`";
    worst = one;
  }
  // The error scatters over the steps of a contact: at the shortest of these steps that of another pair may be larger.
  constexpr int most_tries = 20;
  for (int k = 0; k < most_tries; ++k) {
    double largest = 0;
    for (const PossibleImpact* i : resolved) largest = std::max(largest, error_of(*i, speed, worst.step, limit.step));
    worst.error = std::max(largest, worst.error);
    if (largest <= tolerance) break;
    worst.step *= 0.95, worst.error = 0;
  }
  return worst;
}

double StepReport::error_at(double speed) const {
  double worst = 0;
  for (const PossibleImpact& i : impacts) worst = std::max(worst, error_of(i, speed, soil_step, limit.step));
  return worst;
}

ImpactError StepReport::error_where_met(double fastest) const {
  constexpr int parts = 4;
  ImpactError worst{.speed = fastest};
  for (const PossibleImpact& i : impacts) {
    dem::StepQuestion question = i.question;
    question.speed = fastest;
    const double slowest = dem::speed_before_pull(i.law, question, i.at_surface, fastest, limit.step);
    for (int k = slowest < fastest ? 0 : parts; k <= parts; ++k) {
      question.speed = slowest + (fastest - slowest) * k / parts;
      if (!(question.speed > 0)) continue;
      const double error = dem::restitution_error(i.law, question, i.at_surface, soil_step, limit.step);
      if (error > worst.error) worst = {question.speed, error};
    }
  }
  return worst;
}

std::string accuracy_words(const StepReport& step) {
  std::string words =
      fmt::format("accurate step {:.4g} s for impacts at {:.3g} m/s", step.accurate.step, step.expected_speed);
  if (step.accurate.contact > 0)
    words += fmt::format(": the shortest lasts {:.0f} steps", step.accurate.contact / step.soil_step);
  const double error = step.error_at(step.expected_speed), slower = 0.5 * step.expected_speed;
  words += fmt::format(", restitution wrong by up to about {:.2g} with the step used", error);
  if (const double then = step.error_at(slower); then > 1.2 * error && then > 1e-3)
    words += fmt::format(", by {:.2g} at {:.3g} m/s, of which a pull that sets in between steps is a larger share",
                         then, slower);
  std::vector<std::string> bodies;
  double lightest = std::numeric_limits<double>::infinity();
  for (const PossibleImpact& i : step.impacts) {
    if (i.body.empty()) continue;
    lightest = std::min(lightest, i.question.body_mass);
    if (std::count(bodies.begin(), bodies.end(), "`" + i.body + "`") == 0) bodies.push_back("`" + i.body + "`");
  }
  if (bodies.empty()) return words;
  constexpr std::size_t named = 3;
  if (bodies.size() > named + 1) {
    const std::string more = fmt::format("{} more", bodies.size() - named);
    bodies.resize(named), bodies.push_back(more);
  }
  return words + fmt::format(" (against what the law gives; on {} too, {:.3g} g where they yield most)",
                             fmt::join(bodies, ", "), 1e3 * lightest);
}

std::vector<std::string> restitution_warnings(const StepReport& step) {
  constexpr double said = 0.02;
  struct Worst {
    std::string text;
    double difference = 0;
  };
  std::map<std::string, Worst> of_body;
  for (const PossibleImpact& i : step.impacts) {
    if (i.body.empty() || !std::isfinite(i.body_mass)) continue;
    dem::StepQuestion wall = i.question, body = i.question;
    wall.body_mass = std::numeric_limits<double>::infinity(), body.body_mass = i.body_mass;
    const double asked = dem::restitution_at_surface(i.law, wall, step.limit.step),
                 met = dem::restitution_at_surface(i.law, body, step.limit.step);
    Worst& worst = of_body[i.body];
    if (!(std::abs(met - asked) > std::max(said, worst.difference))) continue;
    worst.difference = std::abs(met - asked);
    worst.text = fmt::format(
        "restitution at `{}` is {:.2f} where it yields most, the law between {} has {:.2f}: dampers at surfaces take "
        "the sphere's mass alone ({:.3g} g), and there the body has {:.3g} g at the start; make it heavier or raise "
        "`restitution`",
        i.body, met, i.between, asked, 1e3 * i.question.density * dem::sphere_volume(i.question.smallest_radius),
        1e3 * i.body_mass);
  }
  std::vector<std::string> out;
  for (const auto& [name, worst] : of_body)
    if (!worst.text.empty()) out.push_back(worst.text);
  return out;
}

std::function<dem::Pose(double)> motion_of(const BoundarySection& boundary) {
  // Between its corners each spin acts or does not, and those that act are parallel (check_boundaries).
  std::vector<double> corners;
  for (const Move& m : boundary.moves)
    if (dem::norm(m.spin) > 0) corners.insert(corners.end(), {m.from, m.until});
  std::sort(corners.begin(), corners.end());
  const dem::Pose start = placement(boundary.at, boundary.rotation);
  return [start, corners, moves = boundary.moves](double t) {
    dem::Pose pose = start;  // seen from axes that the velocities carry along, in which points `about` rest
    for (std::size_t k = 0; k + 1 < corners.size() && corners[k] < t; ++k) {
      Vec3 turned, about, turned_about;
      for (const Move& m : moves) {
        if (dem::norm(m.spin) == 0) continue;
        const Vec3 angle = m.spin * (travelled(m, std::min(t, corners[k + 1])) - travelled(m, corners[k]));
        turned += angle;
        if (m.about && angle != Vec3{}) about = *m.about, turned_about += angle;
      }
      if (turned_about != Vec3{})
        pose.position = about + dem::Quaternion::from_rotation_vector(turned_about).rotate(pose.position - about);
      if (turned != Vec3{})
        pose.attitude = (dem::Quaternion::from_rotation_vector(turned) * pose.attitude).normalized();
    }
    for (const Move& m : moves) pose.position += m.velocity * travelled(m, t);
    return pose;
  };
}

void use_soil_step(World& world, const Scenario& s, double step) {
  world.step.soil_step = step;
  world.step.machine_step =
      world.bed != nullptr ? step * static_cast<double>(s.time.machine.soil_steps) : machine_step_alone(s);
  std::size_t next = 0;
  for (const BoundarySection& b : s.boundaries) {
    if (!b.is_moved()) continue;
    if (b.servo && !b.servo->lag) world.motions[next].servo->lag = default_lag_steps * step;
    ++next;
  }
  if (world.machine && !s.machine->beams.empty() && integrator_of(s) == mbd::IntegratorKind::adams_moulton)
    world.step.machine_parts =
        std::max(1.0, std::ceil(world.step.machine_step / longest_machine_step(s, world.machine->system().model())));
}

World build_world(const Loaded& loaded, const BuildOptions& options) {
  const Scenario& s = loaded.scenario;
  World world;
  world.machine = build_machine(loaded, options.machine_start);
  if (s.soil || !s.boundaries.empty()) {
    world.laws = build_laws(loaded);
    dem::BedOptions bed;
    bed.gravity = s.gravity;
    bed.threads = options.threads;
    bed.simd = s.simd, bed.precision = s.precision;
    bed.sample_every = static_cast<int>(s.output.sample_losses_every);
    bed.speed_limit = s.limits.speed;
    bed.overlap_limit = s.limits.overlap;
    if (s.soil && s.soil->container) bed.periodic = periodic_cell(*s.soil->container);
    try {
      world.bed = std::make_unique<dem::Bed>(world.laws, bed);
    } catch (const std::invalid_argument& error) {
      throw ScenarioError(loaded.where("simd") + ": " + error.what());
    }
    SoilBuilder soil(world, loaded, options);
    const bool moving = s.soil && s.soil->moving;
    moving ? build_moving_soil(world, loaded, options, bed) : soil.place();
    // The machine's and given surfaces join after settling; the step must hold for them too, so it is chosen with all.
    const bool settles = soil.settles() && options.settle;
    if (moving || !settles) {
      if (!moving) soil.finish();
      add_given_boundaries(world, loaded);
      add_body_surfaces(world, loaded);
      choose_step(world, loaded, soil.question());
    } else {
      choose_step(world, loaded, soil.question());
      // On the way to rest only the stability of the step matters.
      soil.settle(s.time.soil_step ? *s.time.soil_step : s.time.safety * world.step.limit.step);
      soil.finish();
      add_given_boundaries(world, loaded);
      add_body_surfaces(world, loaded);
      choose_step(world, loaded, soil.question());
    }
    // A bed that was stopped on its way to rest is only written out: it need not be fit for the machine, nor for
    // boundaries that the scenario places, which do not act on it.
    if (world.soil.stopped) {
      for (const SurfaceRecord& r : world.surfaces)
        if (r.owner != SurfaceRecord::Owner::container) world.bed->boundary(r.boundary).active = false;
      if (world.fibres.empty()) world.fibres = groups_without_fibres(s);  // their columns are there all the same
    } else {
      if (moving) find_followed(world, loaded);
      if (options.place_soil) clear_machine(world, loaded, soil.is_loose());
      if (moving && world.soil.carved > 0) count_window(world);
      soil.check_wheel_datum();
      if (s.soil && s.soil->active) world.bed->set_active(active_rule(*s.soil->active));
      world.bed->let_bonds_form();  // a restart puts in place of it what the state says
    }
  } else {
    add_body_surfaces(world, loaded);
  }
  if (world.bed && options.place_soil && !world.soil.stopped) {
    try {
      world.bed->require_room();
    } catch (const std::invalid_argument& error) {
      throw ScenarioError(loaded.where("soil.container") + ": " + error.what());
    }
  }
  use_soil_step(world, s, world.step.soil_step);
  if (options.place_soil && !world.fibres.empty()) world.soil.fibres = fibre_facts(world);
  if (!options.place_soil) world.fibres = fibre_groups(s);  // a restart numbers them
  add_inlets(world, loaded);
  world.travel = travel_direction(s, world);
  return world;
}

void add_sphere_forces(World& world, const Loaded& loaded, const std::vector<dem::NamedSphereForce>& forces) {
  for (const dem::NamedSphereForce& f : forces) {
    if (!world.bed)
      throw ScenarioError(loaded.where("soil") + ": force on spheres '" + f.name +
                          "': the scenario has no soil; give it `soil`, or leave the force out of the program");
    try {
      world.bed->add_force(f.name, f.force);
    } catch (const std::invalid_argument& error) {
      throw ScenarioError(loaded.where("soil") + ": " + error.what());
    }
  }
}

}  // namespace subsoil::sim
