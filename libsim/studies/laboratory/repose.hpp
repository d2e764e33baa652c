#pragma once
#include <optional>

#include "libsim/studies/laboratory/findings.hpp"
#include "libsim/studies/laboratory/specimen.hpp"

namespace subsoil::sim {

/// Angle of repose.
///     ledge: a layer between smooth sides; its front gate is lifted, what lies above the slope runs off over the edge
///     heap:  a square column; its four walls are lifted, a heap stays on the tray
///     drum:  a cylinder turns slowly about its lying axis; the slope of the moving surface, mean over time
/// The tray's edge holds the lowest layer of grains, so that the slope stands on grains and not on the floor.
/// Slope: the base is divided into cells of 1.5 diameters; the top of a cell is that of its highest grain; a line
/// through the tops, distance from the edge against height, by Theil and Sen. Distance is that from the nearest side:
/// what stays on a table at one slope is as high as tan(angle) times it (Hadeler & Kuttler, Granular Matter 2, 1999,
/// 9), on a square one a pyramid; a cone fitted to it mixes faces with ridges. Of ledge and heap the flank counts,
/// where the mean top at equal distance goes from 0.15 to 0.8 of the height between the tray's edge and the crest; of a
/// drum what is within half a radius of the axis. A gate that is
/// lifted fast releases a single avalanche, which stops anywhere between the angles of rest and of start; behind a slow
/// one the slope fails bit by bit.
struct Repose {
  enum class Form { ledge, heap, drum };
  Form form = Form::ledge;
  std::optional<double> length, width, depth, lift;  // ledge, heap
  std::optional<double> radius, speed;               // drum
  double share = 0.4, lead = 0.35, turns = 0.25;

  template <class V>
  void describe(V& v) {
    v.choice(
        "form", form, {{"ledge", Form::ledge}, {"heap", Form::heap}, {"drum", Form::drum}},
        "ledge: a layer slides off over an edge; heap: a column without its walls; drum: the slope in a turning drum");
    v.quantity("length", length, "m", "(0, inf)",
               "of the base; left out: 18 diameters for a ledge, 20 for a heap, which is square");
    v.quantity("width", width, "m", "(0, inf)", "across, of a ledge and a drum; left out: 6 diameters");
    v.quantity("depth", depth, "m", "(0, inf)",
               "filled at the start; left out: 0.75 lengths for a ledge, 0.5 for a heap");
    v.quantity("lift", lift, "m/s", "(0, inf)", "speed of gate and walls; left out: sqrt(g d)/4");
    v.quantity("radius", radius, "m", "(0, inf)", "of the drum; left out: 8 diameters");
    v.quantity("speed", speed, "rad/s", "(0, inf)",
               "of the drum; left out: sqrt(0.002 g/radius), so slow that it rolls");
    v.quantity("share", share, "1", "(0, 0.6]", "of the drum that grains fill, their voids with them");
    v.quantity("lead", lead, "1", "[0, inf)", "turns of the drum before the slope counts");
    v.quantity("turns", turns, "1", "(0, inf)", "turns over which it counts");
  }

  static std::vector<Number> numbers() { return {{"angle", "rad", {}}}; }
  std::size_t specimens(std::size_t packings) const { return packings; }
  Outcome run(const Sample& sample, std::size_t packing) const;
  Findings findings(const Sample& sample, std::size_t packings, const std::vector<Outcome>& outcomes) const;
};

/// Tops of cells: distance along the slope against height, m.
struct Tops {
  std::vector<double> s, height;
};

/// A rectangular tray with its minimum corner at the origin, over whose sides grains run off: over all (heap) or over
/// that at x = length (ledge). `edge` is the height of its rim; m.
struct Tray {
  double length, width, edge;
  bool heap;
};
/// Slope of what lies on a tray, rad, as value; tops, line and what counts as curve. Throws std::runtime_error when too
/// few places make a slope.
Outcome slope_on(const Tray& tray, std::span<const dem::Sphere> spheres, double diameter);

/// Robust slope through the tops with s in [from, to], rad.
double slope_of(const Tops& tops, double from, double to, Line* line = nullptr);

}  // namespace subsoil::sim
