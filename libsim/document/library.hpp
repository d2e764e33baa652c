#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "libsim/document/node.hpp"

/// Materials that come with the program: `materials: {soil: library sandy-loam-10mm, share: library steel}`.
///
/// A library's soil is the spheres of one radius with the contact law that makes a bed of them as strong as the soil of
/// its source: its parameters were found by the program's own laboratory tests, and the file has their results. They
/// belong to that radius and to no other. The data stand in configs/materials/library.yaml, which is built in.
namespace subsoil::sim {

/// What a laboratory test of the material gave, beside what its source states.
struct LibraryTest {
  std::string number;    ///< "shear friction angle"
  std::string wanted;    ///< of the source, with its unit; empty: the source does not state it
  std::string measured;  ///< "28.1 +- 1.9 deg", 95 %
};

struct LibraryMaterial {
  std::string name, what, source, remark;
  std::string radius;  ///< of the spheres, with its unit; empty: of surfaces only
  Node material;       ///< keys of `materials`
  Node law;            ///< of its spheres among each other, keys of `contacts`; empty: of surfaces only
  Node steel;          ///< what is different against the library's steel
  std::vector<LibraryTest> tests;

  bool is_soil() const { return !law.entries.empty(); }
};

const std::vector<LibraryMaterial>& library();
/// Throws std::invalid_argument with the nearest name.
const LibraryMaterial& library_material(std::string_view name);

/// Puts the library's values where a scenario names it, `library NAME` or a key `library` among values of its own, and
/// adds the contacts that follow. What the scenario gives itself stays. Faults go to `problems`.
void take_from_library(Node& scenario, Problems& problems);

/// `subsoil materials` and `subsoil materials NAME`.
std::string library_table();
std::string library_text(const LibraryMaterial& material);

/// The YAML text of the library, built in.
std::string_view library_source();

}  // namespace subsoil::sim
