#include "libdem/packing/moving_bed.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "libdem/particles/statistics.hpp"

namespace subsoil::dem {
namespace {

constexpr std::size_t kSphere = 11;  // numbers of Bed::State::spheres: x v w r m

Vec3 centre_of(const Bed::State& s, std::size_t i) {
  const double* p = s.spheres.data() + kSphere * i;
  return {p[0], p[1], p[2]};
}
double radius_of(const Bed::State& s, std::size_t i) { return s.spheres[kSphere * i + 9]; }
double mass_of(const Bed::State& s, std::size_t i) { return s.spheres[kSphere * i + 10]; }

void refuse_block(const char* why) { throw std::invalid_argument(std::string("moving bed: ") + why); }

/// Numbers of one entry, after those that are there.
template <class T>
void append_entry(std::vector<T>& to, const std::vector<T>& from, std::size_t size, std::size_t entry) {
  const auto first = from.begin() + static_cast<std::ptrdiff_t>(size * entry);
  to.insert(to.end(), first, first + static_cast<std::ptrdiff_t>(size));
}

}  // namespace

PeriodicBlock block_of(Bed& bed, std::span<const int> boundary_of) {
  const PeriodicCell cell = bed.options().periodic;
  if (!(cell.length.x > 0)) refuse_block("its block must be periodic along x");
  if (bed.has_bonding_laws()) refuse_block("bonds between its blocks are not made; take a law without");
  if (!bed.clumps().empty()) refuse_block("its block must be of spheres, not of clumps");
  PeriodicBlock out{.low = cell.low.x, .length = cell.length.x, .state = {}, .across = {}};
  bed.freeze();
  for (const ContactRecord& c : bed.contacts()) out.stored += c.stored;
  const Bed::State all = bed.save();
  const std::size_t count = all.ids.size() / 2;
  if (count == 0) refuse_block("its block holds no sphere");
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return all.ids[2 * a] < all.ids[2 * b]; });
  std::unordered_map<std::int64_t, std::int64_t> number;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = order[k];
    number[all.ids[2 * i]] = static_cast<std::int64_t>(k);
    const Vec3 x = cell.wrapped(centre_of(all, i));
    out.state.spheres.insert(out.state.spheres.end(),
                             {x.x, x.y, x.z, 0, 0, 0, 0, 0, 0, radius_of(all, i), mass_of(all, i)});
    out.state.ids.insert(out.state.ids.end(), {static_cast<std::int64_t>(k), all.ids[2 * i + 1]});
    if (mass_of(all, i) > kFixedDensity * sphere_volume(radius_of(all, i)))
      refuse_block("its block must be without fixed spheres");
  }
  const std::size_t pairs = all.pair_ids.size() / 2, at_surfaces = all.surface_ids.size() / 2;
  for (std::size_t k = 0; k < pairs; ++k) {
    const std::int64_t i = number.at(all.pair_ids[2 * k]), j = number.at(all.pair_ids[2 * k + 1]);
    const double apart =
        centre_of(out.state, static_cast<std::size_t>(j)).x - centre_of(out.state, static_cast<std::size_t>(i)).x;
    out.state.pair_ids.insert(out.state.pair_ids.end(), {i, j});
    out.across.push_back(-std::lround(apart / out.length));
    append_entry(out.state.pairs, all.pairs, all.pairs.size() / pairs, k);
  }
  for (std::size_t k = 0; k < at_surfaces; ++k) {
    const auto boundary = static_cast<std::size_t>(all.surface_ids[2 * k + 1]);
    out.state.surface_ids.insert(out.state.surface_ids.end(),
                                 {number.at(all.surface_ids[2 * k]), std::int64_t{boundary_of[boundary]}});
    append_entry(out.state.surfaces, all.surfaces, all.surfaces.size() / at_surfaces, k);
  }
  return out;
}

MovingBed::MovingBed(PeriodicBlock block, const MovingBedPlan& plan) : block_(std::move(block)), plan_(plan) {
  if (plan.blocks < 1 || (plan.direction != 1 && plan.direction != -1))
    refuse_block("at least one block, and a direction of 1 or -1");
  if (block_.size() == 0 || block_.across.size() != block_.state.pair_ids.size() / 2)
    refuse_block("the arrays of its block do not belong together");
  for (std::size_t i = 0; i < block_.size(); ++i) largest_ = std::max(largest_, radius_of(block_.state, i));
  held_ = held_length(largest_);
  if (block_.length < held_)
    refuse_block(
        ("its block must be longer than two of the largest diameters, " + std::to_string(held_) + " m").c_str());
}

