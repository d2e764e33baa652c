#include "apps/run/process.hpp"

#include <fstream>
#include <string>

namespace subsoil::app {

double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmHWM:", 0) == 0) return 1024 * std::stod(line.substr(6));
  return 0;
}

}  // namespace subsoil::app
