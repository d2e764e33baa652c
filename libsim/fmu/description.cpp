#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <map>
#include <set>

#include "libsim/base/markup.hpp"
#include "libsim/document/units.hpp"
#include "libsim/fmu/model.hpp"

namespace subsoil::sim {
namespace {

/// The units in use with their base units. FMI knows whole powers only; a unit beyond them has a name alone.
std::string units(const FmuModel& model) {
  std::set<std::string> names{"s"};
  for (const FmuVariable& v : model.variables)
    if (!v.unit.empty()) names.insert(v.unit);
  std::string out = "  <UnitDefinitions>\n";
  for (const std::string& name : names) {
    std::string base;
    bool whole = true;
    try {
      const Unit unit = parse_unit(name);
      for (const auto& [symbol, power] : unit.powers) {
        whole = whole && power == std::round(power) &&
                std::string(" kg m s A K mol cd rad ").find(" " + symbol + " ") != std::string::npos;
        base += fmt::format(" {}=\"{}\"", symbol, static_cast<int>(power));
      }
      if (unit.times / unit.over != 1) base += fmt::format(" factor=\"{}\"", unit.times / unit.over);
    } catch (const std::exception&) {
      whole = false;
    }
    out += fmt::format("    <Unit name=\"{}\">{}</Unit>\n", escaped_markup(name),
                       whole ? fmt::format("<BaseUnit{}/>", base) : "");
  }
  return out + "  </UnitDefinitions>\n";
}

std::string log_categories() {
  return "  <LogCategories>\n"
         "    <Category name=\"logAll\" description=\"what the program reports\"/>\n"
         "    <Category name=\"logStatusWarning\" description=\"warnings, as of `subsoil check` and `subsoil run`\"/>\n"
         "    <Category name=\"logStatusError\" description=\"why a call failed\"/>\n"
         "  </LogCategories>\n";
}

std::string experiment(const FmuModel& model) {
  return fmt::format("  <DefaultExperiment startTime=\"0\" stopTime=\"{}\" stepSize=\"{}\"/>\n", model.end, model.step);
}

const char* causality(const FmuVariable& v) {
  return v.is_input() ? "input" : v.is_parameter() ? "parameter" : v.is_output() ? "output" : "independent";
}

std::string common_attributes(const FmuVariable& v, std::size_t reference) {
  std::string out =
      fmt::format("name=\"{}\" valueReference=\"{}\" causality=\"{}\" variability=\"{}\"", escaped_markup(v.name),
                  reference, causality(v), v.is_parameter() ? "fixed" : "continuous");
  if (v.is_output()) out += " initial=\"calculated\"";
  if (v.is_parameter()) out += " initial=\"exact\"";
  if (!v.description.empty()) out += fmt::format(" description=\"{}\"", escaped_markup(v.description));
  return out;
}

std::string type_attributes(const FmuVariable& v) {
  std::string out;
  if (!v.unit.empty()) out += fmt::format(" unit=\"{}\"", escaped_markup(v.unit));
  if (v.is_input() || v.is_parameter()) out += fmt::format(" start=\"{}\"", v.start);
  return out;
}

std::string head(const FmuModel& model, const char* version, const char* token) {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<fmiModelDescription fmiVersion=\"{}\" modelName=\"{}\" {}=\"{}\" description=\"{}\" "
      "generationTool=\"subsoil {}\" generationDateAndTime=\"{:%Y-%m-%dT%H:%M:%SZ}\" "
      "variableNamingConvention=\"flat\"",
      version, escaped_markup(model.name), token, model.token, escaped_markup(model.description),
      escaped_markup(model.version), fmt::gmtime(std::time(nullptr)));
}

}  // namespace

