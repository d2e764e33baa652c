#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libsim/base/coarse_graining.hpp"

/// `subsoil fields RUN`: continuum fields of a run's frames on a grid or a section.
namespace subsoil::sim {

/// Plane across an axis (0 x, 1 y, 2 z).
struct FieldSection {
  int axis = 2;
  double at = 0;  ///< m
};

struct FieldsRequest {
  std::filesystem::path run{};
  std::filesystem::path out{};  ///< without its suffix; empty: RUN/fields
  FieldKernel::Kind kernel = FieldKernel::Kind::lucy;
  std::optional<double> width{};    ///< m; left out: mean diameter
  std::optional<double> spacing{};  ///< m; left out: half the width, or what makes `most_points`;
                                    ///< along periodic axes the nearest that divides the period
  std::optional<FieldSection> section{};
  std::vector<double> times{};  ///< s, of the nearest frames; empty: the last one, or
  bool all = false;             ///< every one
  static constexpr double most_points = 2e6;
};

/// What was written, for those who print it.
struct FieldsReport {
  std::filesystem::path xdmf;
  double width = 0, reach = 0;
  FieldGrid grid;
  std::size_t frames = 0;
  bool has_velocity = true, has_contacts = true, has_stress = true;
  std::string sides;  ///< why the sides of the container are not known, which are taken as open then
};

/// Writes OUT.h5, OUT.xdmf and OUT.xdmf2. Throws std::invalid_argument for what no such run can give.
FieldsReport write_fields(const FieldsRequest& request);

}  // namespace subsoil::sim