/// The block behind the window is number -1.
std::uint32_t MovingBed::id(long copy, std::size_t sphere) const {
  return static_cast<std::uint32_t>(static_cast<std::size_t>(copy + 1) * block_.size() + sphere);
}

Vec3 MovingBed::site(long copy, std::size_t sphere) const {
  const double start = plan_.direction > 0 ? plan_.rear - block_.low : plan_.rear - block_.length - block_.low;
  Vec3 x = centre_of(block_.state, sphere);
  x.x += start + plan_.direction * (static_cast<double>(copy) * block_.length);
  return x;
}

Vec3 MovingBed::place_at_rest(std::uint32_t id) const {
  return site(static_cast<long>(id / block_.size()) - 1, place_in_block(id));
}

double MovingBed::depth(std::size_t sphere) const {
  const double from_low = centre_of(block_.state, sphere).x - block_.low;
  return plan_.direction > 0 ? from_low : block_.length - from_low;
}

template <class Chosen>
void MovingBed::put_spheres(Bed::State& out, long copy, bool fixed, const Chosen& chosen) const {
  for (std::size_t i = 0; i < block_.size(); ++i) {
    if (!chosen(depth(i))) continue;
    const Vec3 x = site(copy, i);
    const double m = mass_of(block_.state, i);
    out.spheres.insert(out.spheres.end(), {x.x, x.y, x.z, 0, 0, 0, 0, 0, 0, radius_of(block_.state, i),
                                           fixed ? std::ldexp(m, kFixedPower) : m});
    out.ids.insert(out.ids.end(), {std::int64_t{id(copy, i)}, block_.state.ids[2 * i + 1]});
  }
}

/// Pairs of which this block has the hindmost sphere, and contacts at surfaces.
void MovingBed::put_contacts(Bed::State& out, long copy, bool only_across) const {
  const Bed::State& from = block_.state;
  const std::size_t pairs = block_.across.size(), at_surfaces = from.surface_ids.size() / 2;
  for (std::size_t k = 0; k < pairs; ++k) {
    const std::int64_t across = plan_.direction * block_.across[k];  // blocks are counted along the travel
    if (only_across && across == 0) continue;
    const long first = copy + std::max<long>(0, -across), second = copy + std::max<long>(0, across);
    out.pair_ids.insert(out.pair_ids.end(),
                        {std::int64_t{id(first, static_cast<std::size_t>(from.pair_ids[2 * k]))},
                         std::int64_t{id(second, static_cast<std::size_t>(from.pair_ids[2 * k + 1]))}});
    append_entry(out.pairs, from.pairs, from.pairs.size() / pairs, k);
  }
  if (only_across) return;
  for (std::size_t k = 0; k < at_surfaces; ++k) {
    out.surface_ids.insert(
        out.surface_ids.end(),
        {std::int64_t{id(copy, static_cast<std::size_t>(from.surface_ids[2 * k]))}, from.surface_ids[2 * k + 1]});
    append_entry(out.surfaces, from.surfaces, from.surfaces.size() / at_surfaces, k);
  }
}

CarriedSoil MovingBed::of_block(long copy, const Vec3& gravity) const {
  CarriedSoil out{.spheres = block_.size(), .mass = 0, .momentum = {}, .stored = block_.stored};
  for (std::size_t i = 0; i < block_.size(); ++i) {
    const double m = mass_of(block_.state, i);
    out.mass += m, out.gravity -= m * dot(gravity, site(copy, i));
  }
  return out;
}

void MovingBed::fill(Bed& bed) const {
  Bed::State all;
  const auto every = [](double) { return true; };
  put_spheres(all, -1, true, [&](double depth) { return depth > block_.length - held_; });
  put_contacts(all, -1, true);
  for (long copy = 0; copy < plan_.blocks; ++copy) put_spheres(all, copy, false, every), put_contacts(all, copy, false);
  put_spheres(all, plan_.blocks, true, [&](double depth) { return depth < held_; });
  bed.insert(all);
}

