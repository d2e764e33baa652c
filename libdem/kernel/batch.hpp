#pragma once
#include <vector>

#include "libdem/laws/laws.hpp"

/// Contacts on their way through a law, 32 at a time, transposed so that a law runs 2, 4 or 8 of them per instruction.
/// 32 lanes of 51 numbers are 13 kB: they stay in the first-level cache; 64 lanes lost by spilling it.
namespace subsoil::dem {

/// Spring and dashpot memory of one contact, 80 bytes. Springs steer the motion and are double; what the dashpots pulled
/// at the last step only feeds the energy book, where float's 1e-7 is far below its error.
struct PairState {
  double xi[3] = {};   ///< tangential spring, m, world axes, on the owner
  double rho[3] = {};  ///< rolling spring, rad
  float dash_n = 0;    ///< normal damping force, N
  float dash_t[3] = {};
  float dash_r[3] = {};
  float slipping = 0;
};

/// Energy that contacts lose in one step, J.
struct Losses {
  double damping = 0;  ///< normal and tangential dashpots
  double sliding = 0;
  double rolling = 0;  ///< rolling spring at its limit and its dashpot

  Losses& operator+=(const Losses& b) { return damping += b.damping, sliding += b.sliding, rolling += b.rolling, *this; }
};

/// The laws of all pairs of materials, by index; `of(a, b)` is symmetric.
struct LawTable {
  int materials = 0;
  std::vector<int> index;      ///< materials x materials -> entry of laws, -1: none given
  std::vector<Law> laws;  ///< resolved() ones
  int of(int a, int b) const { return index[static_cast<std::size_t>(a * materials + b)]; }
};

struct Batch {
  static constexpr int lanes = 32;
  using Lane = double[lanes];
  using FloatLane = float[lanes];

  // in: surface point or partner at (x, y, z) from the centre of the owner's sphere, all "owner minus partner"
  alignas(64) Lane r[3];          ///< x_i - x_j, m
  alignas(64) Lane v[3];          ///< v_i - v_j, m/s
  alignas(64) Lane w_i[3], w_j[3];  ///< spins, rad/s
  alignas(64) Lane r_i, r_j;      ///< radii, m; r_j = 0 for a surface
  alignas(64) Lane m_i, m_j;      ///< masses, kg; m_j is not read for a surface
  alignas(64) Lane law;           ///< index of the law
  alignas(64) Lane xi[3], rho[3];                                      // PairState, in and out
  alignas(64) FloatLane dash_n, dash_t[3], dash_r[3], slipping;  // its float part
  // out
  alignas(64) Lane f[3];              ///< force on the owner, N
  alignas(64) Lane t_i[3], t_j[3];    ///< torques about the centres, N m (t_j of a surface: its rolling torque)
  alignas(64) Lane overlap;           ///< m
  alignas(64) Lane damping, sliding, rolling;  ///< J lost since the last step
  alignas(64) Lane stored;            ///< J

  void load(int lane, const PairState& s) {
    for (int d = 0; d < 3; ++d) {
      xi[d][lane] = s.xi[d];
      rho[d][lane] = s.rho[d];
      dash_t[d][lane] = s.dash_t[d];
      dash_r[d][lane] = s.dash_r[d];
    }
    dash_n[lane] = s.dash_n;
    slipping[lane] = s.slipping;
  }
  void store(int lane, PairState& s) const {
    for (int d = 0; d < 3; ++d) {
      s.xi[d] = xi[d][lane];
      s.rho[d] = rho[d][lane];
      s.dash_t[d] = dash_t[d][lane];
      s.dash_r[d] = dash_r[d][lane];
    }
    s.dash_n = dash_n[lane];
    s.slipping = slipping[lane];
  }
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
