#pragma once
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <new>
#include <span>
#include <stdexcept>
#include <string>

#include "libsim/document/arithmetic.hpp"
#include "libsim/document/expression.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/io/bed_file.hpp"
#include "libsim/io/series.hpp"
#include "libsim/post/frames_file.hpp"
#include "libsim/run/restart.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/scenario/shapes/mesh_file.hpp"

/// Readers of foreign files, each as a function of the file's bytes: what libFuzzer (scripts/fuzz) drives and what the
/// tests replay. A reader may refuse with a message of its own; anything else (std::bad_alloc, a length or index that
/// the standard library objects to, a crash, more than some seconds) is a fault.
namespace subsoil::sim::fuzz {

/// A file of this process with these bytes; the same name again and again, in memory where the system has it.
inline std::string file_of(const std::string& bytes, const char* ending) {
  static const std::filesystem::path folder = [] {
    const std::filesystem::path shared = "/dev/shm";
    const auto base = std::filesystem::exists(shared) ? shared : std::filesystem::temp_directory_path();
    const auto mine = base / ("subsoil-fuzz-" + std::to_string(::getpid()));
    std::filesystem::create_directories(mine);
    return mine;
  }();
  const std::string name = (folder / (std::string("input") + ending)).string();
  std::ofstream(name, std::ios::binary) << bytes;
  return name;
}

/// Runs `read`; a refusal passes, a fault goes on to the caller.
template <class Read>
void refusing(Read read) {
  try {
    read();
  } catch (const std::out_of_range&) {
    throw;
  } catch (const std::length_error&) {
    throw;
  } catch (const std::runtime_error& refusal) {
    if (std::string(refusal.what()).empty()) throw std::logic_error("a refusal without words");
  } catch (const std::invalid_argument& refusal) {
    if (std::string(refusal.what()).empty()) throw std::logic_error("a refusal without words");
  }
}

inline void scenario(const std::string& text) {
  refusing([&] { load_scenario_text(text, "fuzzed.yaml"); });
}
inline void unit(const std::string& text) {
  refusing([&] { parse_quantity(text, "m"); });
  refusing([&] { parse_unit(text); });
}
inline void value(const std::string& text) {
  refusing([&] {
    if (is_arithmetic(text)) evaluate_arithmetic(text, {});
  });
}
inline void formula(const std::string& text) {
  refusing([&] {
    const auto function = make_expression(text, "1", 1);
    for (const double t : {0.0, 0.3, 1e6}) function.value(t);
  });
}
inline void mesh(const std::string& bytes) {
  for (const char* ending : {".stl", ".obj"})
    refusing([&] {
      const MeshFile file = load_mesh(file_of(bytes, ending), 1e-3);
      if (!std::isfinite(file.mesh.area())) throw std::logic_error("a mesh without a finite area was accepted");
    });
}
inline void bed(const std::string& bytes) {
  refusing([&] { load_bed(file_of(bytes, ".csv")); });
  refusing([&] { load_bed(file_of(bytes, ".h5")); });
}
inline void series(const std::string& bytes) {
  refusing([&] { read_series(file_of(bytes, ".csv")); });
}
inline void state(const std::string& bytes) {
  refusing([&] {
    const SavedRun saved = read_run(file_of(bytes, ".h5"));
    for (const dem::SphereSpec& s : spheres_of(saved))
      if (!std::isfinite(dem::norm(s.position)) || !(s.radius > 0)) throw std::logic_error("a bad sphere was accepted");
  });
}
inline void frames(const std::string& bytes) {
  refusing([&] {
    const FramesFile file(file_of(bytes, ".h5"));
    for (std::size_t k = 0; k < file.times().size(); ++k) file.spheres(k, true);
  });
}

struct Target {
  const char* name;
  void (*run)(const std::string&);
};
inline constexpr Target targets[] = {{"scenario", scenario}, {"unit", unit},   {"value", value},
                                     {"formula", formula},   {"mesh", mesh},   {"bed", bed},
                                     {"series", series},     {"state", state}, {"frames", frames}};

}  // namespace subsoil::sim::fuzz
