#include "apps/commands/commands.hpp"
#include "libdem/memory.hpp"

int main(int argc, char** argv) {
  subsoil::dem::return_large_arrays();
  return subsoil::app::main_command(argc, argv);
}
