#include "apps/commands/commands.hpp"

int main(int argc, char** argv) { return subsoil::app::main_command(argc, argv); }

#ifdef __SANITIZE_ADDRESS__
/// Not counted by the leak sanitizer: CLN, on which GiNaC stands, keeps 26 bytes from its static initialisation.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libcln\n"; }
#endif
