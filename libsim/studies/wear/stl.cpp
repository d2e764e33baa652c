#include "libsim/studies/wear/stl.hpp"

#include <fmt/format.h>

namespace subsoil::sim {

std::string stl_text(const dem::TriangleMesh& mesh, const std::string& name) {
  std::string text = fmt::format("solid {}\n", name);
  for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
    const dem::Vec3 n = mesh.normal(t);
    text += fmt::format("facet normal {} {} {}\nouter loop\n", n.x, n.y, n.z);
    for (int i = 0; i < 3; ++i) {
      const dem::Vec3& p = mesh.corner(t, i);
      text += fmt::format("vertex {} {} {}\n", p.x, p.y, p.z);
    }
    text += "endloop\nendfacet\n";
  }
  return text + fmt::format("endsolid {}\n", name);
}

}  // namespace subsoil::sim
