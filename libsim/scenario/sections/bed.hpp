#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libsim/scenario/sections/clumps.hpp"
#include "libsim/scenario/sections/fibres.hpp"
#include "libsim/scenario/sections/placement.hpp"
#include "libsim/scenario/sections/radius.hpp"

/// The spheres: how they are placed, layered and brought to rest.
namespace subsoil::sim {

enum class Fill { lattice, rest_lattice, random, particles, file };
/// Under which columns and monitors know the spheres of a rough floor.
inline constexpr const char* rough_floor_name = "rough floor";

enum class Overlap { refuse, carve };
enum class Stages { automatic, yes, no };

/// Let the bed come to rest before the run starts (time 0 is after it).
struct Settle {
  std::optional<double> duration;     // `for`
  std::optional<double> until_speed;  // rms speed of the spheres
  double at_most = 5.0;               // s; longer is an error
  std::optional<double> density;      // `to`, kg/m^3, or
  std::optional<double> pressure;     // `to`, Pa
  Stages stages = Stages::automatic;  // automatic: yes for random fill
  double lowered = 0.1;               // factor on friction and rolling before the ramp
  double ramp = 0.1;                  // s over which attraction, friction and rolling come back
  bool compacts() const { return density || pressure; }
  bool staged(Fill fill) const {
    return stages == Stages::yes || (stages == Stages::automatic && fill == Fill::random);
  }
};
void describe(Fields& v, Settle& s);

struct Particle {
  Vec3 position{required, required, required};
  Vec3 velocity{}, spin{};
  double radius = required;
  std::optional<double> density;  // of its material unless given
  std::string material;           // of the bed unless given
  std::string fixed;              // name of the fixed body it belongs to; empty: it moves
};
void describe(Fields& v, Particle& p);

/// One of several layers, from the surface down. The lowest one may leave both lengths out: it takes the rest.
struct Layer {
  std::optional<double> thickness;
  std::optional<Vec2> depth;  // from, to below the surface
  std::string material;
  RadiusDistribution radius;       // of the bed unless given
  std::vector<ClumpShare> clumps;  // among its grains
};
void describe(Fields& v, Layer& l);

struct BedSection {
  Fill fill = Fill::rest_lattice;
  std::string material;
  std::vector<Layer> layers;  // in place of the material
  RadiusDistribution radius;  // not for particles and file
  ShareOf shares = ShareOf::number;
  std::optional<double> pitch;  // lattice; default 2.02 radii (20.2 mm for 10 mm), rest lattice: from the law
  std::optional<Box> region;    // the container unless given
  std::optional<long> count;    // random: this many spheres, or
  std::optional<double> depth;  // fill the region's floor up to this height after settling
  long seed = 1;
  double jitter = 0;  // maximum random shift of a lattice site, share of the radius
  std::optional<Settle> settle;
  std::string save, file;  // absolute paths; empty: none
  std::vector<Particle> particles;
  std::vector<ClumpShare> clumps;     // among the grains of a made bed
  std::vector<PlacedClump> placed;    // beside the particles
  std::vector<FibreSection> fibres;   // laid on the bed when it lies
  std::optional<double> rough_floor;  // m above the floor: spheres below are fixed when the run begins
  Overlap inside_machine = Overlap::refuse;
  /// Whether it comes to rest before the run starts: as asked, or as it is poured.
  bool settles() const { return settle.has_value() || fill == Fill::random; }
};
void describe(Fields& v, BedSection& b);

struct Checks;
struct Scenario;
void check_bed(Checks& checks, const Scenario& s);
bool any_clumps(const BedSection& bed);  ///< among the grains that fill it, of a layer too

}  // namespace subsoil::sim
