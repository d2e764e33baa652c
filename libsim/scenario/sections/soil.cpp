#include "libsim/scenario/sections/soil.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "libsim/keys/json_forms.hpp"
#include "libsim/keys/nodes.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/gravity.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

namespace {

/// Some of a few things by name: faces of the container, directions.
template <std::size_t N>
class SomeOf final : public Value {
 public:
  SomeOf(std::array<bool, N>& chosen, const std::array<const char*, N>& names, const char* what)
      : chosen_(chosen), names_(names), what_(what) {}
  void read(const Node& node, const ReadScope&) override {
    chosen_ = {};
    for (const Node* item : items_of(node)) {
      const auto found = std::find(names_.begin(), names_.end(), scalar_of(*item));
      if (found == names_.end()) throw Refusal(fmt::format("{} are {}", what_, fmt::join(names_, ", ")));
      chosen_[static_cast<std::size_t>(found - names_.begin())] = true;
    }
  }
  Node print(const PrintScope&) const override {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < N; ++i)
      if (chosen_[i]) names.emplace_back(names_[i]);
    return sequence(names);
  }
  std::string what() const override { return std::string("list of ") + what_; }
  Json schema() const override {
    const Json one = words_form({names_.begin(), names_.end()});
    return either({one, list_form(one)});
  }
  std::string range() const override { return fmt::format("{}", fmt::join(names_, " | ")); }

 private:
  std::array<bool, N>& chosen_;
  const std::array<const char*, N>& names_;
  const char* what_;
};

}  // namespace

bool has_wall(const Container& c, std::size_t face) { return !c.open[face] && !c.periodic[face / 2]; }
bool keeps_wall(const Container& c, std::size_t face) { return has_wall(c, face) && !c.open_after_settling[face]; }

std::string wall_name(std::size_t face) { return face == 2 ? "floor" : std::string("wall ") + face_names[face]; }

std::vector<std::string> wall_names(const Container& c) {
  std::vector<std::string> names;
  for (std::size_t face = 0; face < face_names.size(); ++face)
    if (has_wall(c, face)) names.push_back(wall_name(face));
  return names;
}

void describe(Fields& v, Container& c) {
  SomeOf open(c.open, face_names, "faces"), open_after_settling(c.open_after_settling, face_names, "faces");
  SomeOf periodic(c.periodic, axis_names, "directions");
  v.vector("size", c.size, "m", "inner lengths x y z (y is up)");
  v.vector("at", c.at, "m", "its corner of least coordinates");
  v.visit_value({"open", "faces without a wall"}, open);
  v.visit_value({"open after settling", "walls that stand while the bed settles and are then taken away"},
                open_after_settling);
  v.visit_value({"periodic",
                 "directions without walls: spheres that leave on one side come in on the other, and meet those there; "
                 "surfaces must keep away from these sides, or reach beyond both"},
                periodic);
  v.reference("material", c.material, Family::material, "of the walls");
}

dem::PeriodicCell periodic_cell(const Container& c, double up) {
  dem::PeriodicCell cell{.low = c.at + Vec3{0, up, 0}, .length = {}};
  for (int d = 0; d < 3; ++d)
    if (c.periodic[static_cast<std::size_t>(d)]) cell.length[d] = c.size[d];
  return cell;
}

void describe(Fields& v, Active& a) {
  v.quantity("within", a.within, "m", "[0, inf)", "nothing is frozen this near to the box around a moving surface");
  v.quantity("below", a.below, "m/s", "(0, inf)",
             "what stays slower than this, with all that is around it, falls asleep until something beside it moves "
             "faster or its forces change; left out: 0.002 of the root of gravity times the mean diameter");
}

void describe(Fields& v, MovingWindow& m) {
  v.text("follows", m.follows, "the boundary or body whose way the window goes with");
  v.quantity("block", m.block, "m", "(0, inf)",
             "length along x of what comes in ahead at a time; the container is a whole number of blocks long");
  v.quantity(
      "period", m.period, "m", "(0, inf)",
      "length along x of the bed that is made: periodic there and repeated, so that the tool meets the same packing "
      "again after this way; left out: a block");
  v.choice("towards", m.towards, {{"+x", Towards::plus_x}, {"-x", Towards::minus_x}}, "where the window goes");
}

void describe(Fields& v, Soil& s) {
  v.section("container", s.container, "box of flat walls that act on spheres only");
  v.quantity("surface", s.surface, "m", "(-inf, inf)",
             "height y of the mean surface after settling: bed and container are shifted to it; left out: no shift");
  v.named("clumps", s.clumps,
          "rigid grains made of spheres (multi-spheres), by name; `soil.bed.clumps`, `soil.bed.placed` and "
          "`soil.inlets` use "
          "them");
  v.section("bed", s.bed, "the spheres");
  v.named("inlets", s.inlets, "spheres and clumps that are poured in during the run, by name");
  v.section("active", s.active,
            "spheres that rest far from every moving surface are frozen and skipped until something beside them moves; "
            "left out: all move");
  v.section("moving", s.moving,
            "a long pass in a short container, which goes on with a tool: settled soil comes in ahead, block by block, "
            "and what lies behind is left; left out: the container stands");
  v.quantity("remove below", s.removal_below, "m", "(0, inf)",
             "spheres this far below the container's floor are taken out and counted");
}

namespace {

struct SoilChecks : Checks {
  const Scenario& s;

  void active(const Active& a) {
    if (!a.below && s.gravity == Vec3{})
      refuse("soil.active.below", "is missing: without gravity there is no speed to derive it from; give it");
  }

