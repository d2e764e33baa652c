/// What the leak sanitizer shall not count: CLN, on which GiNaC stands, keeps 26 bytes from its static initialisation.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libcln\n"; }
