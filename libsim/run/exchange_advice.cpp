#include "libsim/run/exchange_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "coupling/exchange_stability.hpp"
#include "libdem/laws/contact.hpp"
#include "libsim/setup/shown_area.hpp"
#include "libsim/setup/yielding.hpp"

namespace subsoil::sim {
namespace {

/// Spheres of radius r that lie side by side on the body's surfaces of one material.
double spheres_on(const World& world, const YieldingBody& body, double r) {
  double area = 0;
  int before = -1;
  for (const SurfaceRecord& s : world.surfaces) {
    if (s.owner != SurfaceRecord::Owner::machine || s.body != body.body || s.boundary == before) continue;
    const dem::Boundary& b = world.bed->boundary(before = s.boundary);
    if (b.material != body.material) continue;
    if (std::holds_alternative<dem::Plane>(b.shape)) return std::numeric_limits<double>::infinity();
    area += std::max(shown_area(b, {1, 0, 0}, {}), shown_area(b, {0, 1, 0}, {}));
  }
  return std::max(1.0, area / (4 * r * r));
}

/// Whether an oscillation of the body grows noticeably.
bool grows(const coupling::ContactMode& mode, double soil_step, int soil_steps) {
  const double growth = coupling::explicit_growth(mode, soil_step, soil_steps);
  if (!(growth > 1)) return false;
  const double window = soil_step * soil_steps,
               windows = std::max(1.0, 2 * std::numbers::pi / (window * std::sqrt(mode.stiffness / mode.mass)));
  return windows * std::log(growth) > 0.01;
}

}  // namespace

std::vector<std::string> exchange_warnings(const Loaded& loaded, const World& world) {
  std::vector<std::string> out;
  const Scenario& s = loaded.scenario;
  if (!world.bed || !world.machine || s.time.coupling == CouplingWord::iterated || world.bed->spheres().empty())
    return out;
  const double dt = world.step.soil_step;
  const int steps = static_cast<int>(s.time.machine.soil_steps);
  const auto spheres = world.bed->spheres();
  const auto all = static_cast<double>(spheres.size());
  const dem::Sphere& one =
      *std::min_element(spheres.begin(), spheres.end(), [](const auto& a, const auto& b) { return a.r < b.r; });
  const auto grows_with = [&](double count, double mass, int material) {
    const int law = world.laws.of(one.material, material);
    if (law < 0) return false;
    const dem::StiffnessBound of = world.laws.laws[static_cast<std::size_t>(law)]->bound(
        {.m_eff = world.bed->mass_of_body(one), .r_eff = one.r, .r_min = one.r, .speed = world.step.expected_speed});
    return grows({.stiffness = count * of.k_n, .damping = count * of.c_n, .mass = mass}, dt, steps);
  };
  // The mobility of a body in its machine costs the cube of the coordinates: only of those light enough for all
  // spheres.
  double lightest = 0;
  for (const coupling::BodySurface& b : world.body_surfaces) {
    const int material = world.bed->boundary(b.boundary).material;
    double stable = 1e12, unstable = 1e-12;
    if (!grows_with(all, unstable, material)) continue;
    while (stable > 1.1 * unstable) {
      const double middle = std::sqrt(stable * unstable);
      (grows_with(all, middle, material) ? unstable : stable) = middle;
    }
    lightest = std::max(lightest, stable);
  }
  for (const YieldingBody& body : yielding_bodies(world, s, lightest / yielding_ratio)) {
    const double fit = std::floor(std::min(spheres_on(world, body, one.r), all));
    const auto unstable_with = [&](double count) { return grows_with(count, body.middle_mass, body.material); };
    if (!std::isfinite(body.middle_mass) || !unstable_with(fit)) continue;
    double stable = 0, unstable = fit;
    while (unstable - stable > 1) {
      const double middle = std::floor(0.5 * (stable + unstable));
      (unstable_with(middle) ? unstable : stable) = middle;
    }
    out.push_back(fmt::format(
        "{}: the explicit exchange is unstable for `{}`, effective mass {:.3g} kg, where {:.0f} or more of the {:.0f} "
        "spheres that fit on it touch at once, over a machine step of {:.3g} s; take `time.coupling: iterated`{}",
        loaded.where("time.coupling"), world.machine->system().body_name(body.body), body.middle_mass, unstable, fit,
        dt * steps,
        steps > 1 ? ", or fewer `time.machine.soil steps per machine step`" : ", or a shorter `time.soil step`"));
  }
  return out;
}

}  // namespace subsoil::sim