std::string fmi2_description(const FmuModel& model) {
  std::string out = head(model, "2.0", "guid") + " numberOfEventIndicators=\"0\">\n";
  out += fmt::format(
      "  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" "
      "canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\"/>\n",
      fmu_identifier);
  out += units(model) + log_categories() + experiment(model) + "  <ModelVariables>\n";
  std::string outputs;
  for (std::size_t k = 0; k < model.variables.size(); ++k) {
    const FmuVariable& v = model.variables[k];
    out +=
        fmt::format("    <ScalarVariable {}><Real{}/></ScalarVariable>\n", common_attributes(v, k), type_attributes(v));
    if (v.is_output()) outputs += fmt::format("      <Unknown index=\"{}\"/>\n", k + 1);
  }
  out += "  </ModelVariables>\n  <ModelStructure>\n";
  if (!outputs.empty())
    out +=
        "    <Outputs>\n" + outputs + "    </Outputs>\n    <InitialUnknowns>\n" + outputs + "    </InitialUnknowns>\n";
  return out + "  </ModelStructure>\n</fmiModelDescription>\n";
}

std::string fmi3_description(const FmuModel& model) {
  std::string out = head(model, "3.0", "instantiationToken") + ">\n";
  out += fmt::format(
      "  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" "
      "canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\" providesIntermediateUpdate=\"true\" "
      "canReturnEarlyAfterIntermediateUpdate=\"true\"/>\n",
      fmu_identifier);
  out += units(model) + log_categories() + experiment(model) + "  <ModelVariables>\n";
  std::string structure;
  for (std::size_t k = 0; k < model.variables.size(); ++k) {
    const FmuVariable& v = model.variables[k];
    const bool update = v.role == FmuVariable::Role::tool_output;
    out += fmt::format("    <Float64 {}{}{}/>\n", common_attributes(v, k), type_attributes(v),
                       update ? " intermediateUpdate=\"true\"" : "");
    if (v.is_output()) structure += fmt::format("    <Output valueReference=\"{}\"/>\n", k);
  }
  for (std::size_t k = 0; k < model.variables.size(); ++k)
    if (model.variables[k].is_output()) structure += fmt::format("    <InitialUnknown valueReference=\"{}\"/>\n", k);
  return out + "  </ModelVariables>\n  <ModelStructure>\n" + structure +
         "  </ModelStructure>\n</fmiModelDescription>\n";
}

std::string fmi3_terminals(const FmuModel& model) {
  std::map<std::string, std::string> members;
  for (const FmuVariable& v : model.variables) {
    const bool tool = v.role == FmuVariable::Role::tool_input || v.role == FmuVariable::Role::tool_output;
    if (!tool && v.role != FmuVariable::Role::body) continue;
    const std::string member = v.name.substr(v.name.find(v.of) + v.of.size() + 1);
    members[(tool ? "tool " : "body ") + v.of] +=
        fmt::format("      <TerminalMemberVariable variableName=\"{}\" memberName=\"{}\" variableKind=\"signal\"/>\n",
                    escaped_markup(v.name), escaped_markup(member));
  }
  std::string out =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n"
      "  <GraphicalRepresentation>\n"
      "    <CoordinateSystem x1=\"-100\" y1=\"-100\" x2=\"100\" y2=\"100\" suggestedScalingFactorTo_mm=\"0.1\"/>\n"
      "    <Icon x1=\"-100\" y1=\"-100\" x2=\"100\" y2=\"100\"/>\n"
      "  </GraphicalRepresentation>\n";
  if (!members.empty()) out += "  <Terminals>\n";
  for (const auto& [name, list] : members)
    out += fmt::format("    <Terminal name=\"{}\" matchingRule=\"bus\" description=\"{}\">\n{}    </Terminal>\n",
                       escaped_markup(name),
                       name[0] == 't' ? "motion of a tool in soil, and the wrench of the soil on it"
                                      : "pose and velocity of a body of the machine",
                       list);
  if (!members.empty()) out += "  </Terminals>\n";
  return out + "</fmiTerminalsAndIcons>\n";
}

}  // namespace subsoil::sim
