#pragma once
#include <vector>

#include "libdem/laws/laws.hpp"
#include "libdem/particles.hpp"

/// Contacts on their way through a law, up to 32 at a time, 2, 4 or 8 of them per instruction.
///
/// A lane is pointers only: the kernel reads whole records and transposes them in registers. Copying each number to an
/// array of its own first (31 stores and as many loads per contact) lost by a factor of two.
namespace subsoil::dem {

/// Spring and dashpot memory of one contact, 80 bytes. Springs steer the motion and are double; what the dashpots
/// pulled at the last step only feeds the energy book, where float's 1e-7 is far below its error.
struct PairState {
  double xi[3] = {};   ///< tangential spring, m, world axes, on the owner
  double rho[3] = {};  ///< rolling spring, rad
  float dash_n = 0;    ///< normal damping force, N
  float dash_t[3] = {};
  float dash_r[3] = {};
  float slipping = 0;
};
static_assert(sizeof(PairState) == 80);

/// Four doubles that are added together; two SSE2 or one AVX addition.
using Four = double __attribute__((vector_size(32)));

/// What a contact does, 128 bytes, in the grouping in which it is added up.
struct alignas(64) ContactForce {
  Four f;    ///< force on the owner, N; overlap over the smaller radius
  Four t_i;  ///< torque on the owner about its centre, N m; 1 when surfaces overlap
  Four t_j;  ///< torque on the other (of a surface: its rolling torque), N m; 1 when surfaces overlap
  Four e;    ///< J: lost in damping, sliding, rolling since the last step; stored
};

/// Energy that contacts lost, J.
struct Losses {
  double damping = 0;  ///< normal and tangential dashpots
  double sliding = 0;
  double rolling = 0;  ///< rolling spring at its limit and its dashpot

  Losses& operator+=(const Losses& b) {
    return damping += b.damping, sliding += b.sliding, rolling += b.rolling, *this;
  }
};

/// The laws of all pairs of materials, by index; `of(a, b)` is symmetric.
struct LawTable {
  int materials = 0;
  std::vector<int> index;  ///< materials x materials -> entry of laws, -1: none given
  std::vector<Law> laws;   ///< resolved() ones
  int of(int a, int b) const { return index[static_cast<std::size_t>(a * materials + b)]; }
};

struct Batch {
  static constexpr int lanes = 32;
  const Sphere* owner[lanes];
  /// The partner; of a surface a record made up for it: v and w the surface's at the contact point, r = -2 r_i and x
  /// as far behind the surface as |r| says, so that |x_i - x_j| stays positive for a centre behind the surface.
  const Sphere* other[lanes];
  PairState* state[lanes];  ///< in and out; all zero for a contact without history
  unsigned char law[lanes];
  ContactForce out[lanes];
};

/// Evaluates lanes [0, count) of the batch; `elapsed` is the time since the previous evaluation (0 at the first step).
using EvaluateFunction = void (*)(const LawTable&, Batch&, int count, double elapsed);

struct Kernel {
  const char* name;  ///< instruction set, for the record of a run
  EvaluateFunction evaluate;
};

/// The kernel by name ("portable", "avx2", "avx512"), or the best this machine has ("auto"). Throws
/// std::invalid_argument when the machine or the build lacks the set.
Kernel choose_kernel(const char* name);

}  // namespace subsoil::dem
