#include "apps/mpi/rank.hpp"

#include <atom.h>
#include <atom_vec.h>
#include <comm.h>
#include <domain.h>
#include <fmt/format.h>
#include <input.h>
#include <integrate.h>
#include <neigh_list.h>
#include <neighbor.h>
#include <update.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "libdem/particles/statistics.hpp"

namespace subsoil::mpi {
namespace {

std::size_t at(int index) { return static_cast<std::size_t>(index); }

/// LIGGGHTS without screen, log and files.
std::unique_ptr<LAMMPS_NS::LAMMPS> quiet_liggghts(MPI_Comm all) {
  std::vector<std::string> words{"liggghts", "-screen", "none", "-log", "none"};
  std::vector<char*> arguments;
  for (std::string& w : words) arguments.push_back(w.data());
  return std::make_unique<LAMMPS_NS::LAMMPS>(static_cast<int>(arguments.size()), arguments.data(), all);
}

}  // namespace

Rank::Rank(MPI_Comm all, const Beginning& beginning, dem::LawTable laws, std::vector<dem::Boundary> boundaries)
    : all_(all),
      beginning_(beginning),
      subdomain_(std::move(laws), std::move(boundaries),
                 {.gravity = beginning.gravity,
                  .simd = beginning_.simd,
                  .skin = beginning.skin,
                  .largest_radius = beginning.largest}),
      lmp_(quiet_liggghts(all)) {
  const auto say = [&](const std::string& line) { lmp_->input->one(line.c_str()); };
  const double margin = 2 * beginning.largest;
  say("units si");
  say("atom_style granular");
  say("boundary m m m");  // the box follows the spheres and holds all that are there now
  say("newton off");
  say("communicate single vel yes");
  say(fmt::format("region bed block {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} units box",
                  beginning.low.x - margin, beginning.high.x + margin, beginning.low.y - margin,
                  beginning.high.y + margin, beginning.low.z - margin, beginning.high.z + margin));
  say(fmt::format("create_box {} bed", subdomain_.laws().table().materials));
  say(fmt::format("neighbor {:.17g} bin", beginning.skin));
  say("neigh_modify delay 1000000000 every 1 check no");  // when lists are built, the subdomains decide
  pair_ = &use_pair_style(*lmp_, *this), fix_ = &use_fix(*lmp_, *this);
  say("thermo_modify lost ignore");  // those below the floor are counted by us
}

Rank::~Rank() = default;

double Rank::reach() const { return 2 * beginning_.largest * distance_factor(); }

double Rank::distance_factor() const { return 1 + subdomain_.laws().largest_cutoff() / (2 * beginning_.smallest); }

void Rank::take_spheres(std::span<const dem::Sphere> spheres) {
  LAMMPS_NS::Atom& atom = *lmp_->atom;
  const LAMMPS_NS::Domain& box = *lmp_->domain;
  for (const dem::Sphere& s : spheres) {
    bool here = true;
    for (int d = 0; d < 3; ++d) here = here && s.x[d] >= box.sublo[d] && s.x[d] < box.subhi[d];
    if (!here) continue;
    double x[3]{s.x.x, s.x.y, s.x.z};
    atom.avec->create_atom(s.material + 1, x);
    const int i = atom.nlocal - 1;
    for (int d = 0; d < 3; ++d) atom.v[i][d] = s.v[d], atom.omega[i][d] = s.w[d];
    atom.tag[i] = static_cast<int>(s.id) + 1;
    atom.radius[i] = s.r, atom.rmass[i] = s.m, atom.density[i] = dem::density(s);
    place_.push_back(std::int64_t{s.id} << 32 | i);
  }
  std::sort(place_.begin(), place_.end());
}

/// -1: it is another's.
int Rank::taken(std::int64_t id) const {
  const auto found = std::lower_bound(place_.begin(), place_.end(), id << 32);
  return found != place_.end() && *found >> 32 == id ? static_cast<int>(*found & 0xffffffff) : -1;
}

void Rank::take_pairs(std::span<const dem::PairHistory> pairs) {
  for (const dem::PairHistory& p : pairs) {
    const int i = taken(p.i), j = taken(p.j);
    if (i < 0 && j < 0) continue;
    const dem::PairState state = p.i > p.j ? p.state.turned_over() : p.state;  // as seen from the lower id
    if (i >= 0) fix_->remembered[at(i)].pairs.push_back({p.j, state});
    if (j >= 0) fix_->remembered[at(j)].pairs.push_back({p.i, state});
  }
}

void Rank::take_surfaces(std::span<const dem::SurfaceHistory> surfaces) {
  for (const dem::SurfaceHistory& s : surfaces)
    if (const int i = taken(s.sphere); i >= 0)
      fix_->remembered[at(i)].surfaces.push_back({s.boundary, s.normal, s.state});
}

void Rank::begin() {
  place_ = {};
  lmp_->atom->natoms = static_cast<std::int64_t>(beginning_.spheres);
  fix_->reserve_exchange();
  lmp_->input->one("run 0 post no");  // sets up all lists
}

/// Histories go with their spheres, to either of a pair.
void Rank::leave_lists() {
  const int* tag = lmp_->atom->tag;
  const auto count = static_cast<std::uint32_t>(subdomain_.size());
  const auto id_of = [&](std::uint32_t i) { return static_cast<std::uint32_t>(tag[i]) - 1; };
  for (std::uint32_t i = 0; i < count; ++i) fix_->remembered[i] = {};
  subdomain_.each_pair([&](std::uint32_t i, std::uint32_t j, const dem::PairState& state) {
    if (i < count) fix_->remembered[i].pairs.push_back({id_of(j), state});
    if (j < count) fix_->remembered[j].pairs.push_back({id_of(i), state});
  });
  for (const dem::SurfaceHistory& s : subdomain_.at_surfaces())
    fix_->remembered[s.sphere].surfaces.push_back({s.boundary, s.normal, s.state});
  take_out_fallen();
  fix_->reserve_exchange();
  left_lists_ = true;
}

void Rank::take_out_fallen() {
  LAMMPS_NS::Atom& atom = *lmp_->atom;
  for (int i = 0; i < atom.nlocal;) {
    if (!(atom.x[i][1] < beginning_.floor_drop)) {
      ++i;
      continue;
    }
    const dem::Sphere s = sphere_at(i);
    removed_ += kinetic_energy_of(s) - s.m * dot(beginning_.gravity, s.x);
    ++fallen_;
    atom.avec->copy(atom.nlocal - 1, i, 1);
    --atom.nlocal;
  }
}

dem::Sphere Rank::sphere_at(int index) const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  dem::Sphere s{};
  s.r = atom.radius[index], s.m = atom.rmass[index];
  s.id = static_cast<std::uint32_t>(atom.tag[index]) - 1;
  s.material = static_cast<std::uint16_t>(atom.type[index] - 1);
  copy_motion(index, s);
  return s;
}

