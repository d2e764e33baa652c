/// What the leak sanitizer shall not count, since it is lost inside of a library. CLN, on which GiNaC stands, keeps 26
/// bytes from its static initialisation. GiNaC loses the nodes of a derivative that it refuses by an exception (0^t: 72
/// bytes). HDF5 loses blocks of its free lists where it gives up a damaged file (56 bytes).
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libcln\nleak:libginac\nleak:H5FL_\n"; }
