#include "libsim/studies/credibility/axes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "libdem/laws/hysteretic.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {
namespace {

constexpr double packing_jitter = 0.05;  // of the radius: a lattice is one packing, shaken ones are others

std::string lengths(const Vec3& v) { return fmt::format("{} {} {} m", v.x, v.y, v.z); }

class AxisList {
 public:
  explicit AxisList(const Loaded& loaded)
      : loaded_(loaded), s_(loaded.scenario), tree_(explicit_tree(loaded.scenario)) {}

  Axes all() {
    out_.axes.push_back({"as given", "nothing", {}});
    step();
    stiffness();
    radius();
    bins();
    packings();
    coupling();
    return std::move(out_);
  }

 private:
  const BedSection& bed() const { return *s_.soil->bed; }
  void absent(const std::string& name, const std::string& why) { out_.absent.push_back({name, why}); }

  void step() {
    Axis a{"step", "half the step", {}, 1, 2};
    a.refinement = true;
    // Where it is left out it follows from the accuracy of impacts or from stability; halving what either is asked for
    // would not halve it.
    const double step = s_.time.soil_step ? *s_.time.soil_step : build_world(loaded_, {.settle = false}).step.soil_step;
    a.sets.push_back(fmt::format("time.soil step={} s", 0.5 * step));
    out_.axes.push_back(a);
  }

  /// All that the laws call a stiffness or make one of, of cement and of materials too; what is given as a share of a
  /// stiffness is halved, so that the attraction itself stays.
  void stiffness() {
    Axis a{"stiffness", "twice the stiffness of every contact, attraction as before", {}, 1, std::sqrt(2.0)};
    for (const Contact& c : s_.contacts) {
      const std::string path = "contacts." + c.between[0] + "-" + c.between[1] + ".";
      for (const char* key : {"K_X", "K_Y", "k_n", "c", "k1", "k2", "K1", "K2", "E_eff", "G_eff", "yield strength",
                              "k_r", "bond modulus"})
        take_scaled(a, path + key, 2);
      take_yield(a, c, path);
      take_scaled(a, path + "adhesive ratio", 0.5);
    }
    for (const Material& m : s_.materials) take_scaled(a, "materials." + m.name + ".young's modulus", 2);
    a.sets.empty() ? absent(a.name, "no contact states a stiffness") : out_.axes.push_back(a);
  }

  /// K1 = 5 r_eff S_y with the materials' S_y: the pair gets twice it as its own, since impacts depend on theirs.
  void take_yield(Axis& a, const Contact& c, const std::string& path) const {
    const auto* law = c.law.get_if<dem::Hysteretic>();
    if (law == nullptr || !law->needs_yield()) return;
    double yield = std::numeric_limits<double>::infinity();
    for (const Material& m : s_.materials)
      if (m.yield && (m.name == c.between[0] || m.name == c.between[1])) yield = std::min(yield, *m.yield);
    if (std::isfinite(yield)) a.sets.push_back(fmt::format("{}yield strength={} Pa", path, 2 * yield));
  }

  /// Adds path=factor x value where the scenario has one there.
  bool take_scaled(Axis& a, const std::string& path, double factor) const {
    try {
      a.sets.push_back(path + "=" + scaled_value(tree_, path, factor));
      return true;
    } catch (const std::invalid_argument&) {
      return false;
    }
  }

  void radius() {
    Axis a{"radius", "half the radius of the spheres, values of contacts as given", {}, 8, std::sqrt(8.0)};
    a.refinement = true;
    if (bed().fill == Fill::particles || bed().fill == Fill::file)
      return absent(a.name, "the spheres of the bed are listed one by one");
    for (const Layer& l : bed().layers)
      if (const auto* equal = std::get_if<EqualRadius>(&l.radius); equal == nullptr || std::isfinite(equal->radius))
        return absent(a.name, "layers have radii of their own");
    bool any = take_scaled(a, "soil.bed.radius", 0.5);
    for (const char* key : {"normal", "deviation", "minimum", "maximum", "uniform"})
      any = take_scaled(a, std::string("soil.bed.radius.") + key, 0.5) || any;
    if (!any) return absent(a.name, "a table of radii is not halved");
    if (bed().pitch) a.sets.push_back(fmt::format("soil.bed.pitch={} m", 0.5 * *bed().pitch));
    if (bed().count) a.sets.push_back(fmt::format("soil.bed.count={}", 8 * *bed().count));
    out_.axes.push_back(a);
  }

