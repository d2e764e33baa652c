#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "libdem/geometry/mesh_builders.hpp"
#include "libsim/scenario/shapes/mesh.hpp"
#include "libsim/scenario/shapes/mesh_file.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/scratch.hpp"

/// Mesh files: what is read is what was written, in double where the format holds it.
namespace subsoil::sim::mesh_files_test {
namespace {

using dem::TriangleMesh;
using subsoil::test::message_of;

/// A box that stands askew, so that no coordinate is a short number.
TriangleMesh askew() {
  const double angle = 0.7123456789;
  const dem::Pose pose{{0.11, -0.03, 0.27}, {std::cos(angle / 2), 0, std::sin(angle / 2), 0}};
  return dem::box_mesh({0.2, 0.05, 0.13}).placed(pose);
}

std::string text_stl(const TriangleMesh& mesh, const char* number) {
  std::string out = "solid box\n";
  char line[200];
  const std::string format = std::string("vertex ") + number + " " + number + " " + number + "\n";
  for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
    out += "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 3; ++k) {
      const Vec3& p = mesh.corner(t, k);
      std::snprintf(line, sizeof line, format.c_str(), p.x, p.y, p.z);
      out += line;
    }
    out += "endloop\nendfacet\n";
  }
  return out + "endsolid box\n";
}

std::string binary_stl(const TriangleMesh& mesh) {
  std::string out(80, ' ');
  const auto put = [&](auto value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(static_cast<std::uint32_t>(mesh.triangles().size()));
  for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
    for (int d = 0; d < 3; ++d) put(0.0F);
    for (int k = 0; k < 3; ++k)
      for (int d = 0; d < 3; ++d) put(static_cast<float>(mesh.corner(t, k)[d]));
    put(std::uint16_t{0});
  }
  return out;
}

std::string obj(const TriangleMesh& mesh) {
  std::string out = "# a box\no box\n";
  char line[200];
  for (const Vec3& p : mesh.vertices()) {
    std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", p.x, p.y, p.z);
    out += line;
  }
  for (const auto& t : mesh.triangles())
    out += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
  return out;
}

std::string ply(const TriangleMesh& mesh, bool binary) {
  std::string out = std::string("ply\nformat ") + (binary ? "binary_little_endian" : "ascii") +
                    " 1.0\nelement vertex " + std::to_string(mesh.vertices().size()) +
                    "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                    std::to_string(mesh.triangles().size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](auto value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
  char line[200];
  for (const Vec3& p : mesh.vertices()) {
    std::snprintf(line, sizeof line, "%.17g %.17g %.17g\n", p.x, p.y, p.z);
    if (binary)
      put(p.x), put(p.y), put(p.z);
    else
      out += line;
  }
  for (const auto& t : mesh.triangles()) {
    if (binary) {
      put(std::uint8_t{3});
      for (const std::uint32_t k : t) put(static_cast<std::int32_t>(k));
    } else {
      out += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
    }
  }
  return out;
}

class MeshFiles : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    std::ofstream((scratch_ / name).string(), std::ios::binary) << text;
    return (scratch_ / name).string();
  }
  test::Scratch scratch_;
};

/// Largest distance of corresponding corners.
double apart(const TriangleMesh& a, const TriangleMesh& b) {
  EXPECT_EQ(a.triangles().size(), b.triangles().size());
  double most = 0;
  for (std::size_t t = 0; t < a.triangles().size(); ++t)
    for (int k = 0; k < 3; ++k) most = std::max(most, norm(a.corner(t, k) - b.corner(t, k)));
  return most;
}

TEST_F(MeshFiles, TextIsReadInDouble) {
  const TriangleMesh box = askew();
  for (const std::string& file :
       {write("a.stl", text_stl(box, "%.17g")), write("a.obj", obj(box)), write("text.ply", ply(box, false)),
        write("binary.ply", ply(box, true)), write("named-otherwise.dat", ply(box, true))}) {
    const TriangleMesh read = read_mesh(file, 1);
    EXPECT_EQ(apart(read, box), 0) << file;
    EXPECT_EQ(read.vertices().size(), 8U) << file;
    EXPECT_TRUE(read.closed()) << file;
    EXPECT_NEAR(read.volume(), 0.2 * 0.05 * 0.13, 1e-17) << file;
  }
}

/// Words of STL are of either case, and a line of OBJ may go on after a backslash.
TEST_F(MeshFiles, TextIsReadInEveryWritingOfItsFormat) {
  const TriangleMesh box = askew();
  std::string upper = text_stl(box, "%.17g"), broken = "# C:\\\n" + obj(box), windows = broken;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  const auto replace_all = [](std::string& text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
      text.replace(at, from.size(), to);
  };
  replace_all(broken, " -", " \\\n-"), replace_all(broken, " 0.", " \\\n0.");
  replace_all(windows, "\n", "\r\n"), replace_all(windows, " 0.", "\\\r\n  0.");
  for (const std::string& file : {write("upper.stl", upper), write("blank.stl", "\n " + upper),
                                  write("broken.obj", broken), write("windows.obj", windows)}) {
    EXPECT_EQ(apart(read_mesh(file, 1), box), 0) << file;
    EXPECT_TRUE(read_mesh(file, 1).closed()) << file;
  }
  const std::string cut = upper.substr(0, upper.find("ENDSOLID"));
  EXPECT_NE(message_of([&] { read_mesh(write("cut.stl", cut), 1); }).find("ends without `endsolid`"),
            std::string::npos);
}

