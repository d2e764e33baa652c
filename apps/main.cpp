#include "apps/commands/commands.hpp"
#include "apps/memory.hpp"

int main(int argc, char** argv) {
  subsoil::app::recycle_arrays();
  return subsoil::app::main_command(argc, argv);
}
