#include "libsim/studies/impact/study.hpp"

#include <cmath>
#include <limits>

#include "libdem/particles/particles.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/scenario/checks.hpp"

namespace subsoil::sim {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

double mass_of(const ImpactBody& body) {
  if (body.mass) return *body.mass;
  return body.density && body.radius ? *body.density * dem::sphere_volume(*body.radius) : unbounded;
}

/// What a study must say beyond the ranges of its keys.
void check(const ImpactStudy& s, const std::map<std::string, Place>& places, Problems& problems) {
  const auto refuse = [&](const std::string& path, const std::string& rule) {
    problems.add(place_of(places, path), path, rule);
  };
  if (!std::isfinite(mass_of(s.first)))
    refuse("first.mass", "is missing: mass of the body that strikes; give it, or density and radius");
  const auto elastic = [&](const ImpactBody& body, const std::string& path) {
    if (body.young.has_value() != body.poisson.has_value())
      refuse(path, "has one of young and poisson; give both, or neither for a rigid body");
  };
  elastic(s.first, "first");
  if (s.second) elastic(*s.second, "second");
}

}  // namespace

std::string LoadedStudy::where(const std::string& path) const { return place_of(places, path).text() + " " + path; }

LoadedStudy load_study(const std::string& file, const std::vector<std::string>& sets) {
  Problems problems;
  const Node document = file.empty() ? parse_document("subsoil: 1\n", "command line", sets, problems)
                                     : read_document(file, sets, problems);
  LoadedStudy loaded;
  Reading reading(problems);
  read_all(document, reading, [&](Fields& fields) { declare(fields, loaded.study); });
  loaded.places = std::move(reading.places);
  if (problems.empty()) check(loaded.study, loaded.places, problems);
  if (!problems.empty()) throw ScenarioError(problems);
  return loaded;
}

std::string model_word(const ImpactStudy& study) {
  return std::visit([]<class Model>(const Model&) { return card_of<Model>().word; }, study.model);
}

dem::impact::Strikers strikers_of(const ImpactStudy& s) {
  return {.mass_1 = mass_of(s.first),
          .radius_1 = s.first.radius.value_or(unbounded),
          .mass_2 = s.second ? mass_of(*s.second) : unbounded,
          .radius_2 = s.second ? s.second->radius.value_or(unbounded) : unbounded};
}

dem::impact::Pair pair_of(const ImpactStudy& s) {
  const dem::impact::Strikers bodies = strikers_of(s);
  dem::impact::Pair pair{.mass = bodies.mass()};
  const double curvature = 1 / bodies.radius_1 + 1 / bodies.radius_2;
  if (curvature > 0) pair.radius = 1 / curvature;
  double softness = 0;
  for (const ImpactBody* body : {&s.first, s.second ? &*s.second : nullptr})
    if (body && body->young) softness += (1 - *body->poisson * *body->poisson) / *body->young;
  if (softness > 0) pair.E_eff = 1 / softness;
  if (s.first.density) pair.density = *s.first.density;
  for (const ImpactBody* body : {&s.first, s.second ? &*s.second : nullptr})
    if (body && body->yield) pair.yield = std::isnan(pair.yield) ? *body->yield : std::min(pair.yield, *body->yield);
  return pair;
}

}  // namespace subsoil::sim
