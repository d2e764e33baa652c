#include "bench/peer_files.hpp"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>

namespace subsoil::bench {
namespace {

using dem::Vec3;

class File {
 public:
  File(const std::string& folder, const char* name)
      : path_(folder + "/" + name), file_(std::fopen(path_.c_str(), "w"), &std::fclose) {
    if (!file_) throw std::runtime_error(path_ + ": cannot be written");
  }
  template <class... A>
  void print(const char* format, A... values) {
    if (std::fprintf(file_.get(), format, values...) < 0) throw std::runtime_error(path_ + ": the disk is full");
  }
  void variable(const char* name, double value) { print("variable %s equal %.17g\n", name, value); }

 private:
  std::string path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

void write_spheres(const std::string& folder, const Case& c, const dem::Bed& bed) {
  File out(folder, "bed.data");
  double top = 0;
  for (const dem::Sphere& s : bed.spheres()) top = std::max(top, s.x.y + s.r);
  // A little beyond the walls: an atom on the very border of a box without periodicity is lost.
  const double beyond = kRadius;
  out.print("spheres of a bed\n\n%zu atoms\n2 atom types\n\n", bed.spheres().size());
  out.print("%.17g %.17g xlo xhi\n", -beyond, c.length + beyond);
  out.print("%.17g %.17g ylo yhi\n", -beyond, top + 10 * kRadius);
  out.print("%.17g %.17g zlo zhi\n\nAtoms\n\n", -beyond, c.width + beyond);
  for (const dem::Sphere& s : bed.spheres())
    out.print("%u 1 %.17g %.17g %.17g %.17g %.17g\n", s.id + 1, 2 * s.r, dem::density(s), s.x.x, s.x.y, s.x.z);
  out.print("\nVelocities\n\n");
  for (const dem::Sphere& s : bed.spheres())
    out.print("%u %.17g %.17g %.17g %.17g %.17g %.17g\n", s.id + 1, s.v.x, s.v.y, s.v.z, s.w.x, s.w.y, s.w.z);
}

void write_tool(const std::string& folder, const Tool& tool) {
  File out(folder, "tool.stl");
  out.print("solid tool\n");
  for (std::size_t t = 0; t < tool.mesh.triangles().size(); ++t) {
    const Vec3 n = tool.mesh.normal(t);
    out.print("facet normal %.9g %.9g %.9g\nouter loop\n", n.x, n.y, n.z);
    for (int i = 0; i < 3; ++i) {
      const Vec3 p = tool.centre + tool.mesh.corner(t, i);
      out.print("vertex %.9g %.9g %.9g\n", p.x, p.y, p.z);
    }
    out.print("endloop\nendfacet\n");
  }
  out.print("endsolid tool\n");
}

/// Stiffness (N/m) and damping per effective mass (1/s) along and across, as both programs take them, of spheres of one
/// mass; `m_eff` half of it between spheres, all of it at a wall.
void write_contact(File& out, const std::string& prefix, const dem::Law& law, double m_eff) {
  const dem::StiffnessBound b = law->bound({.m_eff = m_eff, .r_eff = kRadius / 2, .r_min = kRadius, .speed = 0});
  const auto named = [&](const char* name, double value) { out.variable((prefix + name).c_str(), value); };
  named("kn", b.k_n), named("kt", b.k_t), named("gn", b.c_n / m_eff), named("gt", b.c_t / m_eff);
}

/// Rolling resistance as forces on the rolling displacement r_eff theta: k_r = k r_eff^2, c_r = c r_eff^2.
void write_rolling(File& out, const std::string& prefix, const dem::Friction& f, double k_n, double m, bool at_wall) {
  const double m_eff = at_wall ? m : m / 2, r_eff = at_wall ? kRadius : kRadius / 2;
  const double i_roll = 1.4 * m_eff * kRadius * kRadius;
  dem::StiffnessBound b{.k_n = k_n};
  f.bound(b, m_eff, r_eff, i_roll);
  out.variable((prefix + "kroll").c_str(), b.k_r / (r_eff * r_eff));
  out.variable((prefix + "groll").c_str(), b.c_r / (r_eff * r_eff));
}

}  // namespace

void write_peer_files(const std::string& folder, const Case& c, const dem::Bed& bed) {
  const std::string name = c.laws.laws[0]->name();
  if (name == "hertz-mindlin" || name != c.laws.laws[1]->name())
    throw std::invalid_argument("files for other programs: of laws linear, rolling and cohesive only");
  std::filesystem::create_directories(folder);
  write_spheres(folder, c, bed);
  if (c.has_tool) write_tool(folder, c.tool);
  File out(folder, "case.in");
  const double m = kDensity * dem::sphere_volume(kRadius);
  const dem::Friction& f = c.laws.laws[0]->friction();
  out.variable("step", c.step);
  out.variable("length", c.length), out.variable("width", c.width);
  out.variable("mu", f.mu), out.variable("mur", f.mu_r);
  for (const bool wall : {false, true}) {
    const dem::Law& law = c.laws.laws[wall];
    const double m_eff = wall ? m : m / 2;
    const std::string prefix = wall ? "w" : "";
    write_contact(out, prefix, law, m_eff);
    const double k_n = law->bound({.m_eff = m_eff, .r_eff = 1, .r_min = 1, .speed = 0}).k_n;
    write_rolling(out, prefix, f, k_n, m, wall);
  }
  out.variable("tool", c.has_tool);
  if (!c.has_tool) return;
  const Vec3 low = c.tool.centre - 0.5 * c.tool.size, high = c.tool.centre + 0.5 * c.tool.size;
  out.variable("x0", low.x), out.variable("x1", high.x);
  out.variable("y0", low.y), out.variable("y1", high.y);
  out.variable("z0", low.z), out.variable("z1", high.z);
  out.variable("speed", c.tool.velocity.x);
}

}  // namespace subsoil::bench