  /// Where the tool comes from: mean place of what touches the soil against the middle of the bin.
  double travel() const {
    double sum = 0;
    int count = 0;
    if (s_.machine)
      for (const Surface& surface : s_.machine->surfaces)
        if (surface.touches_soil)
          sum += s_.machine->bodies[static_cast<std::size_t>(surface.body_index - 1)].at[0], ++count;
    for (const BoundarySection& b : s_.boundaries)
      if (!b.moves.empty()) sum += b.at.x, ++count;
    if (count == 0) return 0;
    return sum / count < s_.soil->container->at.x + 0.5 * s_.soil->container->size.x ? 1 : -1;
  }

  void bins() {
    if (!s_.soil->container) return absent("bin", "the soil has no container");
    if (bed().fill == Fill::particles || bed().fill == Fill::file)
      return absent("bin", "the spheres of the bed are listed one by one");
    const double way = travel();
    bin("bin along the travel", "twice the length of the bin", 0, way > 0 ? 0 : way < 0 ? 1 : 0.5);
    below();
    bin("bin across", "twice the width of the bin", 2, 0.5);
  }

  /// Doubles one size; `before`: the share of the added size that lies on the side of least coordinates.
  void bin(const char* name, const char* change, int axis, double before) {
    if (s_.soil->container->periodic[static_cast<std::size_t>(axis)])
      return absent(name, "its sides are periodic: a tool that spans them works twice the soil in twice the cell");
    Axis a{name, change, {}, 2, 1};
    const auto grown = [&](Vec3 size, Vec3 at, const std::string& path) {
      at[axis] -= before * size[axis], size[axis] *= 2;
      a.sets.push_back(path + ".size=" + lengths(size));
      a.sets.push_back(path + ".at=" + lengths(at));
    };
    grown(s_.soil->container->size, s_.soil->container->at, "soil.container");
    if (bed().region) grown(bed().region->size, bed().region->at, "soil.bed.region");
    if (bed().count) a.sets.push_back(fmt::format("soil.bed.count={}", 2 * *bed().count));
    out_.axes.push_back(a);
  }

  /// Twice the depth of the bed. The floor goes down by as much as the bed gets deeper: its surface and the rims of
  /// the walls stay where the tool meets them.
  void below() {
    Axis a{"bin below", "twice the depth of the bed", {}, 2, 1};
    const Vec3 box = bed().region ? bed().region->size : s_.soil->container->size;
    if (bed().count && !bed().depth && !s_.soil->surface)
      return absent(a.name, "where the surface of a bed of a given count lies is known only when it has settled");
    const double deep = depth(box.y);
    const auto lowered = [&](Vec3 size, Vec3 at, const std::string& path) {
      at.y -= deep, size.y += deep;
      a.sets.push_back(path + ".size=" + lengths(size));
      a.sets.push_back(path + ".at=" + lengths(at));
    };
    lowered(s_.soil->container->size, s_.soil->container->at, "soil.container");
    if (bed().region) lowered(bed().region->size, bed().region->at, "soil.bed.region");
    if (bed().count) a.sets.push_back(fmt::format("soil.bed.count={}", 2 * *bed().count));
    if (bed().depth) a.sets.push_back(fmt::format("soil.bed.depth={} m", 2 * *bed().depth));
    if (!bed().layers.empty()) deepen_lowest_layer(a, deep);
    out_.axes.push_back(a);
  }

