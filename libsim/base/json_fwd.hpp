#pragma once
#include <nlohmann/json_fwd.hpp>

namespace subsoil::sim {

/// JSON as the program writes and reads it: keys in the order in which they were put in. Its members are in json.hpp.
using Json = nlohmann::ordered_json;

}  // namespace subsoil::sim