/// Half the spacing of floats below 0.5, in each of three coordinates; and seven digits of a text.
TEST_F(MeshFiles, BinaryStlIsRoundedToFloat) {
  const TriangleMesh box = askew();
  const double error = apart(read_mesh(write("b.stl", binary_stl(box)), 1), box);
  EXPECT_LE(error, std::sqrt(3.0) * std::ldexp(1.0, -26));
  EXPECT_GT(error, std::ldexp(1.0, -28));
  EXPECT_LE(apart(read_mesh(write("seven.stl", text_stl(box, "%.7e")), 1), box), std::sqrt(3.0) * 0.5e-8);
}

/// Corners that differ by the rounding of the file are one vertex: the box stays closed.
TEST_F(MeshFiles, CornersWithinRoundingAreOneVertex) {
  const TriangleMesh box = askew();
  std::string text = text_stl(box, "%.17g");
  const std::size_t at = text.find("vertex ");
  text.replace(at + 7, text.find(' ', at + 7) - at - 7, [&] {
    char number[40];
    std::snprintf(number, sizeof number, "%.17g", box.corner(0, 0).x + 1e-8);
    return std::string(number);
  }());
  const TriangleMesh read = read_mesh(write("cracked.stl", text), 1);
  EXPECT_EQ(read.vertices().size(), 8U);
  EXPECT_TRUE(read.closed());
}

TEST_F(MeshFiles, FacesOfMoreCornersAreCut) {
  const std::string corners = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n";
  EXPECT_NEAR(read_mesh(write("quad.obj", corners + "f 1 2 3 4\n"), 1e-3).area(), 2e-6, 1e-20);
  EXPECT_NE(message_of([&] {
              read_mesh(write("bent.obj", "v 0 0 0\nv 2 0 0\nv 2 1 1\nv 0 1 0\nf 1 2 3 4\n"), 1);
            }).find("face 1 has 4 corners and is not flat and convex"),
            std::string::npos);
  EXPECT_NE(message_of([&] {
              read_mesh(write("dart.obj", "v 0 0 0\nv 2 0 0\nv 0.1 0.1 0\nv 0 2 0\nf 2 3 4 1\n"), 1);
            }).find("not flat and convex"),
            std::string::npos);
}

/// What editors and other programs add to a file changes no corner: a mark of byte order, tabs, names of solids that
/// are words of the format, lines that bound no solid, the older word for a face.
TEST_F(MeshFiles, WhatBesidesTrianglesStandsInAFileChangesNone) {
  const TriangleMesh box = askew();
  const std::string mark = "\xEF\xBB\xBF";
  std::string tabbed = text_stl(box, "%.17g"), named = tabbed, older = obj(box);
  tabbed.replace(0, 9, "solid\tbox\t1"), named.replace(0, 9, "solid facet solid");
  for (std::size_t at = 0; (at = older.find("\nf ", at)) != std::string::npos;) older.replace(at, 3, "\nfo ");
  for (const std::string& file :
       {write("mark.stl", mark + text_stl(box, "%.17g")), write("mark.obj", mark + obj(box)),
        write("mark.ply", mark + ply(box, false)), write("mark-binary.ply", mark + ply(box, true)),
        write("tab.stl", tabbed), write("named.stl", named), write("older.obj", older),
        write("lines.obj", obj(box) + "l 1 2\nl 2 3 \\\n4 5\np 1\n")}) {
    EXPECT_EQ(apart(read_mesh(file, 1), box), 0) << file;
    EXPECT_TRUE(read_mesh(file, 1).closed()) << file;
  }
}

/// A corner that is no number was taken for whichever corner the reader's map found beside it.
TEST_F(MeshFiles, ACornerThatIsNoNumberIsRefused) {
  std::string bytes = binary_stl(askew());
  const float none = std::nanf("");
  std::memcpy(bytes.data() + 84 + 50 * 3 + 12 + 12, &none, sizeof none);
  const std::string said = message_of([&] { read_mesh(write("nan.stl", bytes), 1); });
  EXPECT_NE(said.find("triangle 4 has its corner 2 at (nan, "), std::string::npos) << said;
}

