#include "apps/mpi/parts.hpp"

#include <algorithm>
#include <exception>
#include <numeric>
#include <utility>

#include "apps/mpi/messages.hpp"
#include "libsim/io/disk.hpp"
#include "libsim/run/between.hpp"

namespace subsoil::mpi {
namespace {

/// A row of a snapshot, as it goes between processes.
struct SphereRecord {
  std::uint32_t id;
  int material, contacts;
  double radius;
  dem::Vec3 position, velocity, angular_velocity, force, torque;
};

SphereRecord record_of(const dem::Snapshot& s, std::size_t k) {
  return {s.id[k],       s.material[k],         s.contacts[k], s.radius[k], s.position[k],
          s.velocity[k], s.angular_velocity[k], s.force[k],    s.torque[k]};
}

void append(dem::Snapshot& s, const SphereRecord& r) {
  s.id.push_back(r.id), s.radius.push_back(r.radius), s.material.push_back(r.material);
  s.position.push_back(r.position), s.velocity.push_back(r.velocity);
  s.angular_velocity.push_back(r.angular_velocity), s.force.push_back(r.force), s.torque.push_back(r.torque);
  s.contacts.push_back(r.contacts);
}

template <class T>
void permute(std::vector<T>& values, const std::vector<std::size_t>& order) {
  std::vector<T> out;
  out.reserve(values.size());
  for (const std::size_t k : order) out.push_back(values[k]);
  values = std::move(out);
}

bool holds_id(const dem::Snapshot& sorted, std::uint32_t id) {
  return std::binary_search(sorted.id.begin(), sorted.id.end(), id);
}

bool any(bool here, MPI_Comm all) {
  int mine = here ? 1 : 0, most = 0;
  MPI_Allreduce(&mine, &most, 1, MPI_INT, MPI_MAX, all);
  return most != 0;
}

int rank_of(MPI_Comm all) {
  int rank = 0;
  MPI_Comm_rank(all, &rank);
  return rank;
}

}  // namespace

void sort_by_id(dem::Snapshot& s, std::vector<double>* density) {
  std::vector<std::size_t> order(s.id.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return s.id[a] < s.id[b]; });
  permute(s.id, order), permute(s.radius, order), permute(s.material, order), permute(s.contacts, order);
  permute(s.position, order), permute(s.velocity, order), permute(s.angular_velocity, order);
  permute(s.force, order), permute(s.torque, order);
  if (density != nullptr) permute(*density, order);
  s.bonds.clear();
}

void gather_snapshot(dem::Snapshot& s, MPI_Comm all) {
  const auto collect = [&](auto& values) { values = gather(std::move(values), all); };
  collect(s.id), collect(s.radius), collect(s.material), collect(s.contacts);
  collect(s.position), collect(s.velocity), collect(s.angular_velocity), collect(s.force), collect(s.torque);
  sort_by_id(s);
}

/// Does it on all processes; a fault of any is thrown on rank 0, the others go on.
template <class Action>
void Parts::together(const Action& action) {
  std::string fault;
  try {
    action();
  } catch (const std::exception& error) {
    fault = error.what();
  }
  if (!any(!fault.empty(), all_)) return;
  if (!fault.empty()) fault += '\n';
  std::vector<char> faults = gather(std::vector<char>(fault.begin(), fault.end()), all_);
  if (rank_of(all_) == 0)
    throw sim::DiskFault(std::string(faults.begin(), std::find(faults.begin(), faults.end(), '\n')));
}

Parts::Parts(MPI_Comm all, const std::filesystem::path& directory, const sim::RunOptions& options, double quantum)
    : all_(all) {
  together([&] { writer_.emplace(directory, rank_of(all), options, quantum); });
}

dem::EngineSums Parts::step(Rank& rank, dem::EngineStep step) {
  std::swap(before_, now_);
  now_ = {};
  step.snapshot = &now_.spheres;
  const dem::EngineSums sums = rank.step(step);
  for (const dem::Sphere& s : rank.own()) now_.density.push_back(dem::density(s));
  sort_by_id(now_.spheres, &now_.density);
  return sums;
}

/// Spheres of the instant before, of this process.
dem::Snapshot Parts::between(const sim::Between& between) const {
  std::vector<SphereRecord> come;
  const dem::Snapshot& now = now_.spheres;
  for (std::size_t k = 0; k < now.id.size(); ++k)
    if (!holds_id(before_.spheres, now.id[k])) come.push_back(record_of(now, k));
  if (!any(!come.empty(), all_)) return sim::interpolate(before_.spheres, now, between.step, between.share);
  come = gather(std::move(come), all_);
  broadcast(come, all_);
  dem::Snapshot mine = now;
  for (const SphereRecord& r : come)
    if (holds_id(before_.spheres, r.id)) append(mine, r);
  sort_by_id(mine);
  return sim::interpolate(before_.spheres, mine, between.step, between.share);
}

std::string Parts::write(const sim::PartPlace& place, const sim::Between& between) {
  const bool is_between = between.share > 0 && between.share < 1;
  dem::Snapshot made;
  if (is_between) made = this->between(between);
  const Instant& instant = between.share > 0 ? before_ : now_;
  const dem::Snapshot& s = is_between ? made : instant.spheres;
  sim::ParticleTable own;
  own.id.assign(s.id.begin(), s.id.end());
  own.radius = s.radius, own.material = s.material, own.density = instant.density;
  sim::Frame frame;
  frame.position = s.position, frame.velocity = s.velocity, frame.spin = s.angular_velocity;
  frame.force = s.force, frame.torque = s.torque, frame.contacts = s.contacts;
  std::string xml;
  together([&] { xml = writer_->write(place, own, frame); });
  const std::vector<char> all = gather(std::vector<char>(xml.begin(), xml.end()), all_);
  return {all.begin(), all.end()};
}

void Parts::publish() {
  together([&] { writer_->publish(); });
}

dem::Snapshot Parts::last_instant() const {
  dem::Snapshot out = now_.spheres;
  gather_snapshot(out, all_);
  return out;
}

void Parts::restore(const dem::Snapshot& spheres, const Rank& rank) {
  std::vector<std::pair<std::uint32_t, double>> here;
  for (const dem::Sphere& s : rank.own()) here.emplace_back(s.id, dem::density(s));
  std::sort(here.begin(), here.end());
  constexpr std::size_t part = std::size_t{1} << 18;
  std::size_t count = spheres.id.size();
  MPI_Bcast(&count, sizeof count, MPI_BYTE, 0, all_);
  now_ = {};
  for (std::size_t begin = 0; begin < count; begin += part) {
    std::vector<SphereRecord> some;
    for (std::size_t k = begin; k < std::min(begin + part, spheres.id.size()); ++k)
      some.push_back(record_of(spheres, k));
    broadcast(some, all_);
    for (const SphereRecord& r : some) {
      const auto found = std::lower_bound(here.begin(), here.end(), std::pair{r.id, 0.0});
      if (found == here.end() || found->first != r.id) continue;
      append(now_.spheres, r);
      now_.density.push_back(found->second);
    }
  }
}

}  // namespace subsoil::mpi
