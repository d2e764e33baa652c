#pragma once

#include <array>
#include <numbers>
#include <string>
#include <variant>
#include <vector>

#include "libmbd/base/body.hpp"
#include "libmbd/forces/beam_element.hpp"

namespace subsoil::mbd {

/// What a section is to its beam: area A (m^2), second moment of area I (m^4) about the axis across the plane, the
/// distance of its outermost fibre (m), and the share of A that carries shear, 0 where shear does not deform it.
struct SectionValues {
  double area = 0, second_moment = 0, edge = 0, shear_share = 0;
};

// Sections. Shear: Cowper, The shear coefficient in Timoshenko's beam theory, 1966, as a share of the area; nu: the
// Poisson ratio.

/// h high in the plane, b wide across it:   A = b h,  I = b h^3/12,   shear 10 (1 + nu)/(12 + 11 nu)
struct RectangleSection {
  std::array<double, 2> size{not_given, not_given};
  static constexpr double not_given = std::numeric_limits<double>::quiet_NaN();
  template <class V>
  void describe(V& v) {
    v.card("rectangle", "a solid rectangle");
    v.vector("rectangle", size, "m", "height in the machine's plane, width across it");
  }
  SectionValues values(double poisson) const {
    const auto [h, b] = size;
    return {b * h, b * h * h * h / 12, h / 2, 10 * (1 + poisson) / (12 + 11 * poisson)};
  }
};

/// The same with a wall t thick:   shear by its two webs, 2 t h
struct HollowRectangleSection {
  std::array<double, 3> size{RectangleSection::not_given, RectangleSection::not_given, RectangleSection::not_given};
  template <class V>
  void describe(V& v) {
    v.card("hollow rectangle", "a rectangular tube");
    v.vector("hollow rectangle", size, "m", "height in the machine's plane, width across it, thickness of the wall");
  }
  SectionValues values(double) const {
    const auto [h, b, t] = size;
    const double hi = h - 2 * t, bi = b - 2 * t, area = b * h - bi * hi;
    return {area, (b * h * h * h - bi * hi * hi * hi) / 12, h / 2, 2 * t * h / area};
  }
};

/// d in diameter:   A = pi d^2/4,  I = pi d^4/64,   shear 6 (1 + nu)/(7 + 6 nu)
struct CircleSection {
  double diameter = RectangleSection::not_given;
  template <class V>
  void describe(V& v) {
    v.card("circle", "a solid round bar");
    v.quantity("circle", diameter, "m", "(0, inf)", "diameter");
  }
  SectionValues values(double poisson) const {
    const double d2 = diameter * diameter, pi = std::numbers::pi;
    return {pi * d2 / 4, pi * d2 * d2 / 64, diameter / 2, 6 * (1 + poisson) / (7 + 6 * poisson)};
  }
};

/// The same with a wall t thick, m = (d - 2 t)/d:
///   shear 6 (1 + nu)(1 + m^2)^2/((7 + 6 nu)(1 + m^2)^2 + (20 + 12 nu) m^2)
struct TubeSection {
  std::array<double, 2> size{RectangleSection::not_given, RectangleSection::not_given};
  template <class V>
  void describe(V& v) {
    v.card("tube", "a round tube");
    v.vector("tube", size, "m", "outer diameter, thickness of the wall");
  }
  SectionValues values(double poisson) const {
    const auto [d, t] = size;
    const double inner = d - 2 * t, m = inner / d, w = (1 + m * m) * (1 + m * m), pi = std::numbers::pi;
    return {pi * (d * d - inner * inner) / 4, pi * (d * d * d * d - inner * inner * inner * inner) / 64, d / 2,
            6 * (1 + poisson) * w / ((7 + 6 * poisson) * w + (20 + 12 * poisson) * m * m)};
  }
};

/// Any other by its numbers. Without a shear area it is a beam of Euler and Bernoulli.
struct GivenSection {
  double area = RectangleSection::not_given, second_moment = RectangleSection::not_given;
  double height = RectangleSection::not_given, shear_area = RectangleSection::not_given;
  template <class V>
  void describe(V& v) {
    v.card("area", "any section by its numbers");
    v.quantity("area", area, "m^2", "(0, inf)", "area");
    v.quantity("second moment", second_moment, "m^4", "(0, inf)", "of area, about the axis across the plane");
    v.optional_quantity("height", height, "m", "(0, inf)",
                        "twice the distance of the outermost fibre, for the stress; left out: that of a rectangle of "
                        "these numbers, sqrt(12 I/A)");
    v.optional_quantity("shear area", shear_area, "m^2", "(0, inf)",
                        "area that carries shear; left out: shear does not deform the beam (Euler-Bernoulli)");
  }
  SectionValues values(double) const {
    const double edge = std::isnan(height) ? std::sqrt(3 * second_moment / area) : height / 2;
    return {area, second_moment, edge, std::isnan(shear_area) ? 0 : shear_area / area};
  }
};

using SectionForm = std::variant<RectangleSection, HollowRectangleSection, CircleSection, TubeSection, GivenSection>;
SectionValues values_of(const SectionForm& section, double poisson);

/// An elastic beam along a curve, as nodes and elements:   n elements of equal length l, n + 1 nodes, each a body.
///   node i      mass w_i rho A l,  inertia w_i rho I l,  its axes on the tangent
///   element i   BeamElement between nodes i - 1 and i
/// w: Gregory's weights 3/8, 7/6, 23/24, 1, 1, ..., 23/24, 7/6, 3/8 (for few elements both ends overlap; 1/2, 1/2 of
/// one), which integrate a smooth function of the nodes to the fourth order. So mass, centre and inertia of the beam as
/// a rigid body are exact (of one element: the inertia is not), and frequencies of bending converge with l^4, where
/// weights 1/2, 1, ..., 1/2 give l^2; those of tension, and what shear adds, with l^2.
/// Source of the weights: Davis & Rabinowitz, Methods of Numerical Integration, 2.9.
struct Beam {
  static constexpr double not_given = std::numeric_limits<double>::quiet_NaN();
  std::string name{};
  std::vector<std::array<double, 2>> points{};  ///< world, start pose
  SectionForm section{};
  double young = not_given, density = not_given, poisson = 0.3;
  long elements = 12;
  double damping_time = 0;
  double damping_ratio = not_given;
  std::array<double, 2> velocity{0, 0};  ///< of its first point
  double spin = 0;

