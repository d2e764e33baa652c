#include "libsim/io/bed_state_file.hpp"

#include <algorithm>
#include <span>
#include <stdexcept>
#include <type_traits>

namespace subsoil::sim {
namespace {

using dem::BondHistory;
using dem::PairHistory;
using dem::Sphere;
using dem::SurfaceHistory;

/// Numbers of a field: itself, an array, a point.
template <class T>
auto numbers_of(T& field) {
  if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>)
    return std::span<T>(&field, 1);
  else if constexpr (std::is_array_v<T>)
    return std::span(field);
  else
    return std::span<double>(&field.x, 3);
}

/// Columns of a list of records, each named once for both directions. Whole numbers lie in the file as int64.
template <class Record>
class RecordColumns {
 public:
  RecordColumns(StateWriter& to, std::string folder, std::vector<Record>& records)
      : to_(&to), folder_(std::move(folder)), records_(records) {}
  RecordColumns(const StateReader& from, std::string folder, std::vector<Record>& records)
      : from_(&from), folder_(std::move(folder)), records_(records) {}

  /// @param field its field of a record, by reference
  template <class Field>
  RecordColumns& operator()(const char* name, const Field& field) {
    using Number = typename decltype(numbers_of(field(records_[0])))::value_type;
    using Stored = std::conditional_t<std::is_floating_point_v<Number>, double, std::int64_t>;
    Record any{};
    const std::size_t width = numbers_of(field(any)).size();
    if (to_ != nullptr) {
      std::vector<Stored> column;
      column.reserve(width * records_.size());
      for (Record& r : records_)
        for (const Number& n : numbers_of(field(r))) column.push_back(static_cast<Stored>(n));
      to_->put(folder_ + name, column);
      return *this;
    }
    const std::vector<Stored> column = from_->get<Stored>(folder_ + name);
    if (first_) records_.resize(column.size() / width);
    first_ = false;
    if (column.size() != width * records_.size())
      throw std::runtime_error("the columns of " + folder_ + " do not belong together; the file is damaged");
    const Stored* at = column.data();
    for (Record& r : records_)
      for (Number& n : numbers_of(field(r))) n = static_cast<Number>(*at++);
    return *this;
  }

 private:
  StateWriter* to_ = nullptr;
  const StateReader* from_ = nullptr;
  std::string folder_;
  std::vector<Record>& records_;
  bool first_ = true;
};

template <class Record>
void contact_memory(RecordColumns<Record>& c) {
  c(
      "xi", [](Record & r) -> auto& { return r.state.xi; });
  c(
      "rho", [](Record & r) -> auto& { return r.state.rho; });
  c(
      "own", [](Record & r) -> auto& { return r.state.own; });
  c(
      "twist", [](Record & r) -> auto& { return r.state.twist; });
  c(
      "slipping", [](Record & r) -> auto& { return r.state.slipping; });
  c(
      "dash n", [](Record & r) -> auto& { return r.state.dash_n; });
  c(
      "dash t", [](Record & r) -> auto& { return r.state.dash_t; });
  c(
      "dash r", [](Record & r) -> auto& { return r.state.dash_r; });
  c(
      "dash w", [](Record & r) -> auto& { return r.state.dash_w; });
}

void name_columns(RecordColumns<Sphere> c) {
  c(
      "position", [](Sphere & s) -> auto& { return s.x; })(
      "velocity", [](Sphere & s) -> auto& { return s.v; });
  c(
      "angular velocity", [](Sphere & s) -> auto& { return s.w; });
  c(
      "radius", [](Sphere & s) -> auto& { return s.r; })(
      "mass", [](Sphere & s) -> auto& { return s.m; });
  c(
      "id", [](Sphere & s) -> auto& { return s.id; })(
      "material", [](Sphere & s) -> auto& { return s.material; });
  c(
      "kind", [](Sphere & s) -> auto& { return s.kind; })(
      "calm", [](Sphere & s) -> auto& { return s.calm; });
}
void name_columns(RecordColumns<PairHistory> c) {
  c(
      "i", [](PairHistory & p) -> auto& { return p.i; })(
      "j", [](PairHistory & p) -> auto& { return p.j; });
  contact_memory(c);
}
void name_columns(RecordColumns<SurfaceHistory> c) {
  c(
      "sphere", [](SurfaceHistory & h) -> auto& { return h.sphere; });
  c(
      "boundary", [](SurfaceHistory & h) -> auto& { return h.boundary; });
  c(
      "normal", [](SurfaceHistory & h) -> auto& { return h.normal; });
  contact_memory(c);
}
void name_columns(RecordColumns<BondHistory> c) {
  c(
      "i", [](BondHistory & b) -> auto& { return b.i; })(
      "j", [](BondHistory & b) -> auto& { return b.j; });
  c(
      "shear", [](BondHistory & b) -> auto& { return b.state.shear; });
  c(
      "bend", [](BondHistory & b) -> auto& { return b.state.bend; });
  c(
      "twist", [](BondHistory & b) -> auto& { return b.state.twist; });
  c(
      "reference", [](BondHistory & b) -> auto& { return b.state.reference; });
  c(
      "released", [](BondHistory & b) -> auto& { return b.state.released; });
  c(
      "state", [](BondHistory & b) -> auto& { return b.state.state; });
  c(
      "dash n", [](BondHistory & b) -> auto& { return b.state.dash_n; });
  c(
      "dash t", [](BondHistory & b) -> auto& { return b.state.dash_t; });
  c(
      "dash r", [](BondHistory & b) -> auto& { return b.state.dash_r; });
  c(
      "dash w", [](BondHistory & b) -> auto& { return b.state.dash_w; });
}

/// File: a StateWriter, or a const StateReader.
template <class File>
void each_list(File& file, const std::string& folder, dem::Bed::State& bed) {
  name_columns(RecordColumns<Sphere>(file, folder + "spheres/", bed.spheres));
  name_columns(RecordColumns<PairHistory>(file, folder + "pairs/", bed.pairs));
  name_columns(RecordColumns<SurfaceHistory>(file, folder + "surfaces/", bed.surfaces));
}
template <class File>
void list_bonds(File& file, const std::string& folder, dem::Bed::State& bed) {
  name_columns(RecordColumns<BondHistory>(file, folder + "bonds/", bed.bonds));
}

}  // namespace

void put_spheres(StateWriter& out, const std::string& folder, const dem::Bed::State& bed) {
  auto& same = const_cast<dem::Bed::State&>(bed);  // to write changes nothing
  each_list(out, folder, same);
  if (!bed.bonds.empty()) list_bonds(out, folder, same);
}

void read_spheres(const StateReader& in, const std::string& folder, dem::Bed::State& bed) {
  each_list(in, folder, bed);
  if (in.has(folder + "bonds")) list_bonds(in, folder, bed);
}

void put_bed_state(StateWriter& out, const dem::Bed::State& bed) {
  put_spheres(out, "bed/", bed);
  out.put("bed/parts", bed.parts);
}

dem::Bed::State bed_state_of(const StateReader& in) {
  dem::Bed::State bed;
  read_spheres(in, "bed/", bed);
  bed.parts = in.archive("bed/parts");
  return bed;
}

}  // namespace subsoil::sim