  void container(const Container& c) {
    positive("soil.container.size", c.size);
    material("soil.container.material", c.material);
    for (std::size_t i = 0; i < 6; ++i) {
      if (c.open[i] && c.open_after_settling[i]) {
        refuse("soil.container.open after settling",
               fmt::format("the face {} is open from the start; take it out of one of the lists", face_names[i]));
      }
    }
  }

  /// A bed that settles stands on what the container has: bodies and boundaries come to it afterwards.
  void floor(const Container& c, const BedSection& b) {
    const bool held = b.rough_floor || std::any_of(b.particles.begin(), b.particles.end(),
                                                   [](const auto& particle) { return !particle.fixed.empty(); });
    if (!c.open[2] || held || !acts_down(s.gravity) || !b.settles()) return;
    refuse("soil.container.open",
           "the face -y is open while the bed settles, and nothing holds it: bodies and boundaries come to it "
           "afterwards; write `open after settling: [-y]`");
  }

  /// Sides that are one and the same have no walls, and up there is none where the bed begins anew from below.
  void periodic(const Container& c) {
    for (std::size_t f = 0; f < 6; ++f) {
      const bool up = f == 3;  // without a wall unless told otherwise
      if (!c.periodic[f / 2]) continue;
      if (c.open[f] && !up)
        refuse("soil.container.open",
               fmt::format("the face {} is periodic and has no wall; leave it out", face_names[f]));
      if (c.open_after_settling[f])
        refuse("soil.container.open after settling",
               fmt::format("the face {} is periodic and has no wall; leave it out", face_names[f]));
    }
    if (!c.periodic[1]) return;
    const char* const without = "the bed has no floor and no surface with `periodic: [y]`; leave it out, or y";
    if (s.soil->surface) refuse("soil.surface", without);
    if (s.soil->bed && s.soil->bed->settles())
      refuse(s.soil->bed->settle ? "soil.bed.settle" : "soil.bed.fill", without);
    if (s.soil->bed && !s.soil->bed->layers.empty()) refuse("soil.bed.layers", without);
  }

  void moving(const MovingWindow& m) {
    if (!s.soil->container || !s.soil->bed)
      return refuse("soil.moving", "needs a container, which is the window that moves, and a bed");
    const Container& c = *s.soil->container;
    const BedSection& b = *s.soil->bed;
    const auto without = [&](bool given, const char* path, const char* why) {
      if (given) refuse(path, fmt::format("stands beside `soil.moving`{}; leave one of them out", why));
    };
    without(c.periodic[0], "soil.container.periodic", ", whose window has ends in x");
    without(c.periodic[1], "soil.container.periodic", ", whose window stands on a floor");
    for (const std::size_t f : {0u, 1u}) {
      without(c.open[f], "soil.container.open", ", which holds the soil at the window's ends");
      without(c.open_after_settling[f], "soil.container.open after settling",
              ", which holds the soil at the window's ends");
    }
    without(s.soil->active.has_value(), "soil.active", "");
    without(b.region.has_value(), "soil.bed.region", ", whose bed fills one period");
    without(b.rough_floor.has_value(), "soil.bed.rough floor", "");
    for (std::size_t i = 0; i < b.particles.size(); ++i)
      without(!b.particles[i].fixed.empty(), fmt::format("soil.bed.particles[{}].fixed", i).c_str(), "");
    if (!b.settle && b.fill != Fill::random && b.fill != Fill::rest_lattice)
      refuse("soil.bed.settle",
             "is missing: blocks of `soil.moving` come in at rest, with the springs of their contacts, which neither a "
             "loose bed nor a file has; give `settle: {until: ...}`");
    const double count = c.size.x / m.block;
    if (m.block > 0 && std::abs(count - std::round(count)) > 1e-6 * count)
      refuse("soil.moving.block", fmt::format("{:.6g} m", m.block),
             fmt::format("must fit into the container's {:.6g} m a whole number of times; {:.6g} m does", c.size.x,
                         c.size.x / std::max(1.0, std::round(count))));
    followed(m);
  }

  void followed(const MovingWindow& m) {
    Names known;
    for (const BoundarySection& b : s.boundaries) {
      if (b.is_moved()) known.push_back(b.name);
      const bool endless = std::holds_alternative<PlaneShape>(b.shape);
      if (!b.is_moved() && !endless)
        refuse("soil.moving",
               fmt::format(
                   "the boundary `{}` stands still while the bed advances over its place; move it with the tool, or "
                   "leave it out",
                   b.name));
    }
    if (s.machine)
      for (const std::string& name : names_of(s.machine->bodies)) known.push_back(name);
    if (m.follows.empty())
      refuse("soil.moving.follows", "is missing: the boundary or body whose way the window goes with");
    else
      refer("soil.moving.follows", m.follows, known, "moved boundary or body");
  }

  void soil() {
    if (s.soil->moving) moving(*s.soil->moving);
    if (s.soil->active) active(*s.soil->active);
    if (s.soil->container) container(*s.soil->container), periodic(*s.soil->container);
    if (s.soil->container && s.soil->bed) floor(*s.soil->container, *s.soil->bed);
    if (s.soil->bed) check_bed(*this, s);
    check_inlets(*this, s);
    check_fibres(*this, s);
    check_clumps(*this, s);
    if (s.soil->surface && !(s.soil->bed && s.soil->container)) {
      refuse("soil.surface", "needs a container and a bed, which are shifted so that the bed's surface is there");
    }
  }
};

}  // namespace

void check_soil(Checks& checks, const Scenario& s) { SoilChecks{checks, s}.soil(); }

}  // namespace subsoil::sim
