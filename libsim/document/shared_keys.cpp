#include "libsim/document/shared_keys.hpp"

#include <exception>

namespace subsoil::sim {

Node written_scenario(const std::string& file, const std::vector<std::string>& sets) {
  Problems unheard;
  try {
    return read_document(file, sets, unheard);
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace subsoil::sim
