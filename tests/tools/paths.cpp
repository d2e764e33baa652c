#include "tests/tools/paths.hpp"

namespace subsoil::test {

std::string source_dir() { return SUBSOIL_SOURCE_DIR; }
std::string program() { return SUBSOIL_PROGRAM; }

}  // namespace subsoil::test
