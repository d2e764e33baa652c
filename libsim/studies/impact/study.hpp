#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libdem/bed_impact.hpp"
#include "libdem/impact/models.hpp"
#include "libsim/document/document.hpp"
#include "libsim/studies/impact/ground_impact.hpp"

/// What `subsoil impact` is asked: a model, two bodies, speeds. Read by the machinery of scenarios, from a file, from
/// flags, or both.
namespace subsoil::sim {

/// The models of libdem and the ground element.
template <class List, class More>
struct With;
template <class... Models, class More>
struct With<std::variant<Models...>, More> {
  using type = std::variant<Models..., More>;
};
using ImpactModel = With<dem::impact::Model, GroundImpact>::type;

/// One of the two bodies, as far as the model needs it.
struct ImpactBody {
  std::optional<double> mass, radius, density, young, poisson, yield;

  template <class V>
  void describe(V& v) {
    v.quantity("mass", mass, "kg", "(0, inf)", "left out: density times the volume of its sphere, else it is fixed");
    v.quantity("radius", radius, "m", "(0, inf)", "of curvature at the contact; left out: flat");
    v.quantity("density", density, "kg/m^3", "(0, inf)", "needed by models that scale with it");
    v.quantity("young", young, "Pa", "(0, inf)", "modulus; left out: rigid beside the other body");
    v.quantity("poisson", poisson, "1", "(-1, 0.5]", "ratio; goes with young");
    v.quantity("yield strength", yield, "Pa", "(0, inf)", "of models whose bodies yield; the softer body does");
  }
};

/// A law whose restitution stands in for measured data.
struct ImpactLaw {
  ImpactModel model;

  template <class V>
  void describe(V& v) {
    v.kind("model", model, "the model; its parameters stand beside it");
  }
};

struct ImpactStudy {
  long version = 1;
  std::string title;
  ImpactModel model;
  ImpactBody first;
  std::optional<ImpactBody> second;
  std::vector<double> speeds;
  long samples = dem::impact::usual_samples;
  long steps = 1000;
  std::optional<ImpactLaw> fit_to;

  template <class V>
  void describe(V& v) {
    v.version("subsoil", version, "version of the format: 1");
    v.text("title", title, "one line about what this is");
    v.kind("model", model, "impact model; its parameters stand beside it");
    v.section("first", first, "the body that strikes");
    v.section("second", second, "the body that is struck; left out: fixed, flat and rigid");
    v.quantities("speeds", speeds, "m/s", "(0, inf)", "speeds of approach, one after the other");
    v.count("samples", samples, "[10, 100000]", "of x(t), v(t), F(t) in each of the two phases");
    v.count("steps", steps, "[0, 10000000]",
            "steps in which the engine goes through the compression, beside the closed form; 0: it does not");
    v.section("fit to", fit_to, "a law whose restitution at `speeds` the model is fitted to, in place of measurements");
  }
};

/// A study and where its keys stand.
struct LoadedStudy {
  ImpactStudy study;
  std::map<std::string, Place> places;
  /// "mine.yaml:3:8 model"
  std::string where(const std::string& path) const;
};

/// Reads and checks a study: `file` (none: flags alone) with `path=value` overrides. Throws ScenarioError.
LoadedStudy load_study(const std::string& file, const std::vector<std::string>& sets);

/// The word of its model.
std::string model_word(const ImpactStudy& study);

/// The bodies as models and as the bed take them.
dem::impact::Strikers strikers_of(const ImpactStudy& study);
dem::impact::Pair pair_of(const ImpactStudy& study);

}  // namespace subsoil::sim
