#include "libsim/setup/compaction_plate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/setup/shown_area.hpp"

namespace subsoil::sim {
namespace {

constexpr double kHeld = 0.01;        ///< of the load: what may be missing or too much of it
constexpr double kLagSteps = 20;      ///< as of a servo of the run
constexpr double kShareOfFall = 0.2;  ///< of the speed of a fall by a diameter: slow against what settles anyway

}  // namespace

CompactionPlate::CompactionPlate(const dem::Bed& bed, int boundary, double pressure, double step)
    : boundary_(boundary), area_(shown_area(bed.boundary(boundary), {0, -1, 0}, bed.options().periodic)) {
  servo_.load = [load = pressure * area_](double) { return load; };
  servo_.lag = kLagSteps * step;
}

void CompactionPlate::begin(dem::Bed& bed) {
  double top = -1e300, radius = dem::mean_radius(bed.spheres());
  for (const dem::Sphere& s : bed.spheres()) top = std::max(top, s.x.y + s.r);
  servo_.limit = kShareOfFall * std::sqrt(4 * radius * dem::norm(bed.options().gravity));
  servo_.gain = servo_.limit / servo_.load(0);
  now_ = {};
  dem::Boundary& plate = bed.boundary(boundary_);
  const double mesh = dem::bounds(plate.shape).low.y;
  plate.active = true;
  plate.pose.position.y = start_ = top + 0.1 * radius - mesh;
  plate.pose_before = plate.pose;
  plate.velocity = {};
  bed.surfaces_changed();
}

void CompactionPlate::advance(dem::Bed& bed, double dt) {
  dem::Boundary& plate = bed.boundary(boundary_);
  now_.advance(servo_, plate.wrench.force, bed.time(), dt);
  plate.pose.position.y = start_ - now_.travel;
  plate.velocity = servo_.along * now_.velocity;
}

bool CompactionPlate::holds() const { return now_.began && std::abs(now_.error) < kHeld * now_.load; }

std::string CompactionPlate::state() const {
  return fmt::format("the spheres bear {:.4g} kPa of {:.4g} kPa", now_.force / area_ * 1e-3, now_.load / area_ * 1e-3);
}

void CompactionPlate::end(dem::Bed& bed) {
  dem::Boundary& plate = bed.boundary(boundary_);
  plate.active = false;
  plate.velocity = {};
  bed.surfaces_changed();
}

void CompactionPlate::archive(Archive& a) {
  a("start", start_)("limit", servo_.limit)("gain", servo_.gain)("servo", now_);
}

Archive::Columns CompactionPlate::save() const {
  Archive a;
  CompactionPlate(*this).archive(a);
  return a.columns();
}

void CompactionPlate::restore(const Archive::Columns& saved) {
  Archive a(saved, {});
  archive(a);
  a.end();
}

}  // namespace subsoil::sim
