#pragma once
#include <cstddef>
#include <string>

namespace subsoil::sim {

/// What a file that is read may hold. Beyond these it is a mistake or hostile, and is refused before it costs more than
/// a second. `SUBSOIL_LIMITS=triangles=5000000,scenario-bytes=4000000` in the environment sets others, for this program
/// and for those that it starts.
struct InputLimits {
  std::size_t scenario_bytes = 1 << 20;  ///< of a scenario and all that it includes; the maximum of configs/ has 8 KiB
  std::size_t values = 100000;           ///< keys and values of a scenario, aliases written out
  std::size_t keys = 5000;               ///< of one mapping: names are looked up one by one
  std::size_t anchors = 1000;            ///< anchors and aliases
  std::size_t files = 100;               ///< of a scenario, included ones counted
  std::size_t depth = 60;                ///< mappings and lists within each other
  std::size_t name_bytes = 200;          ///< of a key or name: results hold them as names of columns, files and blocks
  std::size_t text_bytes = 20000;        ///< of one value
  std::size_t frames = 100000;           ///< of a run
  std::size_t rows = 100000000;          ///< of series.csv
  std::size_t steps = 10000000000;       ///< of a run, of the soil or the machine; at some 1 us each three hours
  std::size_t triangles = 1000000;       ///< of a mesh file
  std::size_t bed_rows = 100000000;      ///< of a bed table
  std::size_t array_bytes = std::size_t{16} << 30;  ///< of one array of an HDF5 file
  std::size_t read_seconds = 30;     ///< of processor time, for one read of an HDF5 file, beside 1 s per 50 MB of it
  std::size_t read_bytes = 1 << 30;  ///< of memory, for one read of an HDF5 file, beside 1032 times its size
};

/// The limits in force. Throws ScenarioError for a SUBSOIL_LIMITS that cannot be read, when asked for the first time.
const InputLimits& input_limits();

/// Reads `triangles=5e6,depth=100` over `limits`. Throws ScenarioError naming the part that cannot be read.
void read_limits(const std::string& text, InputLimits& limits);

/// "; SUBSOIL_LIMITS=triangles=N in the environment allows more"
std::string allow_more(const char* name);

}  // namespace subsoil::sim