void Rank::copy_motion(int index, dem::Sphere& to) const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  for (int d = 0; d < 3; ++d) to.x[d] = atom.x[index][d], to.v[d] = atom.v[index][d], to.w[d] = atom.omega[index][d];
}

/// Of LIGGGHTS' list, with what they remember.
std::vector<dem::NearPair> Rank::near_pairs() const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  const LAMMPS_NS::NeighList& list = *pair_->list;
  std::vector<dem::NearPair> pairs;
  for (int n = 0; n < list.inum; ++n) {
    const int a = list.ilist[n];
    const std::vector<Remembered::Pair>& was = fix_->remembered[at(a)].pairs;
    const dem::Vec3 x_a{atom.x[a][0], atom.x[a][1], atom.x[a][2]};
    for (int k = 0; k < list.numneigh[a]; ++k) {
      const int b = list.firstneigh[a][k] & NEIGHMASK;
      const dem::Vec3 x_b{atom.x[b][0], atom.x[b][1], atom.x[b][2]};
      const auto with = static_cast<std::uint32_t>(atom.tag[b]) - 1;
      const auto found = std::find_if(was.begin(), was.end(), [&](const auto& p) { return p.with == with; });
      const bool in_order = atom.tag[a] < atom.tag[b];
      pairs.push_back({static_cast<std::uint32_t>(in_order ? a : b), static_cast<std::uint32_t>(in_order ? b : a),
                       norm(x_a - x_b) - atom.radius[a] - atom.radius[b],
                       found == was.end() ? nullptr : &found->state});
    }
  }
  return pairs;
}

