#include "libdem/packing/moving_bed.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
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
  PeriodicBlock out{.low = cell.low.x, .length = cell.length.x, .state = {}, .across = {}, .stored = {}};
  bed.freeze();
  const std::vector<ContactRecord> contacts = bed.contacts();
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
    if (!all.kinds.empty() && all.kinds[i] == static_cast<std::int64_t>(SphereKind::fixed))
      refuse_block("its block must be without fixed spheres");
  }
  /// Periods from that of the first to that of the second.
  const auto across = [&](std::int64_t i, std::int64_t j) {
    const double apart =
        centre_of(out.state, static_cast<std::size_t>(j)).x - centre_of(out.state, static_cast<std::size_t>(i)).x;
    return std::int64_t{-std::lround(apart / out.length)};
  };
  const std::size_t pairs = all.pair_ids.size() / 2, at_surfaces = all.surface_ids.size() / 2;
  for (std::size_t k = 0; k < pairs; ++k) {
    const std::int64_t i = number.at(all.pair_ids[2 * k]), j = number.at(all.pair_ids[2 * k + 1]);
    out.state.pair_ids.insert(out.state.pair_ids.end(), {i, j});
    out.across.push_back(across(i, j));
    append_entry(out.state.pairs, all.pairs, all.pairs.size() / pairs, k);
  }
  for (std::size_t k = 0; k < at_surfaces; ++k) {
    const auto boundary = static_cast<std::size_t>(all.surface_ids[2 * k + 1]);
    out.state.surface_ids.insert(out.state.surface_ids.end(),
                                 {number.at(all.surface_ids[2 * k]), std::int64_t{boundary_of[boundary]}});
    append_entry(out.state.surfaces, all.surfaces, all.surfaces.size() / at_surfaces, k);
  }
  for (const ContactRecord& c : contacts) {
    const std::int64_t i = number.at(c.i), j = c.at_surface ? -1 : number.at(c.j);
    out.stored.push_back({i, j, j < 0 ? 0 : across(i, j), c.stored});
  }
  return out;
}

double PeriodicBlock::radius(std::size_t sphere) const { return radius_of(state, sphere); }
double PeriodicBlock::mass(std::size_t sphere) const { return mass_of(state, sphere); }

double PeriodicBlock::energy() const {
  double sum = 0;
  for (const StoredInContact& c : stored) sum += c.energy;
  return sum;
}

void CarriedSoil::add(const Sphere& s, const Vec3& acceleration) {
  ++spheres, mass += s.m, momentum += s.m * s.v;
  kinetic += kinetic_energy_of(s), gravity -= s.m * dot(acceleration, s.x);
}
void CarriedSoil::add(const CarriedSoil& more) {
  spheres += more.spheres, mass += more.mass, momentum += more.momentum;
  kinetic += more.kinetic, gravity += more.gravity, stored += more.stored;
}

MovingBed::MovingBed(PeriodicBlock block, const MovingBedPlan& plan) : block_(std::move(block)), plan_(plan) {
  if (plan.steps < 1 || !(plan.step > 0) || (plan.direction != 1 && plan.direction != -1))
    refuse_block("at least one step of some length, and a direction of 1 or -1");
  if (block_.size() == 0 || block_.across.size() != block_.state.pair_ids.size() / 2)
    refuse_block("the arrays of its block do not belong together");
  for (std::size_t i = 0; i < block_.size(); ++i) {
    largest_ = std::max(largest_, block_.radius(i));
    const double from_low = centre_of(block_.state, i).x - block_.low;
    depth_.push_back(plan.direction > 0 ? from_low : block_.length - from_low);
  }
  held_ = held_length(largest_);
  if (block_.length < held_ || plan.step < held_) {
    char text[200];
    std::snprintf(
        text, sizeof text,
        "the settled bed is %.4g m long and goes on by %.4g m: both must be two of the largest diameters, %.4g "
        "m, or more",
        block_.length, plan.step, held_);
    refuse_block(text);
  }
}

/// The period behind the start of the window is number -1.
std::uint32_t MovingBed::id(long period, std::size_t sphere) const {
  return static_cast<std::uint32_t>(static_cast<std::size_t>(period + 1) * block_.size() + sphere);
}

