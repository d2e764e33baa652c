#include "apps/commands/version_text.hpp"

#include <H5public.h>
#include <fmt/format.h>
#include <omp.h>
#include <spdlog/version.h>
#include <sundials/sundials_config.h>

#include <CLI/Version.hpp>
#include <Eigen/Core>

#include "libdem/contacts/blocks.hpp"
#include "libsim/base/version.hpp"

namespace subsoil::sim {

std::string version_text() {
  return fmt::format(
      "subsoil {}\n"
      "build            {}, {} {}\n"
      "instruction set  {} (of this machine; --simd chooses another)\n"
      "OpenMP           {}\n"
      "Eigen            {}.{}.{}\n"
      "SUNDIALS         {}\n"
      "HDF5             {}\n"
      "CLI11            {}\n"
      "spdlog           {}.{}.{}\n"
      "fmt              {}.{}.{}",
      version(), SUBSOIL_BUILD_TYPE, SUBSOIL_COMPILER, __VERSION__, dem::choose_kernel("auto").name, _OPENMP,
      EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION, SUNDIALS_VERSION, H5_VERS_INFO, CLI11_VERSION,
      SPDLOG_VER_MAJOR, SPDLOG_VER_MINOR, SPDLOG_VER_PATCH, FMT_VERSION / 10000, FMT_VERSION / 100 % 100,
      FMT_VERSION % 100);
}

}  // namespace subsoil::sim
