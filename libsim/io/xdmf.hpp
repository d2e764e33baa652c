#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace subsoil::sim {

/// A dataset that the XDMF names: file:path, its shape and its numbers.
struct XdmfArray {
  std::string location;  ///< frames/000000.h5:/frames/000000/position
  std::vector<std::uint64_t> dimensions;
  bool real = true;
  int bytes = 4;
};

struct XdmfAttribute {
  std::string name;
  XdmfArray array;
  bool per_cell = false;  ///< else per point
};

/// One block of a frame. `cells` of 3 columns are triangles, of 2 line segments, of one points. (The XDMF 2 reader
/// makes points without their numbers, ParaView's XDMF 3 readers show nothing then.)
struct XdmfGrid {
  std::string name;
  XdmfArray vertices, cells;
  std::vector<XdmfAttribute> attributes;
};

/// What stands in FILE.xdmf2: the contents of FILE.xdmf, by XInclude. ParaView has three readers for .xdmf and asks
/// which; of .xdmf2 it knows one, which shows all that we write, and opens it without a question.
std::string xdmf_leading_to(const std::string& file_name);

std::string grid_xml(const XdmfGrid& grid);

/// The XDMF text of a run: a temporal collection of frames, each a spatial collection of its grids.
class Xdmf {
 public:
  explicit Xdmf(const std::string& title);
  /// @param soil grids of parts, by grid_xml: together they are one collection, `soil`; empty: none
  void add_frame(double time, const std::vector<XdmfGrid>& grids, const std::string& soil = "");
  /// Takes over the first frames of an earlier text of the same title. Throws std::runtime_error when it has fewer.
  void keep(const std::string& text, long frames);
  /// The whole document as far as it goes.
  std::string text() const;

 private:
  std::string text_;  ///< without the closing tags
  long count_ = 0;
};

}  // namespace subsoil::sim
