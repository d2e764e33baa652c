#include "libsim/scenario/sections/inlets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/keys/either_quantity.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

void describe(Fields& v, InletDisk& d) {
  v.vector("at", d.at, "m", "its centre");
  v.vector("normal", d.normal, "1", "of its plane");
  v.quantity("radius", d.radius, "m", "(0, inf)", "of the disk; spheres lie within it");
}

void describe(Fields& v, InletSection& i) {
  EitherQuantity rate("kg/s", i.mass_rate, "1/s", i.number_rate,
                      "a mass (2 kg/s) or a number of grains (500 1/s) per time");
  v.section("box", i.box, "box in which the grains come");
  v.section("disk", i.disk, "in place of the box: disk in which their centres come");
  v.visit_value({"rate", "mass or number of grains per time", true}, rate);
  v.optional_reference("material", i.material, Family::material, "of the grains; left out: the bed's");
  v.optional_form("radius", i.radius, "radius of the spheres, or a distribution; left out: the bed's");
  v.list("clumps", i.clumps,
         "how many of the grains are clumps, each in an attitude of its own by the seed; left out with `radius`: the "
         "bed's");
  v.choice("shares", i.shares, {{"number", ShareOf::number}, {"mass", ShareOf::mass}},
           "what the distribution of radii counts");
  v.quantity("from", i.from, "s", "[0, inf)", "time at which it opens");
  v.quantity("until", i.until, "s", "(0, inf]", "time at which it closes");
  v.vector("velocity", i.velocity, "m/s", "of the grains when they come");
  v.count("seed", i.seed, "[0, inf)", "of the random numbers: sizes, attitudes and places");
}

bool has_own_radius(const InletSection& inlet) {
  const auto* equal = std::get_if<EqualRadius>(&inlet.radius);
  return equal == nullptr || !std::isnan(equal->radius);
}

std::string material_of(const InletSection& inlet, const std::optional<BedSection>& bed) {
  return inlet.material.empty() && bed ? bed->material : inlet.material;
}

const std::vector<ClumpShare>& clumps_of(const InletSection& inlet, const std::optional<BedSection>& bed) {
  return inlet.clumps.empty() && !has_own_radius(inlet) && bed ? bed->clumps : inlet.clumps;
}

namespace {

struct InletChecks : Checks {
  const Scenario& s;

  void inlets() {
    if (s.soil->inlets.empty()) return;
    for (const InletSection& i : s.soil->inlets) inlet("soil.inlets." + i.name, i);
    const auto without = [&](bool given, const char* path, const char* why) {
      if (given) refuse("soil.inlets", fmt::format("stands beside `{}`, {}; leave one of them out", path, why));
    };
    without(s.soil->moving.has_value(), "soil.moving", "whose spheres are numbered by their place in the period");
    without(s.soil->active.has_value(), "soil.active", "which spares soil that rests, and poured soil falls on it");
  }

 private:
  void inlet(const std::string& path, const InletSection& i) {
    if (i.box.has_value() == i.disk.has_value())
      refuse(path, i.box ? "has `box` and `disk`; keep one of them" : "needs `box` or `disk`, in which grains come");
    if (i.box) positive(path + ".box.size", i.box->size);
    if (i.disk) direction(path + ".disk.normal", i.disk->normal);
    if (!(i.from < i.until)) refuse(path + ".until", "must be later than `from`");
    if (i.from >= s.time.end && s.time.end > 0)
      refuse(
          path + ".from", fmt::format("{:.6g} s", i.from),
          fmt::format("is not before the end of the run, {:.6g} s; let it open earlier, or leave it out", s.time.end));
    const std::string of = material_of(i, s.soil->bed);
    if (of.empty())
      refuse(path + ".material", "is missing: there is no bed of one material; name that of the grains");
    else
      material(path + ".material", of);
    const bool spheres = !only_clumps(clumps_of(i, s.soil->bed));
    if (!spheres && has_own_radius(i))
      refuse(path + ".radius", "has no effect: all grains are clumps; leave it out, or lower their shares");
    else if (!spheres)
      return;  // whose reach the inlet itself compares with its region
    else if (has_own_radius(i))
      size(path, i, i.radius);
    else if (!s.soil->bed || s.soil->bed->fill > Fill::random || only_clumps(s.soil->bed->clumps) ||
             !s.soil->bed->layers.empty())
      refuse(path + ".radius", "is missing: there is no bed of one radius or distribution; give that of the spheres");
    else
      size(path, i, s.soil->bed->radius);
  }

  void size(const std::string& path, const InletSection& i, const RadiusDistribution& radius) {
    if (has_own_radius(i)) check_distribution(*this, path + ".radius", radius);
    const double diameter = 2 * largest_radius(radius);
    const auto refuse_narrow = [&](const std::string& key, double length) {
      if (length < diameter * (1 - 1e-9))
        refuse(key, fmt::format("is {:.6g} mm wide, less than the diameter {:.6g} mm of its largest sphere; make it "
                                "larger, or its spheres smaller",
                                length * 1e3, diameter * 1e3));
    };
    if (i.box) refuse_narrow(path + ".box.size", std::min({i.box->size.x, i.box->size.y, i.box->size.z}));
    if (i.disk) refuse_narrow(path + ".disk.radius", 2 * i.disk->radius);
  }
};

}  // namespace

void check_inlets(Checks& checks, const Scenario& s) { InletChecks{checks, s}.inlets(); }

}  // namespace subsoil::sim