  /// Of the bed: as given, or what layers that end make, or all that it may fill.
  double depth(double height) const {
    const std::vector<Layer>& layers = bed().layers;
    if (layers.empty() || (!layers.back().depth && !layers.back().thickness)) return bed().depth.value_or(height);
    double sum = 0;
    for (const Layer& l : layers) sum += l.depth ? (*l.depth)[1] - (*l.depth)[0] : *l.thickness;
    return sum;
  }

  void deepen_lowest_layer(Axis& a, double by) const {
    const Layer& lowest = bed().layers.back();
    const std::string path = fmt::format("soil.bed.layers[{}].", bed().layers.size() - 1);
    if (lowest.thickness) a.sets.push_back(fmt::format("{}thickness={} m", path, *lowest.thickness + by));
    if (lowest.depth)
      a.sets.push_back(fmt::format("{}depth={} {} m", path, (*lowest.depth)[0], (*lowest.depth)[1] + by));
  }

  void packings() {
    if (bed().fill == Fill::particles || bed().fill == Fill::file)
      return absent("packing", "the spheres of the bed are listed one by one");
    const bool lattice = bed().fill != Fill::random && bed().jitter == 0;
    out_.base_is_packing = !lattice;
    for (long k = 1; k <= 3; ++k) {
      Axis a{fmt::format("packing {}", k),
             lattice ? fmt::format("the lattice shaken by {} of a radius, seed {}", packing_jitter, bed().seed + k)
                     : fmt::format("seed {}", bed().seed + k),
             {fmt::format("soil.bed.seed={}", bed().seed + k)}};
      if (lattice) a.sets.push_back(fmt::format("soil.bed.jitter={}", packing_jitter));
      a.packing = true;
      out_.axes.push_back(a);
    }
  }

  void coupling() {
    if (!s_.machine) return absent("coupling step", "there is no machine");
    out_.axes.push_back({"coupling step",
                         "machine and soil exchange half as often",
                         {fmt::format("time.machine.soil steps per machine step={}", 2 * s_.time.machine.soil_steps)}});
    if (s_.time.coupling == CouplingWord::iterated)
      absent("iterated coupling", "machine and soil agree in each step already");
    else
      out_.axes.push_back({.name = "iterated coupling",
                           .change = "machine and soil agree in each step",
                           .sets = {"time.coupling=iterated"},
                           .steps = 3});  // a step is taken again until they agree: twice to three times
  }

  const Loaded& loaded_;
  const Scenario& s_;
  Node tree_;
  Axes out_;
};

}  // namespace

Axes credibility_axes(const Loaded& loaded) {
  if (!loaded.scenario.soil || !loaded.scenario.soil->bed)
    throw ScenarioError(loaded.where("soil.bed") +
                        ": is missing: step, stiffness, radius, bin and packing are those of a bed of spheres");
  return AxisList(loaded).all();
}

void keep_axes(Axes& axes, const std::vector<std::string>& words) {
  if (words.empty()) return;
  const auto begins = [](const std::string& name, const std::string& word) {
    return name == word || name.rfind(word + " ", 0) == 0;
  };
  std::vector<std::string> known;
  for (std::size_t k = 1; k < axes.axes.size(); ++k) known.push_back(axes.axes[k].name);
  for (const std::string& word : words)
    if (std::none_of(known.begin(), known.end(), [&](const std::string& name) { return begins(name, word); }))
      throw std::invalid_argument(
          fmt::format("{}: no axis of this scenario; there are {}", word, fmt::join(known, ", ")));
  std::vector<Axis> kept{axes.axes.front()};
  for (std::size_t k = 1; k < axes.axes.size(); ++k) {
    const std::string& name = axes.axes[k].name;
    if (std::any_of(words.begin(), words.end(), [&](const std::string& word) { return begins(name, word); }))
      kept.push_back(axes.axes[k]);
    else
      axes.absent.push_back({name, "left out by --axes"});
  }
  axes.axes = std::move(kept);
}

}  // namespace subsoil::sim
