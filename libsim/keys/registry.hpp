#pragma once
#include <string>
#include <vector>

#include "libsim/keys/members.hpp"

/// Keys that scenarios may hold but runs do not use, and files of other commands that are read by the same rules. The
/// lists stand in libsim/studies/sections.cpp: this room knows no command.
namespace subsoil::sim {

/// A section that a command reads; a run checks its keys and leaves it.
struct CommandSection {
  std::string key, meaning;
  Declare declare;  ///< a prototype
};
/// Adds the sections' keys to a visitor; each is read only where it stands.
void declare_command_sections(Fields& fields);

/// A file of its own, for the reference.
struct CommandFile {
  std::string command, heading, introduction;
  Declare declare;  ///< a prototype
};

const std::vector<CommandSection>& command_sections();
const std::vector<CommandFile>& command_files();

}  // namespace subsoil::sim
