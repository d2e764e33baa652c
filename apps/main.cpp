#include "apps/commands/commands.hpp"

int main(int argc, char** argv) { return subsoil::app::main_command(argc, argv); }
