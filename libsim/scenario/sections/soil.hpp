#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "libdem/particles/periodic.hpp"
#include "libsim/scenario/sections/bed.hpp"
#include "libsim/scenario/sections/inlets.hpp"
#include "libsim/scenario/sections/placement.hpp"

/// Container and bed.
namespace subsoil::sim {

/// Faces in the order -x, +x, -y, +y, -z, +z.
using Faces = std::array<bool, 6>;
using Directions = std::array<bool, 3>;
inline constexpr std::array<const char*, 3> axis_names{"x", "y", "z"};
inline constexpr std::array<const char*, 6> face_names{"-x", "+x", "-y", "+y", "-z", "+z"};

struct Container {
  Vec3 size{required, required, required};
  Vec3 at{required, required, required};  // corner of minimum coordinates
  Faces open{false, false, false, true, false, false};
  Faces open_after_settling{};
  Directions periodic{};
  std::string material;
};
void describe(Fields& v, Container& c);
/// Whether a face (of face_names) has a wall when the bed is made: it is neither open nor one of a periodic direction.
bool has_wall(const Container& c, std::size_t face);
/// Whether it has one during the run, too: it is not taken away after settling.
bool keeps_wall(const Container& c, std::size_t face);
/// What the wall of a face (of face_names) is called in columns and messages: `floor`, `wall -x`.
std::string wall_name(std::size_t face);
/// Of all faces that have one.
std::vector<std::string> wall_names(const Container& c);
/// Its sides for the bed, `up` m higher than in the scenario.
dem::PeriodicCell periodic_cell(const Container& c, double up = 0);

/// Spheres that rest far from every moving surface sleep until something comes near (docs/theory, section 8.1).
struct Active {
  double within = 0.2;          // m
  std::optional<double> below;  // m/s; by gravity and the mean diameter unless given
};
void describe(Fields& v, Active& a);

enum class Towards { plus_x, minus_x };

/// A long bed in a short window (docs/theory, section 7.2): the container advances by a block whenever what it
/// follows has travelled one. The bed of the scenario is then one period along x, which is repeated.
struct MovingWindow {
  std::string follows;
  double block = required;       // m
  std::optional<double> period;  // m; a block unless given
  Towards towards = Towards::plus_x;
  int direction() const { return towards == Towards::plus_x ? 1 : -1; }
};
void describe(Fields& v, MovingWindow& m);

struct Soil {
  std::optional<Container> container;
  std::optional<double> surface;     // y of the mean surface after settling: bed and container are shifted
  std::vector<ClumpSection> clumps;  // shapes of grains
  std::optional<BedSection> bed;
  std::vector<InletSection> inlets;    // that pour spheres during the run
  std::optional<Active> active;        // all spheres move unless given
  std::optional<MovingWindow> moving;  // the container stands unless given
  double removal_below = 0.5;          // m below the floor
};
void describe(Fields& v, Soil& s);

struct Checks;
struct Scenario;
void check_soil(Checks& checks, const Scenario& s);

}  // namespace subsoil::sim
