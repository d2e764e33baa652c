/// Floating-point operations of one contact, law by law: the law's own functions run over a number that counts. Each of
/// + - * / sqrt rsqrt pow log counts one (a multiply-add two); comparisons, selections and signs count nothing. A line
/// per law.
#include <cstdio>

#include "bench/bed_case.hpp"
#include "libdem/laws/cohesive.hpp"

namespace subsoil::bench {

/// A double that counts what is done with it.
struct Counted {
  double value = 0;
  static inline long operations = 0;

  Counted() = default;
  explicit Counted(double v) : value(v) {}
  static Counted done(double v) { return ++operations, Counted(v); }
  friend Counted operator+(Counted a, Counted b) { return done(a.value + b.value); }
  friend Counted operator-(Counted a, Counted b) { return done(a.value - b.value); }
  friend Counted operator*(Counted a, Counted b) { return done(a.value * b.value); }
  friend Counted operator/(Counted a, Counted b) { return done(a.value / b.value); }
  friend Counted operator-(Counted a) { return Counted(-a.value); }
  friend bool operator>(Counted a, Counted b) { return a.value > b.value; }
  friend bool operator<(Counted a, Counted b) { return a.value < b.value; }
  friend bool operator>=(Counted a, Counted b) { return a.value >= b.value; }
  friend bool operator<=(Counted a, Counted b) { return a.value <= b.value; }
  friend Counted sqrt(Counted a) { return done(std::sqrt(a.value)); }
  friend Counted pow(Counted a, double n) { return done(std::pow(a.value, n)); }
  friend Counted log(Counted a) { return done(std::log(a.value)); }
  friend Counted rsqrt(Counted a) { return done(1 / std::sqrt(a.value)); }
  friend Counted over_root(Counted k, Counted a) { return k * rsqrt(a); }
  friend Counted max(Counted a, Counted b) { return a > b ? a : b; }
  friend Counted min(Counted a, Counted b) { return a < b ? a : b; }
  friend Counted select(bool condition, Counted a, Counted b) { return condition ? a : b; }
};

/// Operations of a touching, sliding and rolling contact.
template <class L>
long operations_of(const L& l) {
  const Counted r_eff(kRadius / 2), m_eff(4e-3), dt(2e-5), inverse_r(2 / kRadius), root_i(3e-4), none(0.0);
  const Counted xi[3] = {Counted(1e-6), none, none}, v[3] = {Counted(1e-3), none, none};
  const Counted zero[3] = {};
  Counted::operations = 0;
  Counted own[dem::kOwnMemory] = {};
  const auto n = dem::normal_force(l, dem::Approach<Counted>{Counted(1e-5), Counted(1e-3), m_eff, r_eff, dt}, own);
  l.friction.slide(n, xi, v, zero, none, dt);
  if (l.friction.mu_r > 0) l.friction.roll(n, xi, v, zero, r_eff, inverse_r, root_i, dt);
  return Counted::operations;
}

/// Of the given law, with its cohesion where it has any; bonds are not counted.
long operations(const dem::GivenLaw& law) {
  return std::visit(
      [](const auto& given) {
        const auto ready = given.resolved();
        if constexpr (requires { ready.cohesion; })
          if (ready.cohesion.acts()) return operations_of(dem::Cohesive<std::decay_t<decltype(ready)>>{ready});
        return operations_of(ready);
      },
      law);
}

}  // namespace subsoil::bench

int main() {
  using namespace subsoil::bench;
  for (const auto& [name, law] : {std::pair{LawName::linear, "linear"},
                                  {LawName::hertz, "hertz-mindlin"},
                                  {LawName::rolling, "linear, rolling"},
                                  {LawName::wet, "wet, rolling"},
                                  {LawName::hysteretic, "hysteretic"},
                                  {LawName::luding, "luding"},
                                  {LawName::eepa, "eepa"},
                                  {LawName::variable, "variable restitution"},
                                  {LawName::jkr, "jkr"},
                                  {LawName::bridge, "hertz-mindlin, liquid bridge"}})
    std::printf("%-28s %ld\n", law, operations(law_of(name)));
}
