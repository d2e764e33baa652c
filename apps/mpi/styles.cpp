#include "apps/mpi/styles.hpp"

#include <atom.h>
#include <comm.h>
#include <force.h>
#include <input.h>
#include <memory.h>
#include <modify.h>
#include <neigh_request.h>
#include <neighbor.h>

#include <algorithm>
#include <cstring>
#include <string>

namespace subsoil::mpi {
namespace {

LAMMPS_NS::Pair* make_pair_style(LAMMPS_NS::LAMMPS* lmp) { return new PairSubsoil(lmp); }

/// Plain records as doubles, the units of LIGGGHTS' messages.
template <class T>
constexpr int doubles_of = static_cast<int>((sizeof(T) + sizeof(double) - 1) / sizeof(double));

template <class T>
int put(const T& value, double* to) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::memcpy(to, &value, sizeof value);
  return doubles_of<T>;
}
template <class T>
int take(T& value, const double* from) {
  std::memcpy(static_cast<void*>(&value), from, sizeof value);
  return doubles_of<T>;
}

}  // namespace

PairSubsoil::~PairSubsoil() {
  if (!allocated) return;
  memory->destroy(setflag);
  memory->destroy(cutsq);
}

void PairSubsoil::settings(int, char**) {
  const int types = atom->ntypes;
  allocated = 1;
  memory->create(setflag, types + 1, types + 1, "pair:setflag");
  memory->create(cutsq, types + 1, types + 1, "pair:cutsq");
  for (int a = 0; a <= types; ++a)
    for (int b = 0; b <= types; ++b) setflag[a][b] = 1, cutsq[a][b] = 0;
}

void PairSubsoil::init_style() {
  neighbor->register_contact_dist_factor(tasks->distance_factor());
  const int request = neighbor->request(this);
  neighbor->requests[request]->half = 0;
  neighbor->requests[request]->gran = 1;
}

FixSubsoil::FixSubsoil(LAMMPS_NS::LAMMPS* lmp_in, int count, char** words) : Fix(lmp_in, count, words) {
  force_reneighbor = 1, next_reneighbor = -1;
  time_integrate = 1;
  grow_arrays(atom->nmax);
  atom->add_callback(0);
}

FixSubsoil::~FixSubsoil() { atom->delete_callback(id, 0); }

int FixSubsoil::setmask() { return LAMMPS_NS::FixConst::PRE_EXCHANGE | LAMMPS_NS::FixConst::FINAL_INTEGRATE; }

void FixSubsoil::grow_arrays(int count) { remembered.resize(static_cast<std::size_t>(count)); }

void FixSubsoil::copy_arrays(int from, int to, int) {
  remembered[static_cast<std::size_t>(to)] = remembered[static_cast<std::size_t>(from)];
}

int FixSubsoil::pack_exchange(int index, double* to) {
  const Remembered& all = remembered[static_cast<std::size_t>(index)];
  int at = 0;
  to[at++] = static_cast<double>(all.pairs.size()), to[at++] = static_cast<double>(all.surfaces.size());
  for (const auto& p : all.pairs) at += put(p, to + at);
  for (const auto& s : all.surfaces) at += put(s, to + at);
  return at;
}

int FixSubsoil::unpack_exchange(int index, double* from) {
  Remembered& all = remembered[static_cast<std::size_t>(index)];
  int at = 2;
  all.pairs.resize(static_cast<std::size_t>(from[0])), all.surfaces.resize(static_cast<std::size_t>(from[1]));
  for (auto& p : all.pairs) at += take(p, from + at);
  for (auto& s : all.surfaces) at += take(s, from + at);
  return at;
}

void FixSubsoil::reserve_exchange() {
  int most = 2;
  for (std::size_t i = 0; i < static_cast<std::size_t>(atom->nlocal); ++i)
    most = std::max(most, 2 + static_cast<int>(remembered[i].pairs.size()) * doubles_of<Remembered::Pair> +
                              static_cast<int>(remembered[i].surfaces.size()) * doubles_of<Remembered::Surface>);
  MPI_Allreduce(&most, &comm->maxexchange_fix, 1, MPI_INT, MPI_MAX, world);
}

PairSubsoil& use_pair_style(LAMMPS_NS::LAMMPS& lmp, Tasks& tasks) {
  (*lmp.force->pair_map)["subsoil"] = &make_pair_style;
  lmp.input->one("pair_style subsoil");
  lmp.input->one("pair_coeff * *");
  auto& pair = dynamic_cast<PairSubsoil&>(*lmp.force->pair);
  pair.tasks = &tasks;
  return pair;
}

/// LIGGGHTS keeps its table of fixes to itself: ours takes the place of one that it has made.
FixSubsoil& use_fix(LAMMPS_NS::LAMMPS& lmp, Tasks& tasks) {
  lmp.input->one("fix subsoil all nve/sphere");
  LAMMPS_NS::Modify& modify = *lmp.modify;
  const int place = modify.find_fix("subsoil");  // the last
  delete modify.fix[place];
  modify.nfix = place;  // while it is made, what it asks to be told of goes to the next place
  std::string words[] = {"subsoil", "all", "subsoil"};
  char* arguments[] = {words[0].data(), words[1].data(), words[2].data()};
  auto* fix = new FixSubsoil(&lmp, 3, arguments);
  modify.fix[place] = fix, modify.fmask[place] = fix->setmask(), modify.nfix = place + 1;
  fix->tasks = &tasks;
  return *fix;
}

}  // namespace subsoil::mpi
