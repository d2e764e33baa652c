#include "libsim/fmu/model.hpp"

#include "libsim/base/json.hpp"

namespace subsoil::sim {

Json json_of(const FmuModel& model) {
  Json out;
  out["name"] = model.name, out["description"] = model.description, out["token"] = model.token;
  out["version"] = model.version;
  out["step"] = model.step, out["end"] = model.end;
  out["tools"] = model.tools, out["inputs"] = model.inputs, out["forces on"] = model.forces_on;
  Json list = Json::array();
  for (const FmuVariable& v : model.variables) {
    Json one;
    one["name"] = v.name, one["unit"] = v.unit, one["description"] = v.description;
    one["role"] = static_cast<int>(v.role), one["of"] = v.of, one["component"] = v.component, one["start"] = v.start;
    list.push_back(one);
  }
  out["variables"] = list;
  return out;
}

FmuModel fmu_model_of(const Json& json) {
  FmuModel out;
  out.name = json.at("name").get<std::string>(), out.description = json.at("description").get<std::string>();
  out.token = json.at("token").get<std::string>(), out.version = json.at("version").get<std::string>();
  out.step = json.at("step").get<double>(), out.end = json.at("end").get<double>();
  out.tools = json.at("tools").get<std::vector<std::string>>();
  out.inputs = json.at("inputs").get<std::vector<std::string>>();
  out.forces_on = json.at("forces on").get<std::vector<std::string>>();
  for (const Json& one : json.at("variables"))
    out.variables.push_back({.name = one.at("name").get<std::string>(),
                             .unit = one.at("unit").get<std::string>(),
                             .description = one.at("description").get<std::string>(),
                             .role = static_cast<FmuVariable::Role>(one.at("role").get<int>()),
                             .of = one.at("of").get<std::string>(),
                             .component = one.at("component").get<int>(),
                             .start = one.at("start").get<double>()});
  return out;
}

}  // namespace subsoil::sim
