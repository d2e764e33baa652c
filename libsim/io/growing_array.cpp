#include "libsim/io/growing_array.hpp"

#include <algorithm>
#include <utility>

namespace subsoil::sim {
namespace {

/// 64 kB of a chunk compress well, and a small array wastes little of its last one.
hsize_t rows_per_chunk(hid_t type, hsize_t columns) {
  return std::max<hsize_t>(1, 65536 / (H5Tget_size(type) * columns));
}

}  // namespace

GrowingArray::GrowingArray(hid_t parent, std::string name, hid_t type, hsize_t columns)
    : name_(std::move(name)), type_(H5Tcopy(type), H5Tclose, "type of " + name_), columns_(columns) {
  const int rank = columns > 1 ? 2 : 1;
  const hsize_t none[2] = {0, columns}, any[2] = {H5S_UNLIMITED, columns};
  const hsize_t chunk[2] = {rows_per_chunk(type, columns), columns};
  const h5::Handle space(H5Screate_simple(rank, none, any), H5Sclose, "shaping " + name_);
  const h5::Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "preparing " + name_);
  h5::checked(H5Pset_obj_track_times(properties, false), "preparing " + name_);
  h5::checked(H5Pset_chunk(properties, rank, chunk), "choosing chunks of " + name_);
  h5::checked(H5Pset_shuffle(properties), "choosing byte shuffle");
  h5::checked(H5Pset_deflate(properties, 1), "choosing gzip");
  set_ = h5::Handle(H5Dcreate2(parent, name_.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose,
                    "creating " + name_);
}

void GrowingArray::append(const void* data, hsize_t rows) {
  if (rows == 0) return;
  const int rank = columns_ > 1 ? 2 : 1;
  const hsize_t from[2] = {rows_, 0}, count[2] = {rows, columns_}, size[2] = {rows_ + rows, columns_};
  h5::checked(H5Dset_extent(set_, size), "extending " + name_);
  const h5::Handle file(H5Dget_space(set_), H5Sclose, "shape of " + name_);
  h5::checked(H5Sselect_hyperslab(file, H5S_SELECT_SET, from, nullptr, count, nullptr), "choosing rows of " + name_);
  const h5::Handle memory(H5Screate_simple(rank, count, nullptr), H5Sclose, "shaping rows of " + name_);
  h5::checked(H5Dwrite(set_, type_, memory, file, H5P_DEFAULT, data), "writing " + name_);
  rows_ += rows;
}

}  // namespace subsoil::sim
