#include "libsim/scenario/sections/clumps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "libsim/document/refusal.hpp"
#include "libsim/keys/clump_file.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

void describe(Fields& v, ClumpSphere& s) {
  v.vector("at", s.at, "m", "its centre, in axes of the clump");
  v.quantity("radius", s.radius, "m", "(0, inf)", "its radius");
}

namespace {

/// Read with the scenario, whose explicit copy then lists the spheres.
struct ClumpImport {
  std::string file;
  double unit = required;
};

void describe_import(Fields& v, ClumpImport& from, std::vector<ClumpSphere>& spheres) {
  v.file("file", from.file,
         "text file beside the scenario, x y z radius of a sphere in every line: of LIGGGHTS, YADE, CLUMP, MercuryDPM "
         "or DEME; `#` begins a comment, `#format x_y_z_r_matId` names columns");
  v.unit("unit", from.unit, "m", "unit of the file's numbers");
  if (!std::filesystem::is_regular_file(from.file) || std::isnan(from.unit)) return;  // refused above
  if (!spheres.empty()) throw Refusal("stands beside `spheres`", "keep one of them");
  for (const dem::ClumpMember& m : load_clump(from.file, from.unit)) spheres.push_back({m.at, m.radius});
}

}  // namespace

void describe(Fields& v, ClumpSection& c) {
  v.list("spheres", c.spheres, "the spheres that it is made of; they may overlap, matter that they share counts once");
  ClumpImport from;
  SectionMember import;
  import.when = SectionMember::When::given, import.there = false;
  import.declare = [&](Fields & fields) { describe_import(fields, from, c.spheres);
};
import.prototype = import.declare;
v.visit_section({"import", "in place of `spheres`: they come from a file"}, import);
v.quantity("scale", c.scale, "1", "(0, inf)", "factor on all lengths of its spheres");
v.quantity("density", c.density, "kg/m^3", "(0, inf)", "left out: of the bed's material");
v.quantity("mass", c.mass, "kg", "(0, inf)", "as measured, in place of the density");
v.vector("centre", c.centre, "m", "centre of mass, as measured, of the scaled clump; left out: of the spheres' union");
v.vector("inertia", c.inertia, "kg m^2",
         "as measured, beside `mass`: moments xx yy zz about the centre of mass, of the scaled clump; left out: of "
         "the union");
v.vector("products", c.products, "kg m^2",
         "beside `inertia`: elements xy yz zx of its matrix, minus the integral of x y dm; left out: 0");
}  // namespace subsoil::sim

void describe(Fields& v, ClumpShare& c) {
  v.text("shape", c.shape, "name of one of `soil.clumps`");
  v.quantity("share", c.share, "1", "(0, 1]", "of the number of grains; what all leave of 1 are spheres of `radius`");
}

void describe(Fields& v, PlacedClump& c) {
  v.text("shape", c.shape, "name of one of `soil.clumps`");
  v.vector("position", c.position, "m", "of its centre of mass");
  v.section("rotation", c.rotation, "turns it from the axes in which its spheres are given");
  v.vector("velocity", c.velocity, "m/s", "of the centre of mass at the start");
  v.vector("angular velocity", c.spin, "rad/s", "at the start, world axes");
  v.optional_reference("material", c.material, Family::material, "of its surface; left out: the bed's");
}

bool uses_clump(const Scenario& s, const std::string& shape) {
  const auto named = [&](const auto& one) { return one.shape == shape; };
  const auto any = [&](const auto& list) { return std::any_of(list.begin(), list.end(), named); };
  const auto& bed = s.soil->bed;
  if (bed && (bed->fill == Fill::file || any(bed->clumps) || any(bed->placed) ||
              std::any_of(bed->layers.begin(), bed->layers.end(), [&](const Layer& l) { return any(l.clumps); })))
    return true;
  return std::any_of(s.soil->inlets.begin(), s.soil->inlets.end(),
                     [&](const InletSection& i) { return any(clumps_of(i, bed)); });
}

bool only_clumps(const std::vector<ClumpShare>& shares) {
  double sum = 0;
  for (const ClumpShare& c : shares) sum += c.share;
  return !shares.empty() && sum > 1 - 1e-9;
}

