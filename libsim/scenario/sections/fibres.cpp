#include "libsim/scenario/sections/fibres.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "libdem/geometry/cutting_edges.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/gravity.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

void describe(Fields& v, FibreSection& f) {
  v.reference(
      "material", f.material, Family::material,
      "of the fibre's matter; its contact with itself has `bond: fibre`, which says how the fibre bends, yields "
      "and breaks");
  v.quantity("length", f.length, "m", "(0, inf)", "of a fibre: a whole number of diameters, the nearest one");
  v.quantity("diameter", f.diameter, "m", "(0, inf)", "of a fibre, and of the spheres in its row");
  v.count("count", f.count, "[1, 10000000]", "number of fibres");
  v.quantity("mass per area", f.mass_per_area, "kg/m^2", "(0, inf)",
             "in place of the count: mass of all fibres over the plan of `region`, or of the container");
  v.choice("orientation", f.orientation,
           {{"random", FibreOrientation::random},
            {"horizontal", FibreOrientation::horizontal},
            {"x", FibreOrientation::x},
            {"y", FibreOrientation::y},
            {"z", FibreOrientation::z}},
           "how fibres are laid: in any direction; in any horizontal one; along an axis");
  v.quantity("scatter", f.scatter, "rad", "[0, 1.5)",
             "of fibres along an axis: standard deviation of their angle to it, about either direction across");
  v.section("region", f.region,
            "box in which fibres begin; spheres of the bed that they meet there are left out; left out: above the bed, "
            "over the container's plan, as high as they pile up");
  v.count("seed", f.seed, "[0, inf)", "of places and directions; left out: the bed's");
}

namespace {

const Material* material_named(const Scenario& s, const std::string& name) {
  const auto at =
      std::find_if(s.materials.begin(), s.materials.end(), [&](const Material& m) { return m.name == name; });
  return at == s.materials.end() ? nullptr : &*at;
}

/// Of the plan of where fibres begin, m^2; of a moving bed in one of its periods.
double plan_area(const FibreSection& f, const Scenario& s) {
  const Soil& soil = *s.soil;
  if (f.region) return f.region->size.x * f.region->size.z;
  if (!soil.container) return 0;
  const dem::Vec3& size = soil.container->size;
  return (soil.moving ? soil.moving->period.value_or(soil.moving->block) : size.x) * size.z;
}

}  // namespace

int spheres_of(const FibreSection& f) { return std::max(1, static_cast<int>(std::lround(f.length / f.diameter))); }

double mass_of(const FibreSection& f, double density) {
  return density * std::numbers::pi / 4 * f.diameter * f.diameter * spheres_of(f) * f.diameter;
}

std::size_t count_of(const FibreSection& f, const Scenario& s) {
  if (f.count) return static_cast<std::size_t>(*f.count);
  const Material* material = material_named(s, f.material);
  if (!f.mass_per_area || material == nullptr) return 0;
  return static_cast<std::size_t>(std::lround(*f.mass_per_area * plan_area(f, s) / mass_of(f, material->density)));
}

std::size_t fibre_spheres(const Scenario& s) {
  std::size_t sum = 0;
  if (s.soil && s.soil->bed)
    for (const FibreSection& f : s.soil->bed->fibres) sum += count_of(f, s) * static_cast<std::size_t>(spheres_of(f));
  return sum;
}

namespace {

struct FibreChecks : Checks {
  const Scenario& s;

  void fibres() {
    bonds();
    if (!s.soil->bed || s.soil->bed->fibres.empty()) return;
    const BedSection& bed = *s.soil->bed;
    for (const FibreSection& f : bed.fibres) fibre("soil.bed.fibres." + f.name, f);
    const auto without = [&](bool given, const char* path, const char* why) {
      if (given) refuse(path, fmt::format("stands beside `soil.bed.fibres`, {}; leave one of them out", why));
    };
    without(!bed.save.empty(), "soil.bed.save", "whose bonds the file of a bed does not keep");
  }

 private:
  /// The entry of a material with itself that makes fibres; null: there is none.
  const Contact* own_contact(const std::string& name) const {
    const auto at = std::find_if(s.contacts.begin(), s.contacts.end(),
                                 [&](const Contact& c) { return c.between[0] == name && c.between[1] == name; });
    return at == s.contacts.end() ? nullptr : &*at;
  }

  /// `bond: fibre` acts between the spheres of fibres only.
  void bonds() {
    for (std::size_t i = 0; i < s.contacts.size(); ++i) {
      const Contact& c = s.contacts[i];
      if (!makes_fibres(c.law) || !places.contains("soil")) continue;  // a laboratory test has a bed of its own
      const auto is_own = [&](const FibreSection& f) { return f.material == c.between[0]; };
      const bool used = s.soil->bed && c.between[0] == c.between[1] &&
                        std::any_of(s.soil->bed->fibres.begin(), s.soil->bed->fibres.end(), is_own);
      if (!used)
        refuse(
            fmt::format("contacts[{}].bond", i), "fibre",
            fmt::format("joins the spheres of a fibre, of one material, and no `soil.bed.fibres` is of {}; give one, "
                        "or leave the bond out",
                        c.between[0] == c.between[1] ? c.between[0] : c.between[0] + " and " + c.between[1]));
    }
  }

