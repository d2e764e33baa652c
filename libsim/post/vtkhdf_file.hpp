#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libsim/io/growing_array.hpp"

namespace subsoil::sim {

/// Of the specification that files are written by: the first with polygonal data that have steps.
inline constexpr std::array<std::int64_t, 2> vtkhdf_version{2, 0};

/// Cells of polygonal data, in the order of their groups in the file.
enum class VtkCells { vertices, lines, polygons };

/// Numbers as they lie in a file: reals of 4 or 8 bytes, whole numbers of 4 or 8.
struct VtkNumbers {
  std::string name;
  bool real = true;
  int bytes = 4;
  std::size_t columns = 1;
  std::vector<double> reals{};
  std::vector<std::int64_t> wholes{};
  std::size_t rows() const { return (real ? reals.size() : wholes.size()) / columns; }
};

/// A VTKHDF file of polygonal data with steps. What does not change between steps is written once.
class VtkFile {
 public:
  /// @param connectivity points of the cells, of cells that stay; empty: cell k has the points that follow
  ///        those of cell k - 1, as many as there are
  VtkFile(std::filesystem::path file, VtkCells cells, std::vector<std::int64_t> connectivity);

  /// The next step. @param points columns 3; left out: those of the step before
  void add_step(const VtkNumbers* points);
  /// An array of the step, on points or cells. @param numbers left out: those of the step before, by the name
  void add_point_array(const std::string& name, const VtkNumbers* numbers) { add_array(0, name, numbers); }
  void add_cell_array(const std::string& name, const VtkNumbers* numbers) { add_array(1, name, numbers); }
  /// Writes what is known at the end, and puts the file in place. @param times s, of the steps
  void finish(const std::vector<double>& times);

 private:
  struct Array {
    GrowingArray values;
    std::int64_t start = 0;             ///< of the last step's rows
    std::vector<std::int64_t> offsets;  ///< by step
  };
  void add_array(std::size_t kind, const std::string& name, const VtkNumbers* numbers);
  void write_cells(const std::string& path, bool used, bool constant);
  void write_steps(const std::vector<double>& times, bool constant);

  std::filesystem::path path_;
  h5::Handle file_;
  VtkCells cells_;
  std::vector<std::int64_t> connectivity_;
  std::optional<GrowingArray> coordinates_;
  std::int64_t start_ = 0;
  std::size_t points_now_ = 0, cells_now_ = 0;
  std::vector<std::int64_t> point_offsets_, point_counts_, cell_counts_;
  std::map<std::string, Array> arrays_[2];
};

}  // namespace subsoil::sim
