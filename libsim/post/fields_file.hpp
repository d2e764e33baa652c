#pragma once
#include <filesystem>
#include <string>

#include "libsim/base/coarse_graining.hpp"
#include "libsim/io/hdf5.hpp"

namespace subsoil::sim {

/// Which fields there are: those of which the frames hold nothing are left out.
struct FieldsHeld {
  bool velocity = true, contacts = true, stress = true;
};

/// OUT.h5 with /frames/000000/bulk density and so on, each of shape (n_z, n_y, n_x) or with a last axis of 3 or 9, and
/// OUT.xdmf, which tells ParaView of them as images over time, with OUT.xdmf2. They appear when finish() is called.
class FieldsFile {
 public:
  /// @param about kernel and width in words, kept as an attribute
  FieldsFile(const std::filesystem::path& out, const FieldGrid& grid, FieldsHeld held, const std::string& about);
  void add(double time, const GrainFields& fields);
  /// Returns what ParaView opens.
  std::filesystem::path finish();

 private:
  void put(const std::string& name, const std::string& unit, const char* kind, std::size_t columns, const double* data);
  std::filesystem::path h5_, xdmf_;
  FieldGrid grid_;
  FieldsHeld held_;
  h5::Handle file_;
  std::string text_, group_;
  std::size_t count_ = 0;
};

}  // namespace subsoil::sim