namespace {

struct ClumpChecks : Checks {
  const Scenario& s;

  void clumps() {
    const Soil& soil = *s.soil;
    for (const ClumpSection& c : soil.clumps) shape(c);
    const bool lie = soil.bed && (!soil.bed->placed.empty() || any_clumps(*soil.bed));
    const bool poured =
        std::any_of(soil.inlets.begin(), soil.inlets.end(), [](const InletSection& i) { return !i.clumps.empty(); });
    const bool read = soil.bed && soil.bed->fill == Fill::file;  // a saved bed may have them
    if (!soil.clumps.empty() && !lie && !poured && !read)
      refuse(
          "soil.clumps",
          "are used nowhere; name them in `soil.bed.clumps`, `clumps` of a layer or an inlet, or `soil.bed.placed`, or "
          "leave them out");
    if (!lie && !poured) return;
    for (const InletSection& i : soil.inlets) shares("soil.inlets." + i.name + ".clumps", i.clumps);
    if (!lie) return;
    bed(*soil.bed);
  }

  void shape(const ClumpSection& c) {
    const std::string path = "soil.clumps." + c.name;
    if (c.spheres.empty() && !places.contains(path + ".import"))  // whose file is refused where it is read
      refuse(path + ".spheres", "is empty: a clump needs one sphere at least, here or by `import`");
    if (c.mass && c.density) refuse(path + ".density", "stands beside `mass`; keep one of them");
    if (!c.mass && (c.centre || c.inertia))
      refuse(path + (c.centre ? ".centre" : ".inertia"), "needs `mass`, as measured; leave it out for the union's");
    if (c.products && !c.inertia) refuse(path + ".products", "needs `inertia`, whose matrix they belong to");
  }

  void shares(const std::string& path, const std::vector<ClumpShare>& clumps) {
    double sum = 0;
    for (std::size_t i = 0; i < clumps.size(); ++i) {
      named(fmt::format("{}[{}].shape", path, i), clumps[i].shape);
      sum += clumps[i].share;
    }
    if (sum > 1 + 1e-9) refuse(path, fmt::format("have shares of {:.6g} together; at most 1", sum));
  }

  void bed(const BedSection& b) {
    const bool mixed = b.fill == Fill::random || b.fill == Fill::lattice;
    shares("soil.bed.clumps", b.clumps);
    if (!b.clumps.empty() && !mixed)
      refuse("soil.bed.clumps", "need `fill: random` or `lattice`; with `fill: particles` list them as `placed`");
    if (!b.clumps.empty() && !b.layers.empty())
      refuse("soil.bed.clumps", "stand beside `layers`; name them in `clumps` of each layer that has them");
    for (std::size_t i = 0; i < b.layers.size(); ++i) {
      const std::string path = fmt::format("soil.bed.layers[{}].clumps", i);
      shares(path, b.layers[i].clumps);
      if (!b.layers[i].clumps.empty() && b.fill != Fill::random) refuse(path, "need `fill: random`");
    }
    if (!b.placed.empty() && b.fill != Fill::particles)
      refuse("soil.bed.placed", "needs `fill: particles`; shares of a filled bed are `clumps`");
    if (!b.placed.empty() && !b.layers.empty())
      refuse("soil.bed.placed", "stands beside `layers`, which are of spheres; leave one of them out");
    for (std::size_t i = 0; i < b.placed.size(); ++i) {
      const PlacedClump& c = b.placed[i];
      const std::string path = fmt::format("soil.bed.placed[{}]", i);
      named(path + ".shape", c.shape);
      material(path + ".material", c.material);
      direction(path + ".rotation.axis", c.rotation.axis);
    }
    if (!b.save.empty() && std::filesystem::path(b.save).extension() == ".csv")
      refuse("soil.bed.save", b.save, "a table has spheres one by one, and this bed has clumps; name an .h5 file");
  }

  void named(const std::string& path, const std::string& name) {
    if (name.empty())
      refuse(path, "is missing: the name of one of `soil.clumps`");
    else
      refer(path, name, names_of(s.soil->clumps), "clump");
  }
};

}  // namespace

void check_clumps(Checks& checks, const Scenario& s) { ClumpChecks{checks, s}.clumps(); }

}  // namespace subsoil::sim