  template <class V>
  void describe(V& v) {
    v.points("points", points,
             "its axis in the world of the start pose: two points of a straight beam, or more, through which a smooth "
             "curve goes (a cubic spline); there it is free of stress. A corner is two beams with a `fixed` joint");
    v.form("section", section, "its section");
    v.quantity("young's modulus", young, "Pa", "(0, inf)", "E");
    v.quantity("density", density, "kg/m^3", "(0, inf)", "of its material");
    v.quantity("poisson ratio", poisson, "1", "(-1, 0.5]", "shear modulus E/(2 (1 + nu))");
    v.count("elements", elements, "[1, 400]",
            "of equal length; docs/reference/beams.md lists the errors of deflections and frequencies");
    v.optional_quantity("damping ratio", damping_ratio, "1", "[0, 10)",
                        "of the first mode that it has as a straight cantilever; those above have it in proportion to "
                        "their frequency");
    v.quantity("damping time", damping_time, "s", "[0, inf)",
               "instead: tau of sigma = E (epsilon + tau epsilon'), the beta of Rayleigh damping");
    v.vector("velocity", velocity, "m/s", "of its first point at the start");
    v.quantity("angular velocity", spin, "rad/s", "(-inf, inf)",
               "of the beam as a whole about that point, counter-clockwise");
  }
  /// Throws std::invalid_argument with what is wrong.
  void check() const;

  std::string node_name(long node) const;
  std::string element_name(long element) const { return name + " element " + std::to_string(element); }
};

struct DividedBeam {
  std::vector<Body> nodes;
  std::vector<BeamElement> elements;  ///< nodes by their number, from 0
  std::vector<double> places;         ///< of the nodes along the arc (m)
  SectionValues section;
  double length = 0;        ///< of the arc (m)
  double damping_time = 0;  ///< s
};
/// Of a beam that check() lets pass.
DividedBeam divide(const Beam& beam);

/// First circular frequency of a straight cantilever of Euler and Bernoulli (rad/s).
double first_frequency(double young, double density, const SectionValues& section, double length);

struct Model;
/// Longest step that Adams-Moulton of that order takes on the model's beam elements without their fastest wave growing
/// beyond bounds (s); infinite without any. Of each element the maximum eigenvalue w^2 with the share of mass that it
/// has of its nodes bounds those of the whole (Irons & Treharne 1971); with damping tau w^2 where that is more. Without
/// any damping orders 3 and above feed a wave by some (h w)^6/7 a step; order 2 takes (h w)^4/4 from it: take that.
double longest_beam_step(const Model& model, int order);

}  // namespace subsoil::mbd
