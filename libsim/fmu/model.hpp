#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "libsim/base/json_fwd.hpp"

/// What an FMU is: its variables and what stands behind each. One description serves FMI 2.0, FMI 3.0 and the library
/// that an importer loads.
namespace subsoil::sim {

/// A variable of type Float64 (Real). Its value reference is its place in the list; 0 is the time.
struct FmuVariable {
  enum class Role {
    time,
    tool_input,   ///< position, quaternion, velocity, angular velocity of a tool: component 0 ... 12
    tool_point,   ///< point of the wrench in the tool's axes: component 0 ... 2
    tool_output,  ///< force and moment on a tool: component 0 ... 5
    input,        ///< a function of time of the scenario, or a component of a force on a body
    parameter,    ///< a value of the scenario
    column,       ///< an output variable of the scenario
    body          ///< x, y, angle, vx, vy, omega of a body of the machine: component 0 ... 5
  };
  std::string name, unit, description;
  Role role = Role::time;
  std::string of;  ///< tool, input, key, column or body
  int component = 0;
  double start = 0;  ///< of inputs and parameters

  bool is_input() const { return role == Role::tool_input || role == Role::input; }
  bool is_parameter() const { return role == Role::tool_point || role == Role::parameter; }
  bool is_output() const { return role == Role::tool_output || role == Role::column || role == Role::body; }
};

struct FmuModel {
  std::string name, description, token, version;
  double step = 0;  ///< s, of communication, that is proposed
  double end = 0;   ///< s
  std::vector<std::string> tools, inputs, forces_on;
  std::vector<FmuVariable> variables;
};

Json json_of(const FmuModel& model);
/// Throws std::exception for a document that is none.
FmuModel fmu_model_of(const Json& json);

/// The text of modelDescription.xml, and of terminalsAndIcons.xml.
std::string fmi2_description(const FmuModel& model);
std::string fmi3_description(const FmuModel& model);
std::string fmi3_terminals(const FmuModel& model);

/// The name of the shared object in an FMU, without its ending.
inline constexpr const char* fmu_identifier = "subsoil";

}  // namespace subsoil::sim