Vec3 MovingBed::site(long period, std::size_t sphere) const {
  const double start = plan_.direction > 0 ? plan_.rear - block_.low : plan_.rear - block_.length - block_.low;
  Vec3 x = centre_of(block_.state, sphere);
  x.x += start + plan_.direction * (static_cast<double>(period) * block_.length);
  return x;
}

Vec3 MovingBed::place_at_rest(std::uint32_t id) const {
  return site(static_cast<long>(id / block_.size()) - 1, place_in_block(id));
}

/// use(period) for all that have a part in the stretch.
template <class Use>
void MovingBed::each_period(const Stretch& of, const Use& use) const {
  const auto first = static_cast<long>(std::floor(of.low / block_.length)) - 1;
  const auto last = static_cast<long>(std::floor(of.high / block_.length)) + 1;
  for (long period = std::max(first, -1L); period <= last; ++period) use(period);
}

void MovingBed::put_spheres(Bed::State& out, const Stretch& of, bool fixed) const {
  each_period(of, [&](long period) {
    for (std::size_t i = 0; i < block_.size(); ++i) {
      if (!of.holds(along(period, i))) continue;
      const Vec3 x = site(period, i);
      out.spheres.insert(out.spheres.end(), {x.x, x.y, x.z, 0, 0, 0, 0, 0, 0, block_.radius(i), block_.mass(i)});
      out.kinds.push_back(static_cast<std::int64_t>(fixed ? SphereKind::fixed : SphereKind::free));
      out.ids.insert(out.ids.end(), {std::int64_t{id(period, i)}, block_.state.ids[2 * i + 1]});
    }
  });
}

/// Whether the hindmost sphere of a pair lies in the stretch, the first of it being of this period: its second's
/// period, else kNone.
constexpr long kNone = -1000;
long MovingBed::hindmost(const Stretch& of, long period, std::int64_t i, std::int64_t j, std::int64_t across) const {
  const long second = period + plan_.direction * across;  // counted along the travel
  const double u = std::min(along(period, static_cast<std::size_t>(i)), along(second, static_cast<std::size_t>(j)));
  return of.holds(u) ? second : kNone;
}

/// Pairs whose hindmost sphere lies in the stretch, and the stretch's contacts at surfaces.
void MovingBed::put_contacts(Bed::State& out, const Stretch& of) const {
  const Bed::State& from = block_.state;
  const std::size_t pairs = block_.across.size(), at_surfaces = from.surface_ids.size() / 2;
  each_period(of, [&](long period) {
    for (std::size_t k = 0; k < pairs; ++k) {
      const std::int64_t i = from.pair_ids[2 * k], j = from.pair_ids[2 * k + 1];
      const long second = hindmost(of, period, i, j, block_.across[k]);
      if (second == kNone) continue;
      out.pair_ids.insert(out.pair_ids.end(), {std::int64_t{id(period, static_cast<std::size_t>(i))},
                                               std::int64_t{id(second, static_cast<std::size_t>(j))}});
      append_entry(out.pairs, from.pairs, from.pairs.size() / pairs, k);
    }
    for (std::size_t k = 0; k < at_surfaces; ++k) {
      const auto i = static_cast<std::size_t>(from.surface_ids[2 * k]);
      if (!of.holds(along(period, i))) continue;
      out.surface_ids.insert(out.surface_ids.end(), {std::int64_t{id(period, i)}, from.surface_ids[2 * k + 1]});
      append_entry(out.surfaces, from.surfaces, from.surfaces.size() / at_surfaces, k);
    }
  });
}

/// Of spheres in the stretch at rest, and contacts as of `put_contacts`.
CarriedSoil MovingBed::content(const Stretch& of, const Vec3& gravity) const {
  CarriedSoil out;
  each_period(of, [&](long period) {
    for (std::size_t i = 0; i < block_.size(); ++i) {
      if (!of.holds(along(period, i))) continue;
      const double m = block_.mass(i);
      ++out.spheres, out.mass += m, out.gravity -= m * dot(gravity, site(period, i));
    }
    for (const StoredInContact& c : block_.stored) {
      const bool in = c.j < 0 ? of.holds(along(period, static_cast<std::size_t>(c.i)))
                              : hindmost(of, period, c.i, c.j, c.across) != kNone;
      if (in) out.stored += c.energy;
    }
  });
  return out;
}

