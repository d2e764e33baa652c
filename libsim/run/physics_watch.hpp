#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libsim/run/run_summary.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// Checks a run of spheres for what no physics does. Each kind is reported once, where first met; what is beyond
/// repair stops the run. (The bed itself stops at limits.overlap and limits.speed in the step that breaks them.)
class PhysicsWatch {
 public:
  /// Share of the energy there, at most so far, or moved by which the bed's balance may be off. Passes of docs/1s300.md
  /// close to 2e-3 with losses that are sampled; a contact that is resolved by ten steps errs by a tenth of its energy.
  static constexpr double closure_said = 0.05;
  /// Travel of a surface in one step, in smallest radii: a contact of a tenth of a radius is then met by one step, and
  /// beyond one radius spheres are stepped over.
  static constexpr double travel_said = 0.1, travel_stops = 1;

  /// Energy in the contacts of a bed that begins, over what lifts each of its spheres by its radius. A bed at rest
  /// under twenty layers of its own, compressed by 0.1 mm per 10 mm, holds a hundredth of it.
  static constexpr double begins_pressed = 10;

  struct Finding {
    std::string text;
    bool stops = false;
  };

  PhysicsWatch(const Scenario& scenario, const World& world);

  /// After the first step: what overlaps so far that it will fly apart. Nothing without gravity, which is the measure.
  std::optional<Finding> start(const World& world) const;
  /// After a step whose energy was asked for. @param fastest of all spheres so far, m/s
  /// @param deepest of all overlaps so far, share of the smaller radius
  std::vector<Finding> look(const World& world, const EnergyStart& start, double fastest, double deepest);
  void archive(Archive& a) {
    a("looks", looks_)("most present", most_present_)("said closure", said_closure_)("said travel", said_travel_)(
        "said step", said_step_)("said pressed", said_pressed_)("said outside", said_outside_);
  }

 private:
  std::optional<Finding> energy(const World& world, const EnergyStart& start);
  std::optional<Finding> travel(const World& world);
  std::optional<Finding> step(const World& world, double fastest);
  std::optional<Finding> pressed(const World& world, double deepest);
  std::optional<Finding> walls(const World& world);
  /// Of the active ones, with the speed of its farthest place, m/s; nullptr where none moves.
  std::pair<const dem::Boundary*, double> fastest_surface(const World& world) const;

  const Scenario& s_;
  double mass_ = 0;                                // kg, of the free spheres
  double fixed_mass_ = 0;                          // kg; a contact with one is resolved as that of a free sphere
  double weight_times_radius_ = 0, smallest_ = 0;  // J, m
  double rounding_ = 0;                            // J
  double most_present_ = 0;                        // J in motion and contacts, at looks so far
  std::vector<double> farthest_;                   // of each boundary from the origin of its pose, m; 0 of planes
  long looks_ = 0;
  bool said_closure_ = false, said_travel_ = false, said_step_ = false, said_pressed_ = false, said_outside_ = false;
};

}  // namespace subsoil::sim
