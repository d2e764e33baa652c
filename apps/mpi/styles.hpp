#pragma once
#include <cstdint>
#include <vector>

#include "libdem/contacts/surface_contacts.hpp"

// Headers of LIGGGHTS, in an order in which they compile.
#include <fix.h>
#include <lammps.h>
#include <pair.h>

/// What LIGGGHTS is extended by.
namespace subsoil::mpi {

/// Who answers when LIGGGHTS comes to a task of its step.
class Tasks {
 public:
  virtual ~Tasks() = default;
  virtual void leave_lists() = 0;  ///< before spheres change process
  virtual void forces() = 0;       ///< spheres and ghosts stand at t_n
  virtual void motion() = 0;
  virtual double reach() const = 0;            ///< of a pair: maximum distance of centres at which it may touch, m
  virtual double distance_factor() const = 0;  ///< by which radii are multiplied for what acts across gaps
};

/// Half lists by size, each pair of one process once and across a border once on either side; forces are the tasks'.
class PairSubsoil final : public LAMMPS_NS::Pair {
 public:
  explicit PairSubsoil(LAMMPS_NS::LAMMPS* lmp) : Pair(lmp) {}
  ~PairSubsoil() override;
  PairSubsoil(const PairSubsoil&) = delete;
  PairSubsoil& operator=(const PairSubsoil&) = delete;

  void settings(int count, char** words) override;
  void coeff(int, char**) override {}
  void init_style() override;
  double init_one(int, int) override { return tasks->reach(); }
  void compute(int, int) override { tasks->forces(); }

  Tasks* tasks = nullptr;
};

/// What contacts of one sphere remember, while there are no lists.
struct Remembered {
  struct Pair {
    std::uint32_t with;  ///< id of the other sphere
    dem::PairState state;
  };
  struct Surface {
    std::uint32_t boundary;
    dem::Vec3 normal;  ///< shape axes
    dem::PairState state;
  };
  std::vector<Pair> pairs;
  std::vector<Surface> surfaces;
};

/// The move of a step, and what goes with a sphere to its next process.
class FixSubsoil final : public LAMMPS_NS::Fix {
 public:
  FixSubsoil(LAMMPS_NS::LAMMPS* lmp, int count, char** words);
  ~FixSubsoil() override;
  FixSubsoil(const FixSubsoil&) = delete;
  FixSubsoil& operator=(const FixSubsoil&) = delete;

  int setmask() override;
  void pre_exchange() override { tasks->leave_lists(); }
  void final_integrate() override { tasks->motion(); }
  void grow_arrays(int count) override;
  void copy_arrays(int from, int to, int) override;
  int pack_exchange(int index, double* to) override;
  int unpack_exchange(int index, double* from) override;

  /// Room for what any sphere takes along, the same on all processes. Collective.
  void reserve_exchange();
  void build_at(std::int64_t step) { next_reneighbor = step; }  ///< the lists, in a step to come

  std::vector<Remembered> remembered;  ///< by index of LIGGGHTS' atoms
  Tasks* tasks = nullptr;
};

/// Give both to a LIGGGHTS that has a box, whose they are.
PairSubsoil& use_pair_style(LAMMPS_NS::LAMMPS& lmp, Tasks& tasks);
FixSubsoil& use_fix(LAMMPS_NS::LAMMPS& lmp, Tasks& tasks);

}  // namespace subsoil::mpi
