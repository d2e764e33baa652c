#include "libsim/studies/wear/worn_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "libdem/particles/cell_area.hpp"
#include "libsim/document/document.hpp"
#include "libsim/post/disturbance.hpp"
#include "libsim/post/frames_file.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/laws.hpp"
#include "libsim/setup/shapes.hpp"
#include "libsim/studies/sweep/plan.hpp"

namespace subsoil::sim {
namespace {

const char* word_of(WearLaw law) { return law == WearLaw::archard ? "Archard" : "Finnie"; }

[[noreturn]] void refuse_run(const RunFolder& run, const std::string& rule) {
  throw std::invalid_argument(fmt::format("{}: {}", run.path.string(), rule));
}

/// A surface of the scenario that keeps its wear.
struct Keeps {
  std::string name, key, material;
  const Shape* shape;
  dem::Pose place;  ///< of the shape in the axes in which the run has it
  WearSection wear;
};

std::vector<Keeps> keeping(const Scenario& s) {
  std::vector<Keeps> out;
  if (s.machine)
    for (const Surface& one : s.machine->surfaces)
      if (one.wear)
        out.push_back({one.name, "machine.surfaces." + one.name, one.material, &one.shape,
                       place_in_body(one, *s.machine), *one.wear});
  for (const BoundarySection& one : s.boundaries)
    if (one.wear) out.push_back({one.name, "boundaries." + one.name, one.material, &one.shape, {}, *one.wear});
  return out;
}

WearLaw law_of(const RunFolder& run, const Keeps& one, std::optional<WearLaw> wanted) {
  const bool archard = one.wear.has_archard(), finnie = one.wear.has_finnie();
  if (archard && finnie && !wanted)
    refuse_run(run,
               fmt::format("{} has constants of Archard's law and of Finnie's, which are two models of the same loss; "
                           "choose one by --law archard or --law finnie",
                           one.key));
  const WearLaw law = wanted.value_or(archard ? WearLaw::archard : WearLaw::finnie);
  if (!(law == WearLaw::archard ? archard : finnie))
    refuse_run(run, fmt::format("{} has no constants of {}'s law in `wear`; run with {}", one.key, word_of(law),
                                law == WearLaw::archard ? "`coefficient` and `hardness`" : "`finnie`"));
  return law;
}

/// The triangles of a shape in its own axes, in the order in which the run keeps their loads. Where the sides of a
/// cylinder begin depends on the axes in which it is drawn.
dem::TriangleMesh own_mesh(const Keeps& one) {
  if (is_mesh(*one.shape)) return mesh_of(*one.shape, {});
  const dem::Quaternion back = one.place.attitude.conjugate();
  return drawing_of(contact_shape(*one.shape, one.place), 1.0).placed({-back.rotate(one.place.position), back});
}

/// In which frames keep the depth of wear of each triangle.
std::string depth_array(const Keeps& one, WearLaw law) {
  return fmt::format("loads/{}/{} wear depth", one.name, word_of(law));
}

WornSurface worn_surface(const RunFolder& run, const FramesFile& frames, const Keeps& one, WearLaw law) {
  WornSurface out;
  out.name = one.name, out.key = one.key, out.mesh = own_mesh(one), out.law = law;
  out.density = run.scenario->materials[static_cast<std::size_t>(material_index(*run.scenario, one.material))].density;
  out.volume = run.number({"wear", one.name, word_of(law), "worn volume [m3]"});
  if (!std::isfinite(out.volume))
    refuse_run(run, fmt::format("summary.json has no worn volume of {}; let the run come to its end", one.name));
  const std::size_t last = frames.times().size() - 1;
  const std::string array = depth_array(one, law);
  if (!frames.holds(last, array)) refuse_run(run, fmt::format("the last frame of run.h5 has no `{}`", array));
  const std::vector<float> depths = frames.numbers(last, array);
  if (depths.size() != out.mesh.triangles().size())
    refuse_run(run,
               fmt::format("{} has {} triangles and the frames have {}: its mesh file is no longer that of the run",
                           one.name, out.mesh.triangles().size(), depths.size()));
  // Beyond periodic sides a surface is as worn as within them.
  const dem::PeriodicCell cell = periodic_cell(&*run.scenario);
  const std::vector<double> met = dem::areas_met(out.mesh.placed(one.place), cell),
                            whole = dem::areas_met(out.mesh, {});
  double shown = 0;
  for (std::size_t t = 0; t < depths.size(); ++t)
    shown += depths[t] * met[t], out.volumes.push_back(depths[t] * whole[t]);
  if (shown == 0 && out.volume > 0)
    refuse_run(run, fmt::format("all wear of {} came after the last frame; lower output.every", one.name));
  // Frames round each depth to a relative 3e-5, and end with the last of them: the volume is that of the summary.
  out.share = out.volume > 0 ? shown / out.volume : 1;
  if (shown > 0)
    for (double& v : out.volumes) v *= out.volume / shown;
  if (cell.any()) out.volume = std::accumulate(out.volumes.begin(), out.volumes.end(), 0.0);
  return out;
}

void on_one_line(Node& node) {
  node.flow = true, node.comment.clear();
  for (Node& item : node.items) on_one_line(item);
  for (Node::Entry& e : node.entries) on_one_line(e.value);
}

std::string one_line(Node node) {
  on_one_line(node);
  Node tree = Node::mapping();
  tree.add("value", std::move(node));
  const std::string text = emit(tree);
  return text.substr(7, text.size() - 8);  // without `value: ` and the end of the line
}

/// Wear counts from the start of the motion, the travel in frames from the first of them.
void refuse_wear_before_frames(const RunFolder& run) {
  const FramesFile frames(run.path / "run.h5");
  for (const Keeps& one : keeping(*run.scenario))
    for (const WearLaw law : {WearLaw::archard, WearLaw::finnie}) {
      const std::string array = depth_array(one, law);
      if (!frames.holds(0, array)) continue;
      const std::vector<float> depths = frames.numbers(0, array);
      if (std::any_of(depths.begin(), depths.end(), [](float d) { return d > 0; }))
        refuse_run(run,
                   fmt::format("{} has worn before the first frame, at {:g} s, from which the travel is taken; give "
                               "--length, the travel since the wear began, or run with frames from the start",
                               one.name, frames.times().front()));
    }
}

}  // namespace

std::vector<WornSurface> worn_surfaces(const RunFolder& run, std::optional<WearLaw> law) {
  if (!run.scenario || !run.frames)
    refuse_run(run, "needs scenario.yaml and run.h5: name the result directory of a run");
  std::vector<Keeps> all = keeping(*run.scenario);
  std::erase_if(all, [](const Keeps& one) { return !one.wear.has_archard() && !one.wear.has_finnie(); });
  if (all.empty())
    refuse_run(run, "no surface of this run wears; give one `wear: {coefficient: K, hardness: H}` and run again");
  const FramesFile frames(run.path / "run.h5");
  if (frames.times().empty()) refuse_run(run, "run.h5 holds no complete frame");
  std::vector<WornSurface> out;
  for (const Keeps& one : all) out.push_back(worn_surface(run, frames, one, law_of(run, one, law)));
  return out;
}

WorkedStrip worked_strip(const RunFolder& run, std::optional<double> width, std::optional<double> length) {
  WorkedStrip out{width.value_or(0), length.value_or(0), "as given"};
  if (width && length) return out;
  const std::optional<ToolPath> tool = disturbance_of(run.path).tool;
  constexpr double turns_in_place = 1e-3;  // of the width: frames round places, so that the travel is not 0
  if (!tool || !(tool->width > 0) || !(length || tool->travel > turns_in_place * tool->width))
    refuse_run(run,
               "the frames show no tool that travels in soil, which would give width and length of what was worked; "
               "give --width and --length, or --passes in place of --hectares");
  if (!width) out.width = tool->width;
  if (!length) refuse_wear_before_frames(run), out.length = tool->travel;
  out.source = fmt::format("width {}, length {}", width ? "as given" : "of the tool in the soil",
                           length ? "as given" : "of its travel, from the frames");
  return out;
}

Scenario with_meshes(Scenario scenario, const std::vector<WornSurface>& surfaces,
                     const std::vector<std::string>& files) {
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    const Shape shape = MeshShape{files[k], 1.0};
    if (scenario.machine)
      for (Surface& one : scenario.machine->surfaces)
        if ("machine.surfaces." + one.name == surfaces[k].key) one.shape = shape;
    for (BoundarySection& one : scenario.boundaries)
      if ("boundaries." + one.name == surfaces[k].key) one.shape = shape;
  }
  return scenario;
}

std::vector<std::string> sets_of_meshes(const Scenario& scenario, const std::vector<WornSurface>& surfaces,
                                        const std::vector<std::string>& files) {
  const Node tree = explicit_tree(with_meshes(scenario, surfaces, files));
  std::vector<std::string> out;
  for (const WornSurface& one : surfaces) {
    const Node* const node = find_path(tree, one.key);
    if (node == nullptr)
      throw std::invalid_argument(
          fmt::format("{}: --set finds no such surface; give it a name without `.` and `[`", one.key));
    out.push_back(one.key + "=" + one_line(*node));
  }
  return out;
}

}  // namespace subsoil::sim
