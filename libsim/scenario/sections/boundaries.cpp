#include "libsim/scenario/sections/boundaries.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

void describe(Fields& v, Move& m) {
  v.vector("velocity", m.velocity, "m/s", "of the boundary's place");
  v.vector("angular velocity", m.spin, "rad/s", "angular velocity, world axes");
  v.vector("about", m.about, "m",
           "point of the spin at the start; the velocities of all stretches carry it along; left out: the boundary's "
           "place");
  v.function("profile", m.profile, "1", "factor on velocity and spin over time");
  v.quantity("from", m.from, "s", "[0, inf)", "time at which this motion begins");
  v.quantity("until", m.until, "s", "(0, inf]", "time at which it ends");
}

void describe(Fields& v, BoundarySection& b) {
  v.name("name", b.name, "appears in the results");
  v.reference("material", b.material, Family::material, "of the surface");
  v.form("shape", b.shape, "its shape");
  v.vector("at", b.at, "m", "its place: origin of the shape");
  v.section("rotation", b.rotation, "turns the shape about its place, by `axis` and `angle` or by `turns`");
  v.list("moves", b.moves, "given motion; velocities and spins of several stretches add up; left out: fixed");
  v.section("servo", b.servo,
            "presses it onto the spheres until they resist with a load; beside `moves`, of which it shifts the path");
  v.quantity("cutting edges", b.cutting, "rad", "(0, 3.1]",
             "edges at which the surface is a wedge of this angle or less: they cut fibres with a `bond cutting "
             "strength`; left out: none");
  v.vector("reference", b.reference, "m", "point of the reported moment, moves along; left out: its place");
  v.section("wear", b.wear, "keeps pressure, work and wear on each triangle, in frames and in the summary");
}

namespace {

struct BoundaryChecks : Checks {
  const Scenario& s;

  void boundaries() {
    Names names;
    for (std::size_t i = 0; i < s.boundaries.size(); ++i) {
      const BoundarySection& b = s.boundaries[i];
      const std::string path = fmt::format("boundaries[{}]", i);
      if (!b.name.empty() && holds(names, b.name)) refuse(path + ".name", b.name, "stands twice; names must differ");
      names.push_back(b.name);
      material(path + ".material", b.material);
      check_shape(*this, path + ".shape", b.shape);
      direction(path + ".rotation.axis", b.rotation.axis);
      if (b.servo) check_servo(*this, path + ".servo", *b.servo);
      wear(path, b);
      for (std::size_t k = 0; k < b.moves.size(); ++k) {
        if (b.moves[k].from >= b.moves[k].until) {
          refuse(fmt::format("{}.moves[{}].until", path, k), "must be later than `from`");
        }
        for (std::size_t before = 0; before < k; ++before)
          spins_together(fmt::format("{}.moves[{}]", path, k), b.moves[k], b.moves[before], before);
      }
    }
  }

  /// A sum of spins about different axes or points is no rotation in closed form.
  void spins_together(const std::string& path, const Move& m, const Move& other, std::size_t index) {
    const double product = dem::norm(m.spin) * dem::norm(other.spin);
    if (product == 0 || std::max(m.from, other.from) >= std::min(m.until, other.until)) return;
    if (dem::norm(cross(m.spin, other.spin)) > 1e-9 * product)
      refuse(path + ".angular velocity",
             fmt::format("acts together with that of moves[{}] about another axis; spins at one time must "
                         "be parallel: let one end before the other begins",
                         index));
    else if (m.about && other.about && *m.about != *other.about)
      refuse(path + ".about",
             fmt::format("acts together with that of moves[{}] about another point; let one end before "
                         "the other begins, or leave one `about` out",
                         index));
  }

  void wear(const std::string& path, const BoundarySection& b) {
    check_wear(*this, path + ".wear", b.wear);
    const bool bounded = std::visit([]<class S>(const S&) { return S::bounded; }, b.shape);
    if (b.wear && !bounded) refuse(path + ".wear", "needs triangles; a plane has none: make the surface a box");
  }
};

}  // namespace

void check_boundaries(Checks& checks, const Scenario& s) { BoundaryChecks{checks, s}.boundaries(); }

}  // namespace subsoil::sim
