#include "libsim/view/show.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "coupling/simulation.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/run/input_report.hpp"
#include "libsim/run/surface_report.hpp"
#include "libsim/setup/machine.hpp"
#include "libsim/setup/shapes.hpp"
#include "libsim/setup/world.hpp"
#include "libsim/view/packed.hpp"
#include "libsim/view/page.hpp"

namespace subsoil::sim {
namespace {

constexpr int samples = 120;           // of a motion: 2 pixels each of a path across a picture
constexpr double longest_step = 1e-3;  // s, of a machine with fixed steps
constexpr double patience = 2;         // s of wall time for the motion of the machine

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

Poses poses_of(const mbd::Machine& machine) {
  Poses out;
  for (int i = 0; i < machine.system().bodies(); ++i) out.push_back(machine.body(i));
  return out;
}

/// The scenario without soil, for the motion of its machine alone.
Loaded machine_of(const Loaded& loaded) {
  Loaded out = loaded;
  out.scenario.soil.reset();
  out.scenario.boundaries.clear();
  return out;
}

/// Poses at the times of the motion; those that the machine does not come to are cut off.
void move_machine(const Loaded& loaded, SceneMotion& motion) {
  const Loaded alone = machine_of(loaded);
  const std::unique_ptr<mbd::Machine> machine = build_machine(alone);
  const bool soil = loaded.scenario.has_bed();
  motion.note = soil ? "machine: its motion without soil" : "machine: its motion";
  motion.bodies.push_back(poses_of(*machine));
  if (motion.times.size() == 1) motion.note = "machine: as it starts";
  const Clock::time_point begin = Clock::now();
  try {
    for (std::size_t k = 1; k < motion.times.size(); ++k) {
      const double way = motion.times[k] - motion.times[k - 1];
      const int parts = static_cast<int>(std::ceil(way / longest_step));
      for (int part = 0; part < parts; ++part) machine->advance(way / parts);
      motion.bodies.push_back(poses_of(*machine));
      if (seconds_since(begin) > patience && k + 1 < motion.times.size()) {
        motion.note += fmt::format(", as far as {:.0f} s of computing come", patience);
        break;
      }
    }
  } catch (const std::exception& error) {
    motion.note += fmt::format(", which ends at {:.4g} s: {}", motion.times[motion.bodies.size() - 1], error.what());
  }
  motion.times.resize(motion.bodies.size());
}

/// Moving surfaces of a motion that is predicted, for what is read off the tool.
class PredictedSurfaces final : public SurfaceSamples {
 public:
  PredictedSurfaces(const Scenario& s, const SceneMotion& motion) : motion_(motion) {
    if (s.machine && motion.bodies.size() == motion.times.size())
      for (const Surface& one : s.machine->surfaces)
        if (one.touches_soil && is_mesh(one.shape)) add(one.name, drawn_mesh(one, *s.machine), one.body_index, 0);
    for (const BoundarySection& b : s.boundaries) {
      const auto path = std::find(motion.path_names.begin(), motion.path_names.end(), b.name);
      if (path != motion.path_names.end() && is_mesh(b.shape))
        add(b.name, mesh_of(b.shape, {}), 0, static_cast<std::size_t>(path - motion.path_names.begin()));
    }
  }
  const std::vector<double>& times() const override { return motion_.times; }
  const std::vector<FrameSurface>& surfaces() const override { return surfaces_; }
  std::vector<double> surface(std::size_t sample, const FrameSurface& s) const override {
    const Carrier& carrier = carriers_[static_cast<std::size_t>(&s - surfaces_.data())];
    const dem::Pose pose = carrier.body > 0
                               ? coupling::pose_of(motion_.bodies[sample][static_cast<std::size_t>(carrier.body)])
                               : motion_.paths[sample][carrier.path];
    std::vector<double> out;
    for (std::size_t i = 0; i + 2 < s.vertices.size(); i += 3) {
      const Vec3 p = pose.to_world({s.vertices[i], s.vertices[i + 1], s.vertices[i + 2]});
      out.insert(out.end(), {p.x, p.y, p.z});
    }
    return out;
  }

 private:
  struct Carrier {
    int body;  // 0: a path
    std::size_t path;
  };
  void add(const std::string& name, const dem::TriangleMesh& mesh, int body, std::size_t path) {
    FrameSurface s;
    s.name = name, s.moves = true;
    for (const Vec3& v : mesh.vertices())
      for (const double x : {v.x, v.y, v.z}) s.vertices.push_back(static_cast<float>(x));
    for (const dem::Triangle& t : mesh.triangles())
      s.triangles.push_back({static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2])});
    surfaces_.push_back(std::move(s));
    carriers_.push_back({body, path});
  }

  const SceneMotion& motion_;
  std::vector<FrameSurface> surfaces_;
  std::vector<Carrier> carriers_;
};

Json sphere_json(const World& world, const Scenario& s) {
  const std::span<const dem::Sphere> spheres = world.bed->spheres();
  dem::Bounds box;
  std::vector<float> position, radius;
  std::vector<int> material;
  std::vector<std::string> names;
  for (const Material& m : s.materials) names.push_back(m.name);
  for (const dem::Sphere& one : spheres) {
    box.include(one.x);
    for (const double v : {one.x.x, one.x.y, one.x.z}) position.push_back(static_cast<float>(v));
    radius.push_back(static_cast<float>(one.r));
    material.push_back(one.material);
  }
  ScenePack pack(spheres.size(), box.low, box.high);
  Json out = sphere_table(pack, radius, material, names);
  out["frames"].push_back({{"time", 0.0}, {"position", pack.frame(position, {})}});
  return out;
}

