#pragma once
#include <optional>
#include <string>

#include "libmbd/system/beam.hpp"
#include "libsim/keys/fields.hpp"

/// Elastic beams of a machine. A beam stands for bodies (nodes), forces (elements), a measure of its name and, where it
/// has a material, surfaces. These follow what the user gives in the lists of the machine, so that whoever goes through
/// those knows no beams; the explicit copy of a scenario shows the beams alone.
namespace subsoil::sim {

struct BeamSection : mbd::Beam {
  std::string material;  // of its surface
  int first_node = 0;    // body index

  void describe(Fields& v);
  /// A number that it needs was not given, or not rightly.
  bool lacks_numbers() const;
};

struct MachineSection;
void add_beam_nodes(MachineSection& machine);
/// Elements, measures, surfaces.
void add_beam_elements(MachineSection& machine);
void take_beams_out(MachineSection& machine);
bool is_beam_node(const std::optional<MachineSection>& machine, const std::string& body);

}  // namespace subsoil::sim
