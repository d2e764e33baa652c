#pragma once
#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace subsoil::sim {

/// Gives arrays above 4 MB back to the system as soon as they are freed, and keeps smaller ones for the next; for the
/// start of a program. The lists of a bed are rebuilt hundreds of times with sizes that differ a little. The C
/// library, which raises that limit by itself, would leave holes between them: a fifth more memory for 130,000 spheres
/// under a plough. With a limit of 128 KiB, and with what is free at the end of the heap given back at once, the system
/// hands out the same pages again and again: on a virtual machine, where each costs up to 7 us, half of a rebuild's
/// time.
inline void recycle_arrays() {
#if defined(__GLIBC__)
  mallopt(M_MMAP_THRESHOLD, 4 << 20);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
}

}  // namespace subsoil::sim