/// Where a bed that is poured will lie.
struct PouredBed {
  Vec3 low, high;
  std::optional<double> surface;
  double up = 0;  // of the container, m
};

PouredBed poured_bed(const Soil& soil) {
  const BedSection& bed = *soil.bed;
  PouredBed out;
  if (bed.region)
    out.low = bed.region->at, out.high = bed.region->at + bed.region->size;
  else if (soil.container)
    out.low = soil.container->at, out.high = soil.container->at + soil.container->size;
  std::optional<double> depth = bed.depth;
  if (!depth && !bed.layers.empty()) {
    double sum = 0;
    bool known = true;
    for (const Layer& l : bed.layers) known = known && l.thickness, sum += l.thickness.value_or(0);
    if (known) depth = sum;
  }
  if (depth) out.surface = out.low.y + *depth;
  if (soil.surface && out.surface) out.up = *soil.surface - *out.surface;
  if (soil.surface) out.surface = soil.surface;
  out.low.y += out.up, out.high.y += out.up;
  return out;
}

Json bed_json(const SceneMaker& maker, const Soil& soil, const PouredBed& poured) {
  const auto array = [](const Vec3& p) { return Json{p.x, p.y, p.z}; };
  Json layers = Json::array();
  double top = poured.surface.value_or(poured.high.y);
  for (const Layer& l : soil.bed->layers) {
    const double from = l.depth ? poured.surface.value_or(poured.high.y) - (*l.depth)[0] : top;
    const double until = l.depth       ? poured.surface.value_or(poured.high.y) - (*l.depth)[1]
                         : l.thickness ? from - *l.thickness
                                       : poured.low.y;
    layers.push_back({{"name", l.material}, {"from", from}, {"until", until}});
    top = until;
  }
  return {{"thing", maker.thing("soil.bed")},
          {"low", array(poured.low)},
          {"high", array(poured.high)},
          {"surface", poured.surface ? Json(*poured.surface) : Json()},
          {"note", ""},
          {"layers", layers}};
}

/// Largest side of the container, for planes, which have no size of their own.
double plane_size(const Scenario& s) {
  if (!s.soil || !s.soil->container) return 1;
  return std::max({s.soil->container->size.x, s.soil->container->size.y, s.soil->container->size.z});
}

/// Puts bed and container into the scene; y of the soil's surface, where it is known.
std::optional<double> add_soil(SceneMaker& maker, const World& world, const Scenario& s) {
  if (!s.soil) return {};
  const bool poured = s.soil->bed && s.soil->bed->fill == Fill::random;
  if (poured) {
    const PouredBed bed = poured_bed(*s.soil);
    maker.add_container(bed.up);
    maker.json()["bed"] = bed_json(maker, *s.soil, bed);
    maker.note("bed: the region that will be filled; its spheres are poured when it runs");
    return bed.surface;
  }
  maker.add_container(world.container_shift);
  if (!world.bed || world.bed->spheres().empty()) return {};
  maker.json()["spheres"] = sphere_json(world, s);
  if (s.soil->bed && s.soil->bed->settles()) maker.note("bed: spheres as placed, before they settle");
  return s.soil->surface ? *s.soil->surface : world.soil.surface_mean;
}

}  // namespace

SceneMotion predicted_motion(const Loaded& loaded) {
  const Scenario& s = loaded.scenario;
  SceneMotion out;
  for (const BoundarySection& b : s.boundaries)
    if (b.is_moved()) out.path_names.push_back(b.name);
  const bool moves = s.runs_in_time() && (s.machine || !out.path_names.empty());
  for (int k = 0; k <= (moves ? samples : 0); ++k) out.times.push_back(s.time.end * k / samples);
  if (s.machine) move_machine(loaded, out);
  for (const BoundarySection& b : s.boundaries)
    if (b.is_moved() && b.servo)
      out.note += (out.note.empty() ? "" : "; ") + b.name + ": where it starts, its servo moves it";
  for (const double t : out.times) {
    std::vector<dem::Pose> sample;
    for (const BoundarySection& b : s.boundaries)
      if (b.is_moved()) sample.push_back(motion_of(b)(t));
    out.paths.push_back(std::move(sample));
  }
  if (!out.path_names.empty() && out.note.empty()) out.note = "surfaces on their given paths";
  return out;
}

Json show_scene(const Loaded& loaded, const ShowRequest& request) {
  const Scenario& s = loaded.scenario;
  BuildOptions options;
  options.threads = static_cast<int>(s.time.threads);
  options.settle = false;
  World world = build_world(loaded, options);
  SceneMaker maker(loaded, "show");
  maker.json()["file"] = request.scenario;
  const SceneMotion motion = predicted_motion(loaded);
  maker.add_surfaces(motion, plane_size(s));
  maker.add_motion(motion);
  const std::optional<double> surface = add_soil(maker, world, s);
  if (surface) {
    std::map<std::string, std::string> body_of;
    if (s.machine)
      for (const Surface& one : s.machine->surfaces) body_of[one.name] = one.body;
    if (const auto tool = tool_path(PredictedSurfaces(s, motion), *surface, body_of, world.bed->options().periodic))
      maker.add_tool(*tool, motion.times);
  }
  const std::vector<SurfaceFacts> facts = surface_facts(world, s, s.time.end);
  maker.add_warnings(surface_warnings(facts, world));
  maker.add_warnings(input_warnings(loaded, world, request.scenario, request.sets));
  return maker.json();
}

void write_show(const ShowRequest& request) {
  const Loaded loaded = load_scenario(request.scenario, request.sets);
  write_atomically(request.out, scene_page(show_scene(loaded, request)));
}

}  // namespace subsoil::sim
