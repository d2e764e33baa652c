#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>
#include <string>

#include "libsim/io/hdf5.hpp"
#include "tests/tools/scratch.hpp"
#include "tests/tools/xml.hpp"

namespace subsoil::sim::test {

/// Follows every DataItem of an XDMF: the file and dataset exist and have the stated shape and number type. Returns how
/// many there are.
inline int check_xdmf(const std::filesystem::path& path) {
  const Xml document(text_of(path));
  int count = 0;
  for (const auto* item : document.all("DataItem")) {
    ++count;
    const auto colon = item->text.find(':');
    const std::string dataset = item->text.substr(colon + 1);
    EXPECT_NE(item->text.front(), '/') << "the run must be movable: relative names only";
    const auto file = h5::open_file(path.parent_path() / item->text.substr(0, colon));
    std::vector<hsize_t> stated;
    std::istringstream words(item->attributes.at("Dimensions"));
    for (hsize_t n; words >> n;) stated.push_back(n);
    EXPECT_EQ(h5::shape(file, dataset), stated) << item->text;
    const h5::Handle set(H5Dopen2(file, dataset.c_str(), H5P_DEFAULT), H5Dclose, dataset);
    const h5::Handle type(H5Dget_type(set), H5Tclose, dataset);
    EXPECT_EQ(std::to_string(H5Tget_size(type)), item->attributes.at("Precision")) << item->text;
    const bool real = item->attributes.at("NumberType") == "Float";
    EXPECT_EQ(H5Tget_class(type), real ? H5T_FLOAT : H5T_INTEGER) << item->text;
  }
  // As many elements as rows, and as many points as places.
  for (const auto* grid : document.all("Grid")) {
    const auto* topology = grid->child("Topology");
    if (!topology) continue;
    const auto rows = [](const Xml::Element* parent) {
      return std::stoul(parent->child("DataItem")->attributes.at("Dimensions"));
    };
    EXPECT_EQ(std::stoul(topology->attributes.at("NumberOfElements")), rows(topology));
    const bool points = topology->attributes.at("TopologyType") == "Polyvertex";
    EXPECT_TRUE(!points || rows(topology) == rows(grid->child("Geometry")));
  }
  return count;
}

}  // namespace subsoil::sim::test
