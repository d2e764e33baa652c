// Debian's archives of HDF5, UDUNITS and yaml-cpp are compiled for programs: they reach these data of the C library by
// their distance from the code, which within a shared object holds for its own symbols only. Each has the C library's
// value once the object is loaded. The program's own libraries are position independent and need none of this.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stddef.h>

char __libc_single_threaded = 0;  // an importer may have threads: reference counts are atomic
void* stdin;
void* stdout;
void* stderr;

static void* value_of(const char* name) {
  void** const found = (void**)dlsym(RTLD_DEFAULT, name);
  return found != NULL ? *found : NULL;
}

// Before the constructors of the C++ library, which take the streams.
__attribute__((constructor(101))) static void take_host_data(void) {
  stdin = value_of("stdin");
  stdout = value_of("stdout");
  stderr = value_of("stderr");
}
