#include "libsim/post/fields_file.hpp"

#include <fmt/format.h>

#include "libsim/io/atomic_file.hpp"
#include "libsim/io/hdf5_driver.hpp"
#include "libsim/io/xdmf.hpp"

namespace subsoil::sim {
namespace {

std::filesystem::path with_suffix(std::filesystem::path out, const char* suffix) {
  out += suffix;
  return out;
}

/// Pressure: a third of the trace of both stresses.
std::vector<double> pressure(const GrainFields& f) {
  std::vector<double> out(f.density.size());
  for (std::size_t i = 0; i < out.size(); ++i)
    for (const std::size_t d : {0U, 4U, 8U}) out[i] += (f.contact_stress[i][d] + f.kinetic_stress[i][d]) / 3;
  return out;
}

}  // namespace

FieldsFile::FieldsFile(const std::filesystem::path& out, const FieldGrid& grid, FieldsHeld held,
                       const std::string& about)
    : h5_(with_suffix(out, ".h5")), xdmf_(with_suffix(out, ".xdmf")), grid_(grid), held_(held) {
  file_ = h5::create_file(temporary_name(h5_));
  h5::set_attribute(file_, "subsoil fields", std::int64_t{1});
  h5::set_attribute(file_, "coarse graining", about);
  h5::create_group(file_, "/frames");
  const double low[3] = {grid.low.x, grid.low.y, grid.low.z};
  h5::write(file_, "/low", std::span<const double>(low, 3));
  const double spacing[3] = {grid.spacing.x, grid.spacing.y, grid.spacing.z};
  h5::write(file_, "/spacing", std::span<const double>(spacing, 3));
  text_ =
      "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n <Domain>\n"
      " <Grid Name=\"fields\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
}

void FieldsFile::put(const std::string& name, const std::string& unit, const char* kind, std::size_t columns,
                     const double* data) {
  const std::string path = group_ + "/" + name;
  const hsize_t shape[4] = {grid_.n[2], grid_.n[1], grid_.n[0], columns};
  const int rank = columns > 1 ? 4 : 3;
  const h5::Handle space(H5Screate_simple(rank, shape, nullptr), H5Sclose, "shaping " + path);
  const h5::Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "preparing " + path);
  h5::checked(H5Pset_obj_track_times(properties, false), "preparing " + path);
  const hsize_t chunk[4] = {1, shape[1], shape[2], columns};
  h5::checked(H5Pset_chunk(properties, rank, chunk), "choosing chunks of " + path);
  h5::checked(H5Pset_shuffle(properties), "choosing byte shuffle");
  h5::checked(H5Pset_deflate(properties, 1), "choosing gzip");
  const h5::Handle set(H5Dcreate2(file_, path.c_str(), H5T_IEEE_F32LE, space, H5P_DEFAULT, properties, H5P_DEFAULT),
                       H5Dclose, "creating " + path);
  h5::checked(H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), "writing " + path);
  if (!unit.empty()) h5::set_attribute(set, "unit", unit);
  const std::string dimensions = fmt::format("{} {} {}", shape[0], shape[1], shape[2]);
  text_ += fmt::format(
      "   <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\"><DataItem Format=\"HDF\" NumberType=\"Float\" "
      "Precision=\"4\" Dimensions=\"{}{}\">{}:{}</DataItem></Attribute>\n",
      name, kind, dimensions, columns > 1 ? fmt::format(" {}", columns) : "", h5_.filename().string(), path);
}

void FieldsFile::add(double time, const GrainFields& f) {
  group_ = fmt::format("/frames/{:06}", count_);
  const h5::Handle place = h5::create_group(file_, group_);
  h5::set_attribute(place, "time", time);
  text_ += fmt::format(
      "  <Grid Name=\"frame {}\" GridType=\"Uniform\">\n   <Time Value=\"{:.12g}\"/>\n"
      "   <Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"{} {} {}\"/>\n"
      "   <Geometry GeometryType=\"ORIGIN_DXDYDZ\">"
      "<DataItem Format=\"XML\" NumberType=\"Float\" Precision=\"8\" Dimensions=\"3\">{:.12g} {:.12g} "
      "{:.12g}</DataItem>"
      "<DataItem Format=\"XML\" NumberType=\"Float\" Precision=\"8\" Dimensions=\"3\">{:.12g} {:.12g} "
      "{:.12g}</DataItem>"
      "</Geometry>\n",
      count_++, time, grid_.n[2], grid_.n[1], grid_.n[0], grid_.low.z, grid_.low.y, grid_.low.x, grid_.spacing.z,
      grid_.spacing.y, grid_.spacing.x);
  std::vector<double> porosity(f.solid_fraction.size());
  for (std::size_t i = 0; i < porosity.size(); ++i) porosity[i] = 1 - f.solid_fraction[i];
  put("bulk density", "kg/m^3", "Scalar", 1, f.density.data());
  put("porosity", "1", "Scalar", 1, porosity.data());
  if (held_.contacts) put("coordination", "1", "Scalar", 1, f.coordination.data());
  if (held_.velocity) {
    put("velocity", "m/s", "Vector", 3, &f.velocity.front().x);
    put("kinetic stress", "Pa", "Tensor", 9, f.kinetic_stress.front().data());
  }
  if (held_.stress) put("contact stress", "Pa", "Tensor", 9, f.contact_stress.front().data());
  if (held_.stress && held_.velocity) put("pressure", "Pa", "Scalar", 1, pressure(f).data());
  text_ += "  </Grid>\n";
  h5::status_of(file_)->check();
}

std::filesystem::path FieldsFile::finish() {
  h5::close_file(file_);
  put_in_place(h5_);
  write_atomically(xdmf_, text_ + " </Grid>\n </Domain>\n</Xdmf>\n");
  std::filesystem::path plain = xdmf_;
  plain += "2";
  write_atomically(plain, xdmf_leading_to(xdmf_.filename().string()));
  return plain;
}

}  // namespace subsoil::sim
