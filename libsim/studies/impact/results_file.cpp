#include "libsim/studies/impact/results_file.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <type_traits>
#include <utility>

#include "libsim/io/atomic_file.hpp"
#include "libsim/io/hdf5.hpp"
#include "libsim/io/hdf5_driver.hpp"
#include "libsim/keys/printer.hpp"

namespace subsoil::sim {
namespace {

void write_numbers(hid_t parent, const std::string& name, const std::vector<double>& values, const std::string& unit) {
  h5::write<double>(parent, name, values);
  const h5::Handle set(H5Dopen2(parent, name.c_str(), H5P_DEFAULT), H5Dclose, "opening " + name);
  h5::set_attribute(set, "unit", unit);
}

/// Visitor of a declaration that puts every value down by its key; what is left out is not there.
class Parameters {
 public:
  Parameters(hid_t group, std::string prefix) : group_(group), prefix_(std::move(prefix)) {}

  void card(const char*, const char*) {}
  void quantity(const char* key, double value, const std::string& unit, const char*, const char*, const char* = "") {
    if (!std::isnan(value)) write_numbers(group_, prefix_ + key, {value}, unit);
  }
  void quantity(const char* key, const std::optional<double>& value, const std::string& unit, const char* range,
                const char* meaning) {
    if (value) quantity(key, *value, unit, range, meaning);
  }
  void derived(const char* key, double value, const std::string& unit, const char* range, const char* meaning,
               const char* = "") {
    quantity(key, value, unit, range, meaning);
  }
  void exponent(const char* key, double value, const char* range, const char* meaning) {
    quantity(key, value, "1", range, meaning);
  }
  void table(const char* key, const std::vector<double>& xs, const std::vector<double>& ys, const std::string& x_unit,
             const std::string& y_unit, const char*) {
    write_numbers(group_, prefix_ + key + " from", xs, x_unit);
    write_numbers(group_, prefix_ + key + " to", ys, y_unit);
  }
  void formula(const char* key, const std::string& text, const std::function<double(double, double, double)>&,
               const char*) {
    h5::write_text(group_, prefix_ + key, {text});
  }
  template <class E>
  void choice(const char* key, const E& value,
              std::initializer_list<std::pair<const char*, std::type_identity_t<E>>> words, const char*) {
    for (const auto& [word, meant] : words)
      if (meant == value) h5::write_text(group_, prefix_ + key, {word});
  }
  template <class Variant>
  void form(const char* key, Variant& value, const char*) {
    Parameters inner(group_, prefix_ + key + ".");
    std::visit([&](auto& f) { f.describe(inner); }, value);
  }

 private:
  hid_t group_;
  std::string prefix_;
};

void write_parameters(hid_t file, ImpactStudy study) {
  const h5::Handle group = h5::create_group(file, "parameters");
  Parameters own(group, "");
  std::visit([&](auto& model) { model.describe(own); }, study.model);
  Parameters first(group, "first."), second(group, "second.");
  study.first.describe(first);
  if (study.second) study.second->describe(second);
  const dem::impact::Pair pair = pair_of(study);
  Parameters of_pair(group, "pair.");
  of_pair.quantity("mass", pair.mass, "kg", "", "");
  of_pair.quantity("radius", pair.radius, "m", "", "");
  of_pair.quantity("E_eff", pair.E_eff, "Pa", "", "");
  of_pair.quantity("yield strength", pair.yield, "Pa", "", "");
}

void write_course(hid_t group, const dem::impact::Event& event) {
  struct Column {
    const char *name, *unit;
    double dem::impact::Sample::*value;
  };
  static constexpr std::array<Column, 4> columns{{{"time", "s", &dem::impact::Sample::t},
                                                  {"indentation", "m", &dem::impact::Sample::x},
                                                  {"speed", "m/s", &dem::impact::Sample::v},
                                                  {"force", "N", &dem::impact::Sample::f}}};
  for (const Column& column : columns) {
    std::vector<double> values;
    for (const dem::impact::Sample& s : event.course) values.push_back(s.*column.value);
    write_numbers(group, column.name, values, column.unit);
  }
}

void write_table(hid_t file, const ImpactStudy& study, const std::vector<ImpactRow>& rows) {
  const h5::Handle group = h5::create_group(file, "table");
  std::vector<double> speeds;
  bool stepped = false;
  for (const ImpactRow& row : rows) speeds.push_back(row.closed.speed), stepped = stepped || row.stepped;
  write_numbers(group, "speed", speeds, "m/s");
  for (const ImpactQuantity& q : impact_quantities(study)) {
    std::vector<double> closed, engine;
    for (const ImpactRow& row : rows) {
      closed.push_back(q.of(row.closed));
      engine.push_back(row.stepped ? q.of(*row.stepped) : std::numeric_limits<double>::quiet_NaN());
    }
    write_numbers(group, q.name, closed, q.unit);
    if (stepped) write_numbers(group, std::string("stepped ") + q.name, engine, q.unit);
  }
}

}  // namespace

void write_impact_file(const ImpactStudy& study, const std::vector<ImpactRow>& rows,
                       const std::filesystem::path& path) {
  h5::Handle file = h5::create_file(temporary_name(path));
  h5::set_attribute(file, "format", std::int64_t{1});
  h5::set_attribute(file, "title", study.title);
  h5::set_attribute(file, "model", model_word(study));
  ImpactStudy copy = study;
  h5::set_attribute(file, "study", emit(print_all([&](Fields& fields) { declare(fields, copy); }, false)));
  write_parameters(file, study);
  write_table(file, study, rows);
  h5::create_group(file, "courses");
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const h5::Handle course = h5::create_group(file, fmt::format("courses/{:03}", k));
    h5::set_attribute(course, "speed [m/s]", rows[k].closed.speed);
    write_course(course, rows[k].closed);
    if (rows[k].stepped) write_course(h5::create_group(course, "stepped"), *rows[k].stepped);
  }
  h5::close_file(file);
  put_in_place(path);
}

}  // namespace subsoil::sim
