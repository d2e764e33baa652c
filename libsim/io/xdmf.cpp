#include "libsim/io/xdmf.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <stdexcept>

#include "libsim/base/markup.hpp"

namespace subsoil::sim {
namespace {

std::string array_xml(const XdmfArray& array) {
  return fmt::format(R"(<DataItem Format="HDF" NumberType="{}" Precision="{}" Dimensions="{}">{}</DataItem>)",
                     array.real ? "Float" : "Int", array.bytes, fmt::join(array.dimensions, " "),
                     escaped_markup(array.location));
}

}  // namespace

std::string grid_xml(const XdmfGrid& grid) {
  std::string xml = fmt::format("   <Grid Name=\"{}\" GridType=\"Uniform\">\n", escaped_markup(grid.name));
  const std::vector<std::uint64_t>& cells = grid.cells.dimensions;
  const char* type = cells.size() == 1 ? "Polyvertex\" NodesPerElement=\"1"
                     : cells[1] == 2   ? "Polyline\" NodesPerElement=\"2"
                                       : "Triangle";
  xml += fmt::format("    <Topology TopologyType=\"{}\" NumberOfElements=\"{}\">{}</Topology>\n", type, cells.at(0),
                     array_xml(grid.cells));
  xml += fmt::format("    <Geometry GeometryType=\"XYZ\">{}</Geometry>\n", array_xml(grid.vertices));
  for (const auto& attribute : grid.attributes)
    xml += fmt::format("    <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"{}\">{}</Attribute>\n",
                       escaped_markup(attribute.name), attribute.array.dimensions.size() == 2 ? "Vector" : "Scalar",
                       attribute.per_cell ? "Cell" : "Node", array_xml(attribute.array));
  return xml + "   </Grid>\n";
}

std::string xdmf_leading_to(const std::string& file_name) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\">\n"
      " <xi:include href=\"{}\" xpointer=\"xpointer(/Xdmf/Domain)\"/>\n</Xdmf>\n",
      escaped_markup(file_name));
}

Xdmf::Xdmf(const std::string& title)
    : text_(fmt::format("<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n <Domain>\n"
                        " <Information Name=\"title\" Value=\"{}\"/>\n"
                        " <Grid Name=\"run\" GridType=\"Collection\" CollectionType=\"Temporal\">\n",
                        escaped_markup(title))) {}

void Xdmf::add_frame(double time, const std::vector<XdmfGrid>& grids, const std::string& soil) {
  text_ += fmt::format(
      "  <Grid Name=\"frame {}\" GridType=\"Collection\" CollectionType=\"Spatial\">\n   <Time Value=\"{:.12g}\"/>\n",
      count_++, time);
  if (!soil.empty())
    text_ += "   <Grid Name=\"soil\" GridType=\"Collection\" CollectionType=\"Spatial\">\n" + soil + "   </Grid>\n";
  for (const auto& grid : grids) text_ += grid_xml(grid);
  text_ += "  </Grid>\n";
}

void Xdmf::keep(const std::string& text, long frames) {
  // Frames follow each other; the first that goes, or what closes them all, ends what stays.
  const std::string next = fmt::format("  <Grid Name=\"frame {}\"", frames);
  std::size_t end = text.find(next);
  if (end == std::string::npos) end = text.find("\n </Grid>\n </Domain>") + 1;
  if (end == 0 || text.compare(0, text_.size(), text_) != 0 ||
      (frames > 0 && text.find(fmt::format("  <Grid Name=\"frame {}\"", frames - 1)) == std::string::npos))
    throw std::runtime_error(fmt::format("run.xdmf does not hold the {} frames that the state counts", frames));
  text_ = text.substr(0, end);
  count_ = frames;
}

std::string Xdmf::text() const { return text_ + " </Grid>\n </Domain>\n</Xdmf>\n"; }

}  // namespace subsoil::sim