/// Spheres beyond the held ones that overlap what is put in.
std::vector<std::uint32_t> MovingBed::in_the_way(const Bed& bed, const Bed::State& added) const {
  const double reach = along(front()) + held_ - 2 * largest_;
  std::vector<std::uint32_t> out;
  for (const Sphere& s : bed.spheres()) {
    if (is_fixed(s) || along(s.x.x) < reach) continue;
    for (std::size_t i = 0; i < added.ids.size() / 2; ++i) {
      const Vec3 apart = s.x - centre_of(added, i);
      const double near = s.r + radius_of(added, i);
      if (dot(apart, apart) >= near * near) continue;
      out.push_back(s.id);
      break;
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

void MovingBed::advance(Bed& bed, std::span<const int> walls) {
  const Vec3 gravity = bed.options().gravity;
  const long copy = plan_.blocks + advanced_;  // that is let go
  const std::uint32_t first = id(copy, 0), end = id(copy + 1, 0);
  const auto let_go = [&](const Sphere& s) { return s.id >= first && s.id < end; };
  const double rear = way() + block_.length;  // from the first rear end

  Bed::State added;
  put_spheres(added, copy, true, [&](double depth) { return depth >= held_; });
  put_spheres(added, copy + 1, true, [&](double depth) { return depth < held_; });
  put_contacts(added, copy, false);

  // What leaves, and the contacts that end with it.
  enum Fate : char { held, gone };
  std::unordered_map<std::uint32_t, Fate> fate;
  const std::vector<ContactRecord> contacts = bed.contacts();
  const std::vector<std::uint32_t> over = in_the_way(bed, added);
  const auto is_over = [&](const Sphere& s) { return std::binary_search(over.begin(), over.end(), s.id); };
  const auto is_behind = [&](const Sphere& s) { return along(s.x.x) < rear - held_; };
  const auto leaves = [&](const Sphere& s) { return along(s.x.x) < rear || is_over(s); };
  for (const Sphere& s : bed.spheres()) {
    if (!leaves(s)) {
      if (is_fixed(s) && !let_go(s)) fate[s.id] = held;
      continue;
    }
    fate[s.id] = is_behind(s) || is_over(s) ? gone : held;
    if (is_fixed(s)) continue;
    ++left_.spheres, left_.mass += s.m, left_.momentum += s.m * s.v;
    left_.kinetic += kinetic_energy_of(s), left_.gravity -= s.m * dot(gravity, s.x);
  }
  double ended = 0;
  for (const ContactRecord& c : contacts) {
    const auto i = fate.find(c.i);
    if (c.at_surface) {
      ended += i != fate.end() ? c.stored : 0;
      continue;
    }
    const auto j = fate.find(c.j);
    const bool i_stays = i == fate.end(), j_stays = j == fate.end();
    const bool one_is_gone = (!i_stays && i->second == gone) || (!j_stays && j->second == gone);
    if (one_is_gone || (!i_stays && !j_stays)) ended += c.stored;
  }
  left_.stored += ended;
  pushed_out_ += over.size();
  const CarriedSoil more = of_block(copy, gravity);
  entered_.spheres += more.spheres, entered_.mass += more.mass;
  entered_.gravity += more.gravity, entered_.stored += more.stored;

  bed.insert(added);
  bed.release_if(let_go);
  bed.fix_if([&](const Sphere& s) { return leaves(s) && !is_behind(s) && !is_over(s); });
  bed.count_removed(ended - more.stored);
  for (const int wall : walls) {
    Boundary& b = bed.boundary(wall);
    b.pose.position.x += plan_.direction * block_.length;
    b.pose_before = b.pose;  // no motion that does work
  }
  ++advanced_;
  bed.remove_if([&](const Sphere& s) { return is_behind(s) || is_over(s); });
}

std::vector<double> MovingBed::save() const {
  std::vector<double> out{static_cast<double>(advanced_), static_cast<double>(pushed_out_)};
  for (const CarriedSoil* c : {&entered_, &left_})
    out.insert(out.end(), {static_cast<double>(c->spheres), c->mass, c->momentum.x, c->momentum.y, c->momentum.z,
                           c->kinetic, c->gravity, c->stored});
  return out;
}

void MovingBed::restore(std::span<const double> from) {
  if (from.size() != 18) throw std::invalid_argument("restart: what the state has of the moving bed is damaged");
  const double* at = from.data();
  advanced_ = std::lround(*at++), pushed_out_ = static_cast<std::size_t>(*at++);
  for (CarriedSoil* c : {&entered_, &left_}) {
    c->spheres = static_cast<std::size_t>(*at++), c->mass = *at++;
    c->momentum = {at[0], at[1], at[2]};
    c->kinetic = at[3], c->gravity = at[4], c->stored = at[5], at += 6;
  }
}

}  // namespace subsoil::dem
