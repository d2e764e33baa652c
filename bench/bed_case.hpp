#pragma once
#include <string>
#include <vector>

#include "bench/settled_tile.hpp"
#include "libdem/bed.hpp"

/// The beds that are timed. Everything that another program needs to run the same case stands here in plain numbers.
namespace subsoil::bench {

enum class Kind { rest, plough, pour };
enum class LawName { linear, hertz, rolling, cohesive, wet, hysteretic, luding, eepa, variable, jkr, bridge, bonded };

/// The law between two spheres.
dem::GivenLaw law_of(LawName name);

struct CaseRequest {
  Kind kind = Kind::rest;
  LawName law = LawName::linear;
  double spheres = 130e3;  ///< about; whole blocks of 13,000
  int triangles = 740;     ///< of the plough's tool, about; 0: no tool
  std::string tiles;       ///< folder of the settled blocks
};

/// A plate with every face divided into rectangles of two triangles, 0.05 m long (x), 0.30 m high and 0.12 m wide.
struct Tool {
  dem::Vec3 size{0.05, 0.30, 0.12}, centre;  ///< m, at the start
  dem::Vec3 velocity{0.5, 0, 0};             ///< m/s
  dem::TriangleMesh mesh;                    ///< about its centre
};

struct Case {
  double step = 2e-5;            ///< s
  dem::LawTable laws;            ///< material 0: spheres; 1: walls and tool
  double length = 0, width = 0;  ///< m, in x and z; walls stand at 0 and there, the floor at y = 0
  std::vector<dem::SphereSpec> spheres;
  bool has_tool = false;
  Tool tool;
};

/// A case, its spheres with velocities of up to 5 mm/s so that springs, dashpots and friction have work. The same
/// numbers on every machine.
Case make_case(const CaseRequest& request);

/// Puts the case into a bed, spheres in the tool's place left out; returns the tool's boundary, -1 without.
int fill(dem::Bed& bed, const Case& c);

}  // namespace subsoil::bench