/// Below the smallest float of full precision, and below the smallest double: lengths that are zero.
TEST_F(MeshFiles, ACoordinateBelowAnyLengthIsZero) {
  for (const char* tiny : {"1e-43", "1e-400"}) {
    const std::string v = std::string("v ") + tiny + " 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    EXPECT_NEAR(read_mesh(write("tiny.obj", v), 1).area(), 0.5, 1e-15) << tiny;
    const std::string text = std::string("solid x\nfacet normal 0 0 1\nouter loop\nvertex ") + tiny +
                             " 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid x\n";
    EXPECT_NEAR(read_mesh(write("tiny.stl", text), 1).area(), 0.5, 1e-15) << tiny;
    const std::string list = std::string(
                                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                 "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                                 "end_header\n") +
                             tiny + " 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    EXPECT_NEAR(read_mesh(write("tiny.ply", list), 1).area(), 0.5, 1e-15) << tiny;
  }
}

TEST_F(MeshFiles, WhatAFileIsIsNamed) {
  const auto named = [&](const std::string& name, const std::string& text, const std::string& why) {
    const std::string message = message_of([&] { read_mesh(write(name, text), 1); });
    EXPECT_NE(message.find(why), std::string::npos) << name << ": " << message;
  };
  const TriangleMesh box = askew();
  named("a.stl", "ISO-10303-21;\nHEADER;\n", "is a STEP file, which holds curved faces; export the surface as STL");
  named("b.stl", "\x1f\x8b\x08 packed", "is compressed by gzip; unpack it first");
  named("c.stl", std::string("PK\x03\x04") + "packed", "is a ZIP archive");
  named("d.obj", std::string("\xff\xfe") + std::string("v\0 \0", 4), "is text in UTF-16");
  std::string commas = text_stl(box, "%.17g"), points = obj(box), rows = ply(box, false);
  for (std::string* text : {&commas, &points, &rows})
    for (std::size_t at = 0; (at = text->find("0.", at)) != std::string::npos;) (*text)[at + 1] = ',';
  named("commas.stl", commas, "line 4, `vertex ");
  named("commas.obj", points, "has decimal commas; export it with decimal points");
  named("commas.ply", rows, "has decimal commas; export it with decimal points");
  named("strips.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "holds its triangles as strips (element `tristrips`), which are not read; export it with faces");
  named("curved.obj", obj(box) + "surf 0 1 0 1 1 2 3 4\n", "`surf` is of a curved surface");
}

TEST_F(MeshFiles, BadFilesAreRefused) {
  const auto refused = [&](const std::string& name, const std::string& text, const std::string& why) {
    const std::string message = message_of([&] { read_mesh(write(name, text), 1); });
    EXPECT_NE(message.find(why), std::string::npos) << name << ": " << message;
  };
  const TriangleMesh box = askew();
  refused("hello.stl", "hello", "no STL file that can be read");
  refused("empty.stl", "", "no STL file that can be read");
  refused("cut.stl", binary_stl(box).substr(0, 300), "is cut off");
  refused("word.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 abc\n", "is cut off");
  refused("index.obj", "v 0 0 0\nv 1 0 0\nf 1 2 9\n", "that can be read");
  refused("index.ply",
          "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
          "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n",
          "names vertex 8 of 3");
  refused("cut.ply", ply(box, true).substr(0, 300), "is cut off: its header and lists ask for more");
  const std::string list =
      "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uint uint vertex_indices\nend_header\n";
  refused("list.ply", list + std::string("\xff\xff\xff\x7f", 4) + std::string(12, '\0'), "is cut off");
  EXPECT_NE(message_of([&] { read_mesh("/nowhere.stl", 1); }).find("no such file"), std::string::npos);
}

/// Every triangle of a box twice is the box; both sides of each triangle are another mesh.
TEST_F(MeshFiles, ATriangleThatStandsTwiceCountsOnce) {
  const TriangleMesh box = askew();
  const std::string once = text_stl(box, "%.17g"), again = once.substr(once.find('\n') + 1);
  std::string twice = once.substr(0, once.rfind("endsolid")) + again;
  const MeshFile read = load_mesh(write("twice.stl", twice), 1);
  EXPECT_EQ(read.repeated, 12U);
  EXPECT_EQ(read.mesh.triangles().size(), 12U);
  EXPECT_TRUE(read.mesh.closed());
  double area = 0;
  for (std::size_t t = 0; t < read.mesh.triangles().size(); ++t)
    area += 0.5 * norm(cross(read.mesh.corner(t, 1) - read.mesh.corner(t, 0),
                             read.mesh.corner(t, 2) - read.mesh.corner(t, 0)));
  const double of_box = 2 * (0.2 * 0.05 + 0.05 * 0.13 + 0.13 * 0.2);
  EXPECT_NEAR(area, of_box, 1e-12 * of_box);
  EXPECT_EQ(load_mesh(write("once.stl", once), 1).repeated, 0U);
  std::string sheet = "solid a\n";
  for (const char* corners : {"0 0 0|1 0 0|0 1 0", "0 0 0|0 1 0|1 0 0"}) {
    std::string vertices = std::string("vertex ") + corners;
    for (std::size_t i; (i = vertices.find('|')) != std::string::npos;) vertices.replace(i, 1, "\nvertex ");
    sheet += "facet normal 0 0 0\nouter loop\n" + vertices + "\nendloop\nendfacet\n";
  }
  EXPECT_EQ(load_mesh(write("sheet.stl", sheet + "endsolid a\n"), 1).repeated, 0U);
}

}  // namespace
}  // namespace subsoil::sim::mesh_files_test