  void fibre(const std::string& path, const FibreSection& f) {
    material(path + ".material", f.material);
    const Contact* own = own_contact(f.material);
    if (holds(materials, f.material) && (own == nullptr || !makes_fibres(own->law)))
      refuse(path + ".material", f.material,
             fmt::format("has no `bond: fibre` in its contact with itself, which holds a fibre together; give "
                         "`{{between: [{0}, {0}], ..., bond: fibre, bond modulus: ..., bond tensile strength: ..., "
                         "bond shear strength: ...}}`",
                         f.material));
    if (f.count.has_value() == f.mass_per_area.has_value())
      refuse(path, f.count ? "has `count` and `mass per area`; keep one of them" : "needs `count` or `mass per area`");
    if (f.length > 0 && f.diameter > 0 && spheres_of(f) < 2)
      refuse(path + ".length", fmt::format("{:.6g} mm", f.length * 1e3),
             fmt::format("is one sphere of the diameter {:.6g} mm; a fibre is two diameters long at least",
                         f.diameter * 1e3));
    const bool along = f.orientation >= FibreOrientation::x;
    if (f.scatter != 0 && !along)
      refuse(path + ".scatter", "is about an axis; give `orientation: x`, y or z, or leave it out");
    place(path, f);
    if (problems.empty()) amount(path, f);
  }

  void place(const std::string& path, const FibreSection& f) {
    if (f.region) return positive(path + ".region.size", f.region->size);
    if (!s.soil->container)
      refuse(path + ".region", "is missing: there is no container over whose plan fibres could be laid; give one");
    else if (!acts_down(s.gravity))
      refuse(path + ".region", "is missing: without gravity along -y there is no surface to lay fibres on; give one");
  }

  void amount(const std::string& path, const FibreSection& f) {
    const std::size_t count = count_of(f, s);
    if (count == 0)
      refuse(path + ".mass per area", fmt::format("{:.4g} kg/m^2", *f.mass_per_area),
             fmt::format("is less than half a fibre of {:.4g} g on {:.4g} m^2; take thinner or shorter fibres, or more "
                         "of them",
                         1e3 * mass_of(f, material_named(s, f.material)->density), plan_area(f, s)));
    constexpr double most = 1e7;
    if (const double all = static_cast<double>(count) * spheres_of(f); all > most)
      refuse(path, fmt::format("makes {:.2g} spheres, {} of each fibre; at most {:g}: are the units of length and "
                               "diameter right?",
                               all, spheres_of(f), most));
  }
};

/// Before a bed settles, which may take minutes.
struct CuttingChecks : Checks {
  const Scenario& s;

  void cutting() {
    bool any_edges = false;
    const auto surface = [&](const std::string& path, const Shape& shape, const std::optional<double>& angle,
                             bool touches_soil) {
      if (!angle) return;
      any_edges = true;
      edges(path + ".cutting edges", shape, *angle, touches_soil);
    };
    for (std::size_t i = 0; i < s.boundaries.size(); ++i)
      surface(fmt::format("boundaries[{}]", i), s.boundaries[i].shape, s.boundaries[i].cutting, true);
    if (s.machine)
      for (const Surface& one : s.machine->surfaces)
        surface("machine.surfaces." + one.name, one.shape, one.cutting, one.touches_soil);
    if (!any_edges && places.contains("soil")) strengths();  // a laboratory test has tools of its own
  }

 private:
  void edges(const std::string& path, const Shape& shape, double angle, bool touches_soil) {
    if (!touches_soil) return refuse(path, "of a surface that is drawn only cut nothing; leave one of the two out");
    if (!s.soil ||
        std::none_of(s.contacts.begin(), s.contacts.end(), [](const Contact& c) { return is_cut_by_edges(c.law); }))
      return refuse(path,
                    "cut nothing: no `bond: fibre` has a `bond cutting strength`; give one, or leave the edges "
                    "out");
    if (!problems.empty()) return;  // also of the shape
    std::visit(
        [&]<class S>(const S& given) {
          if constexpr (Triangulated<S>)
            sharp_enough(path, given, angle);
          else
            refuse(path,
                   "are those of triangles, and a plane or a cylinder has none; leave them out, or take a box, an "
                   "extruded outline or a mesh");
        },
        shape);
  }

  template <class S>
  void sharp_enough(const std::string& path, const S& shape, double angle) {
    dem::TriangleMesh mesh;
    try {
      mesh = shape.mesh();
    } catch (const std::exception&) {
      return;  // a file that cannot be read is reported where it is used
    }
    if (!dem::cutting_edges(mesh, angle).empty()) return;
    const std::vector<dem::WedgeEdge> all = dem::wedge_edges(mesh);
    const auto sharpest =
        std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.angle < b.angle; });
    constexpr double degree = std::numbers::pi / 180;
    refuse(path, fmt::format("{:.4g} deg", angle / degree),
           sharpest == all.end()
               ? std::string("the shape has no edge; leave it out")
               : fmt::format("no edge of the shape is as sharp, the sharpest has {:.4g} deg; raise the angle, or leave "
                             "it out",
                             sharpest->angle / degree));
  }

  void strengths() {
    for (std::size_t i = 0; i < s.contacts.size(); ++i)
      if (is_cut_by_edges(s.contacts[i].law))
        refuse(fmt::format("contacts[{}].bond cutting strength", i),
               "has no effect: no surface has `cutting edges`; give the tool its edges, `cutting edges: 30 deg`, or "
               "leave the strength out");
  }
};

}  // namespace

void check_cutting(Checks& checks, const Scenario& s) { CuttingChecks{checks, s}.cutting(); }

void check_fibres(Checks& checks, const Scenario& s) { FibreChecks{checks, s}.fibres(); }

}  // namespace subsoil::sim
