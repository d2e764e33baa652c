#include "apps/scenario/sections/soil.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/scenario/checks.hpp"
#include "apps/scenario/fields/json_forms.hpp"
#include "apps/scenario/fields/nodes.hpp"
#include "apps/scenario/scenario.hpp"

namespace subsoil::app {

namespace {

/// Faces of the container by name.
class FaceNames final : public Value {
 public:
  explicit FaceNames(Faces& faces) : faces_(faces) {}
  void read(const Node& node, const ReadScope&) override {
    faces_ = {};
    for (const Node* item : items_of(node)) {
      const auto found = std::find(face_names.begin(), face_names.end(), scalar_of(*item));
      if (found == face_names.end()) throw Refusal("faces are -x, +x, -y, +y, -z, +z");
      faces_[static_cast<std::size_t>(found - face_names.begin())] = true;
    }
  }
  Node print(const PrintScope&) const override {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < faces_.size(); ++i)
      if (faces_[i]) names.emplace_back(face_names[i]);
    return sequence(names);
  }
  std::string what() const override { return "list of faces"; }
  Json schema() const override {
    return [] {
      const Json face = words_form({face_names.begin(), face_names.end()});
      return either({face, list_form(face)});
    }();
  }
  std::string range() const override { return "-x | +x | -y | +y | -z | +z"; }

 private:
  Faces& faces_;
};

}  // namespace

void describe(Fields& v, Container& c) {
  FaceNames open(c.open), open_after_settling(c.open_after_settling);
  v.vector("size", c.size, "m", "inner lengths x y z (y is up)");
  v.vector("at", c.at, "m", "its corner of least coordinates");
  v.visit_value({"open", "faces without a wall"}, open);
  v.visit_value({"open after settling", "walls that stand while the bed settles and are then taken away"},
                open_after_settling);
  v.reference("material", c.material, Family::material, "of the walls");
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

  void soil() {
    if (s.soil->container) container(*s.soil->container);
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
