#include "apps/scenario/sections/soil.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "apps/scenario/checks.hpp"
#include "apps/scenario/fields/json_forms.hpp"
#include "apps/scenario/fields/nodes.hpp"
#include "apps/scenario/scenario.hpp"

namespace subsoil::app {

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

std::string wall_name(std::size_t face) { return face == 2 ? "floor" : std::string("wall ") + face_names[face]; }

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
             "what stays slower than this, with all that is around it, is frozen until something beside it moves "
             "faster or its forces would make it");
}

void describe(Fields& v, Soil& s) {
  v.section("container", s.container, "box of flat walls that act on spheres only");
  v.quantity("surface", s.surface, "m", "(-inf, inf)",
             "height y of the mean surface after settling: bed and container are shifted to it; left out: no shift");
  v.named(
      "clumps", s.clumps,
      "rigid grains made of spheres (multi-spheres), by name; `soil.bed.clumps` and `soil.bed.placed` say where they "
      "are");
  v.section("bed", s.bed, "the spheres");
  v.section("active", s.active,
            "spheres that rest far from every moving surface are frozen and skipped until something beside them moves; "
            "left out: all move");
  v.quantity("remove below", s.removal_below, "m", "(0, inf)",
             "spheres this far below the container's floor are taken out and counted");
}

namespace {

struct SoilChecks : Checks {
  const Scenario& s;

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
    const bool any = c.periodic[0] || c.periodic[1] || c.periodic[2];
    if (any && s.soil->bed && (!s.soil->bed->clumps.empty() || !s.soil->bed->placed.empty()))
      refuse("soil.container.periodic",
             "clumps have no images beyond periodic sides; use spheres, or give the bed walls");
    if (!c.periodic[1]) return;
    const char* const without = "the bed has no floor and no surface with `periodic: [y]`; leave it out, or y";
    if (s.soil->surface) refuse("soil.surface", without);
    if (s.soil->bed && (s.soil->bed->settle || s.soil->bed->fill == Fill::random))
      refuse(s.soil->bed->settle ? "soil.bed.settle" : "soil.bed.fill", without);
    if (s.soil->bed && !s.soil->bed->layers.empty()) refuse("soil.bed.layers", without);
  }

  void soil() {
    if (s.soil->container) container(*s.soil->container), periodic(*s.soil->container);
    if (s.soil->bed) check_bed(*this, s);
    check_clumps(*this, s);
    if (s.soil->surface && !(s.soil->bed && s.soil->container)) {
      refuse("soil.surface", "needs a container and a bed, which are shifted so that the bed's surface is there");
    }
  }
};

}  // namespace

void check_soil(Checks& checks, const Scenario& s) { SoilChecks{checks, s}.soil(); }

}  // namespace subsoil::app