void Rank::build() {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  std::vector<dem::Sphere> own;
  for (int i = 0; i < atom.nlocal; ++i) own.push_back(sphere_at(i));
  subdomain_.begin_lists(own, at(atom.nghost));
  for (int k = 0; k < atom.nghost; ++k) subdomain_.ghost(at(k)) = sphere_at(atom.nlocal + k);
  std::vector<dem::SurfaceHistory> at_surfaces;
  for (int i = 0; i < atom.nlocal; ++i)
    for (const Remembered::Surface& s : fix_->remembered[at(i)].surfaces)
      at_surfaces.push_back({static_cast<std::uint32_t>(i), s.boundary, s.normal, s.state});
  subdomain_.build(near_pairs(), std::move(at_surfaces));
  for (int i = 0; i < atom.nlocal; ++i) fix_->remembered[at(i)] = {};
  left_lists_ = false;
}

void Rank::forces() {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  if (left_lists_) build();
  if (!stepping_) return;  // LIGGGHTS sets up its lists
  for (int k = 0; k < atom.nghost; ++k) copy_motion(atom.nlocal + k, subdomain_.ghost(at(k)));
  subdomain_.evaluate(now_.dt_before, sampling_, now_.energy || now_.snapshot != nullptr || steps_ == 0);
}

void Rank::motion() {
  if (now_.energy) subdomain_.observe(now_);
  if (now_.snapshot != nullptr) subdomain_.observe(now_, *now_.snapshot);
  subdomain_.move(now_);
  LAMMPS_NS::Atom& atom = *lmp_->atom;
  const dem::Sphere* const spheres = subdomain_.spheres();
  for (int i = 0; i < atom.nlocal; ++i)
    for (int d = 0; d < 3; ++d)
      atom.x[i][d] = spheres[i].x[d], atom.v[i][d] = spheres[i].v[d], atom.omega[i][d] = spheres[i].w[d];
}

dem::EngineSums Rank::step(const dem::EngineStep& step) {
  now_ = step;
  removed_ = 0, fallen_ = 0;
  int stale = subdomain_.lists_hold() ? 0 : 1, any = 0;
  MPI_Allreduce(&stale, &any, 1, MPI_INT, MPI_MAX, all_);
  if (any != 0) fix_->build_at(lmp_->update->ntimestep + 1);
  sampling_.begin(beginning_.sample_every, steps_, any != 0 || steps_ == 0);
  stepping_ = true;
  lmp_->update->integrate->run(1);
  stepping_ = false;
  ++steps_;
  dem::EngineSums sums = sum_up();
  sums.new_lists = any != 0 || steps_ == 1;
  return sums;
}

dem::EngineSums Rank::sum_up() {
  dem::EngineSums s = subdomain_.sums();
  double most[2]{s.speed2, s.overlap}, largest[2];
  if (most[0] != most[0]) most[0] = HUGE_VAL;  // a maximum may pass over what is no number
  MPI_Allreduce(most, largest, 2, MPI_DOUBLE, MPI_MAX, all_);
  subdomain_.add_path(std::sqrt(largest[0]) * now_.dt);
  const double mine[] = {s.kinetic,
                         s.rotational,
                         s.gravity,
                         s.stored,
                         s.lost.damping,
                         s.lost.sliding,
                         s.lost.rolling,
                         removed_,
                         s.pairs,
                         s.squares,
                         static_cast<double>(fallen_)};
  double all[std::size(mine)] = {};
  MPI_Reduce(mine, all, std::size(mine), MPI_DOUBLE, MPI_SUM, 0, all_);
  return {.kinetic = all[0],
          .rotational = all[1],
          .gravity = all[2],
          .stored = all[3],
          .lost = {all[4], all[5], all[6]},
          .removed = all[7],
          .pairs = all[8],
          .overlap = largest[1],
          .speed2 = largest[0],
          .squares = all[9],
          .fallen = static_cast<std::size_t>(all[10])};
}

dem::Bed::State Rank::state(bool contacts) {
  dem::Bed::State out;
  const auto count = static_cast<std::uint32_t>(subdomain_.size());
  const dem::Sphere* const s = subdomain_.spheres();
  out.spheres.assign(s, s + count);
  if (!contacts) return out;
  subdomain_.each_pair([&](std::uint32_t i, std::uint32_t j, const dem::PairState& state) {
    if (i < count) out.pairs.push_back({s[i].id, s[j].id, state});
  });
  for (const dem::SurfaceHistory& h : subdomain_.at_surfaces())
    out.surfaces.push_back({s[h.sphere].id, h.boundary, h.normal, h.state});
  return out;
}

}  // namespace subsoil::mpi