/// Pairs of which only one sphere is free are those that reach across the rear end, too. Walls below the window are
/// boundaries that do not meet fixed spheres (Boundary::meets_fixed): their contacts begin and end with those of free
/// ones.
void MovingBed::fill(Bed& bed) const {
  Bed::State all;
  const double front = end_ahead(0);
  put_spheres(all, {-held_, 0}, true);
  put_spheres(all, {0, front}, false);
  put_spheres(all, {front, front + held_}, true);
  Bed::State behind;
  put_contacts(behind, {-held_, 0});
  const std::size_t pairs = behind.pair_ids.size() / 2;
  for (std::size_t k = 0; k < pairs; ++k) {
    const auto u = [&](std::int64_t id) {
      const auto number = static_cast<std::uint32_t>(id);
      return along(static_cast<long>(number / block_.size()) - 1, place_in_block(number));
    };
    if (u(behind.pair_ids[2 * k]) < 0 && u(behind.pair_ids[2 * k + 1]) < 0) continue;
    append_entry(all.pair_ids, behind.pair_ids, 2, k);
    append_entry(all.pairs, behind.pairs, behind.pairs.size() / pairs, k);
  }
  put_contacts(all, {0, front});
  bed.insert(all);
}

/// Spheres beyond the held ones that overlap what is put in.
std::vector<std::uint32_t> MovingBed::in_the_way(const Bed& bed, const Bed::State& added) const {
  const double reach = end_ahead(advanced_) + held_ - 2 * largest_;
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

namespace {

/// Of spheres that are not free, or will not be: held at rest, or taken out.
enum class Fate : char { held, gone };
using Fates = std::unordered_map<std::uint32_t, Fate>;

/// J, stored in contacts that end: of one that is gone, between two that are not free, and at walls.
double energy_that_ends(std::span<const ContactRecord> contacts, const Fates& fates) {
  double out = 0;
  for (const ContactRecord& c : contacts) {
    const auto i = fates.find(c.i), j = c.at_surface ? i : fates.find(c.j);
    const bool i_stays = i == fates.end(), j_stays = j == fates.end();
    const bool one_is_gone = (!i_stays && i->second == Fate::gone) || (!j_stays && j->second == Fate::gone);
    if (one_is_gone || (!i_stays && !j_stays)) out += c.stored;
  }
  return out;
}

}  // namespace

void MovingBed::advance(Bed& bed, std::span<const int> walls) {
  const Vec3 gravity = bed.options().gravity;
  const Stretch next{end_ahead(advanced_), end_ahead(advanced_ + 1)};  // that is let go
  const auto let_go = [&](const Sphere& s) {
    return is_fixed(s) && next.holds(along(static_cast<long>(s.id / block_.size()) - 1, place_in_block(s.id)));
  };
  const double rear = static_cast<double>(advanced_ + 1) * plan_.step;  // from the first rear end

  Bed::State added;
  put_spheres(added, {next.low + held_, next.high + held_}, true);
  put_contacts(added, next);

  const std::vector<ContactRecord> contacts = bed.contacts();
  const std::vector<std::uint32_t> over = in_the_way(bed, added);
  const auto is_over = [&](const Sphere& s) { return std::binary_search(over.begin(), over.end(), s.id); };
  const auto is_behind = [&](const Sphere& s) { return along(s.x.x) < rear - held_; };
  const auto leaves = [&](const Sphere& s) { return along(s.x.x) < rear || is_over(s); };
  Fates fates;
  for (const Sphere& s : bed.spheres()) {
    if (leaves(s)) {
      fates[s.id] = is_behind(s) || is_over(s) ? Fate::gone : Fate::held;
      if (!is_fixed(s)) left_.add(s, gravity);
    } else if (is_fixed(s) && !let_go(s)) {
      fates[s.id] = Fate::held;
    }
  }
  const double ended = energy_that_ends(contacts, fates);
  left_.stored += ended;
  pushed_out_ += over.size();
  const CarriedSoil more = content(next, gravity);
  entered_.add(more);

  bed.insert(added);
  bed.release_if(let_go);
  bed.fix_if([&](const Sphere& s) { return leaves(s) && !is_behind(s) && !is_over(s); });
  bed.count_removed(ended - more.stored);
  for (const int wall : walls) {
    Boundary& b = bed.boundary(wall);
    b.pose.position.x += plan_.direction * plan_.step;
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
