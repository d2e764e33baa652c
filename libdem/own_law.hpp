#pragma once
#if defined(SUBSOIL_ISA)
#error "libdem/own_law.hpp stands in a user's source, not in the library's kernels"
#endif
#define SUBSOIL_ISA portable
#include "libdem/kernel/law_kernel.hpp"
#include "libdem/kernel/plain_kernel_body.hpp"
#include "libdem/laws/contact_law_of.hpp"

/// A contact law of a user, compiled in the user's own source: after its struct, outside of any namespace,
///
///     SUBSOIL_CONTACT_LAW(mine::Law)
///
/// makes it a law that a Bed takes (`laws = {Law(law)}`), with the same kernels as the library's own. The struct has
/// the members that IsLaw asks for (laws/contact_law_of.hpp); laws/linear.hpp is the shortest to copy. Its kernels are
/// those of the portable instruction set, which work beside a bed of any other.
#define SUBSOIL_CONTACT_LAW(Type)         \
  namespace subsoil::dem::portable {      \
  template <>                             \
  const LawKernels& law_kernels<Type>() { \
    return kernels_of_plain_law<Type>();  \
  }                                       \
  }                                       \
  template std::shared_ptr<const subsoil::dem::ContactLaw> subsoil::dem::make_law(const Type&);
