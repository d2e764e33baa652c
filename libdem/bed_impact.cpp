#include "libdem/bed_impact.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "libdem/bed.hpp"

namespace subsoil::dem::impact {
namespace {

Bed touching(const Law& law, const Strikers& bodies, double speed) {
  const LawTable table{.materials = 1, .index = {0}, .laws = {law}};
  BedOptions options;
  options.gravity = {}, options.threads = 1;
  options.speed_limit = options.overlap_limit = 1e300;
  Bed bed(table, options);
  const auto sphere = [&](double x, double v, double radius, double mass) {
    return SphereSpec{{x, 0, 0}, {v, 0, 0}, {}, radius, mass / sphere_volume(radius), 0};
  };
  if (bodies.two_spheres()) {
    const double share = bodies.mass_2 / (bodies.mass_1 + bodies.mass_2);
    const std::array<SphereSpec, 2> both{sphere(-bodies.radius_1, speed * share, bodies.radius_1, bodies.mass_1),
                                         sphere(bodies.radius_2, -speed * (1 - share), bodies.radius_2, bodies.mass_2)};
    bed.add(both);
  } else {
    const SphereSpec one = sphere(-bodies.radius(), speed, bodies.radius(), bodies.mass());
    bed.add(std::span(&one, 1));
    Boundary plane;
    plane.shape = Plane({}, {-1, 0, 0});
    bed.add(std::move(plane));
  }
  return bed;
}

Sample sample_of(const Snapshot& s, double t, const Strikers& bodies) {
  if (bodies.two_spheres())
    return {t, bodies.radius_1 + bodies.radius_2 - (s.position[1].x - s.position[0].x),
            s.velocity[0].x - s.velocity[1].x, -s.force[0].x};
  return {t, bodies.radius() + s.position[0].x, s.velocity[0].x, -s.force[0].x};
}

/// Time and height of a maximum through three equal steps.
std::array<double, 2> crest(const Sample& a, const Sample& b, const Sample& c) {
  const double bend = a.f - 2 * b.f + c.f, slope = 0.5 * (c.f - a.f);
  if (!(bend < 0)) return {b.t, b.f};
  return {b.t - slope / bend * (c.t - b.t), b.f - 0.5 * slope * slope / bend};
}

}  // namespace

Event strike_in_bed(const Law& law, const Strikers& bodies, double speed, double step, long most_steps) {
  Bed bed = touching(law, bodies, speed);
  Event event;
  for (long n = 0; n < most_steps; ++n) {
    Snapshot shot;
    const double t = bed.time();
    bed.step(step, {.energy = false, .snapshot = &shot});
    const Sample now = sample_of(shot, t, bodies);
    if (n > 0) {
      const Sample& last = event.course.back();
      if (last.v > 0 && now.v <= 0) {
        const double part = last.v / (last.v - now.v);
        event.time_in = last.t + part * step;
        event.largest = last.x + 0.5 * part * step * last.v;
      }
      if (now.v < 0 && now.x > 0 && now.f == 0 && last.f > 0 && n > 1) {
        // Plastic bodies: what they have left of their indentation pushes no more. The force falls in a straight line.
        const double fall = event.course[event.course.size() - 2].f - last.f;
        event.time_out = last.t + step * std::min(1.0, fall > 0 ? last.f / fall : 0.5) - event.time_in;
        event.rebounds(bodies.mass(), speed, -now.v);
        break;
      }
      if (now.v < 0 && now.x <= 0 && !(now.f < 0)) {
        // Surfaces part at x = 0, or, held by adhesion until then, within this step.
        event.time_out = last.t + step * (last.x > 0 ? last.x / (last.x - now.x) : 0.5) - event.time_in;
        event.rebounds(bodies.mass(), speed, -now.v);
        break;
      }
    }
    event.course.push_back(now);
  }
  if (!(event.rebound > 0)) throw std::runtime_error("the bodies did not come apart in the steps allowed");
  std::size_t top = 0;
  for (std::size_t k = 0; k < event.course.size(); ++k)
    if (event.course[k].f > event.course[top].f) top = k;
  event.peak_time = event.course[top].t, event.peak_force = event.course[top].f;
  if (top > 0 && top + 1 < event.course.size()) {
    const auto [t, f] = crest(event.course[top - 1], event.course[top], event.course[top + 1]);
    event.peak_time = t, event.peak_force = f;
  }
  return event;
}

}  // namespace subsoil::dem::impact
