#include "libsim/io/bed_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <stdexcept>

#include "libsim/base/input_limits.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/csv_separator.hpp"
#include "libsim/io/state_file.hpp"

namespace subsoil::sim {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr double kBeyond = 1e30;  // no bed has such numbers, and their squares are still finite

struct Column {
  const char* name;
  const char* unit;  ///< SI; empty for text and pure numbers
};
constexpr Column kColumns[] = {
    {"id", ""},       {"x", "m"},    {"y", "m"},    {"z", "m"},    {"radius", "m"}, {"density", "kg/m^3"},
    {"material", ""}, {"vx", "m/s"}, {"vy", "m/s"}, {"vz", "m/s"}, {"wx", "rad/s"}, {"wy", "rad/s"},
    {"wz", "rad/s"}};

/// A comment of a table: what BedTable::surface is.
constexpr const char* surface_mark = "# surface [m] = ";

double si_only(std::string_view unit, std::string_view si) {
  if (unit != si) throw std::invalid_argument(fmt::format("unit '{}': must be {}", unit, si));
  return 1;
}

void save_csv(const std::filesystem::path& path, const BedTable& bed) {
  std::string text;
  for (const auto& c : kColumns)
    text += fmt::format("{}{}", text.empty() ? "" : ",", *c.unit ? fmt::format("{} [{}]", c.name, c.unit) : c.name);
  text += '\n';
  if (bed.surface) {
    text += surface_mark;
    csv::append_number(text, *bed.surface, 17);
    text += '\n';
  }
  for (std::size_t i = 0; i < bed.size(); ++i) {
    const auto number = [&](double value) {
      text += ',';
      // 17 digits: a double comes back as it was. No density given is an empty field.
      if (!std::isnan(value)) csv::append_number(text, value, 17);
    };
    const auto vector = [&](const dem::Vec3& v) { number(v.x), number(v.y), number(v.z); };
    text += std::to_string(bed.id[i]);
    vector(bed.position[i]);
    number(bed.radius[i]);
    number(bed.density[i]);
    text += ',' + csv::quoted(bed.material[i]);
    vector(bed.velocity[i]);
    vector(bed.spin[i]);
    text += '\n';
  }
  write_atomically(path, text);
}

/// Reads one CSV with its own places in every refusal.
class CsvBed {
 public:
  CsvBed(const std::filesystem::path& path, const UnitFactor& factor) : path_(path), file_(path) {
    if (!file_) throw std::invalid_argument("cannot read " + path.string() + ": is the name right?");
    std::string line;
    std::getline(file_, line);
    if (const std::string fault = csv::other_separator(line); !fault.empty()) refuse(1, fault);
    const auto labels = csv::split(line);
    for (std::size_t i = 0; i < labels.size(); ++i) take_label(i, csv::split_label(labels[i]), factor);
    for (const char* must : {"x", "y", "z", "radius"})
      if (!places_.contains(must))
        refuse(1, fmt::format("column '{}' is missing; x, y, z and radius must stand", must));
    columns_ = labels.size();
  }

  BedTable read() {
    BedTable bed;
    std::string line;
    for (line_ = 2; std::getline(file_, line); ++line_) {
      double surface = 0;
      if (line.starts_with(surface_mark) && csv::to_number(line.substr(std::strlen(surface_mark)), surface))
        bed.surface = surface;
      if (line.find_first_not_of(" \t\r") == std::string::npos || line.starts_with('#')) continue;
      fields_ = csv::split(line);
      if (fields_.size() != columns_)
        refuse(line_, fmt::format("{} fields under {} columns", fields_.size(), columns_));
      add_row(bed);
    }
    return bed;
  }

 private:
  struct Place {
    std::size_t field;
    double factor;
  };

  [[noreturn]] void refuse(long line, const std::string& why) const {
    throw std::invalid_argument(fmt::format("{}:{}: {}", path_.string(), line, why));
  }

  void take_label(std::size_t field, const csv::Label& label, const UnitFactor& factor) {
    const auto known =
        std::find_if(std::begin(kColumns), std::end(kColumns), [&](const Column& c) { return c.name == label.name; });
    if (known == std::end(kColumns)) {
      std::vector<std::string> names;
      for (const auto& c : kColumns) names.emplace_back(c.name);
      refuse(1, fmt::format("column '{}' is unknown; known are {}", label.name, fmt::join(names, ", ")));
    }
    if (places_.contains(label.name)) refuse(1, fmt::format("column '{}' stands twice", label.name));
    double scale = 1;
    if (*known->unit) {
      if (label.unit.empty())
        refuse(1, fmt::format("column '{}' has no unit; write '{} [{}]'", label.name, label.name, known->unit));
      try {
        scale = (factor ? factor : UnitFactor(si_only))(label.unit, known->unit);
      } catch (const std::invalid_argument& error) {
        refuse(1, fmt::format("column '{}': {}", label.name, error.what()));
      }
    }
    places_[label.name] = {field, scale};
  }

  double number(const char* name, double missing) const {
    const auto place = places_.find(name);
    if (place == places_.end()) return missing;
    const auto& text = fields_[place->second.field];
    double value = 0;
    if (text.empty()) return missing;
    if (!csv::to_number(text, value) || !(std::abs(value) < kBeyond))
      refuse(line_, fmt::format("{} = '{}': must be a finite number below 1e30", name, text));
    return value * place->second.factor;
  }

  void add_row(BedTable& bed) {
    const double id = number("id", static_cast<double>(bed.size() + 1));
    const double radius = number("radius", kNaN), density = number("density", kNaN);
    if (id != std::floor(id) || !(std::abs(id) < 1e15))
      refuse(line_, fmt::format("id = {}: must be a whole number below 1e15", id));
    if (bed.size() >= input_limits().bed_rows)
      refuse(line_, fmt::format("more than {} spheres{}", input_limits().bed_rows, allow_more("bed-rows")));
    if (!(radius > 0)) refuse(line_, fmt::format("radius = {} m: must be in (0, inf)", radius));
    if (density <= 0) refuse(line_, fmt::format("density = {} kg/m^3: must be in (0, inf)", density));
    const dem::Vec3 position{number("x", kNaN), number("y", kNaN), number("z", kNaN)};
    if (std::isnan(dem::norm(position))) refuse(line_, "x, y and z must stand in every line");
    bed.id.push_back(static_cast<std::int64_t>(id));
    bed.position.push_back(position);
    bed.radius.push_back(radius);
    bed.density.push_back(density);
    const auto material = places_.find("material");
    bed.material.push_back(material == places_.end() ? std::string() : fields_[material->second.field]);
    bed.velocity.push_back({number("vx", 0), number("vy", 0), number("vz", 0)});
    bed.spin.push_back({number("wx", 0), number("wy", 0), number("wz", 0)});
  }

  std::filesystem::path path_;
  std::ifstream file_;
  std::map<std::string, Place> places_;
  std::size_t columns_ = 0;
  std::vector<std::string> fields_;
  long line_ = 1;
};

void save_hdf5(const std::filesystem::path& path, const BedTable& bed) {
  std::vector<std::string> names;  // materials by number: names once
  std::vector<std::int32_t> material;
  for (const auto& name : bed.material) {
    auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) found = names.insert(names.end(), name);
    material.push_back(static_cast<std::int32_t>(found - names.begin()));
  }
  StateWriter file(path);
  file.put("bed/id", bed.id);
  file.put_vectors("bed/position", bed.position);
  file.put("bed/radius", bed.radius);
  file.put("bed/density", bed.density);
  file.put("bed/material", material);
  file.put_text("bed/material names", fmt::format("{}", fmt::join(names, "\n")));
  file.put_vectors("bed/velocity", bed.velocity);
  file.put_vectors("bed/spin", bed.spin);
  if (bed.surface) file.put("bed/surface", *bed.surface);
  if (!bed.clumps.empty()) {
    std::vector<BedClump> clumps = bed.clumps;
    Archive archive;
    archive("clumps", clumps);
    file.put("bed/clumps", archive);
  }
  file.commit();
}

BedTable bed_in(const StateReader& file) {
  if (!file.has("bed/position")) throw std::invalid_argument("holds no bed; beds are written by 'save:' in a scenario");
  BedTable bed{file.get<std::int64_t>("bed/id"),
               file.get_vectors("bed/position"),
               file.get<double>("bed/radius"),
               file.get<double>("bed/density"),
               {},
               file.get_vectors("bed/velocity"),
               file.get_vectors("bed/spin"),
               {}};
  if (file.has("bed/surface")) bed.surface = file.value<double>("bed/surface");
  if (file.has("bed/clumps")) {
    Archive archive = file.archive("bed/clumps");
    archive("clumps", bed.clumps);
    archive.end();
  }
  std::vector<std::string> names(1);
  for (const char c : file.text("bed/material names"))
    if (c == '\n')
      names.emplace_back();
    else
      names.back() += c;
  for (const auto m : file.get<std::int32_t>("bed/material")) {
    if (m < 0 || static_cast<std::size_t>(m) >= names.size())
      throw std::invalid_argument(fmt::format("names material {} of {}; the file is damaged", m, names.size()));
    bed.material.push_back(names[static_cast<std::size_t>(m)]);
  }
  return bed;
}

BedTable load_hdf5(const std::filesystem::path& path) {
  const StateReader file(path);
  try {
    return bed_in(file);
  } catch (const std::exception& error) {
    throw std::invalid_argument(path.string() + ": " + error.what());
  }
}

/// Which of the two, by suffix.
bool is_csv(const std::filesystem::path& path) {
  if (path.extension() == ".csv") return true;
  if (path.extension() == ".h5") return false;
  throw std::invalid_argument(fmt::format("bed file {}: its suffix must be .h5 or .csv", path.string()));
}

void check_sizes(const std::filesystem::path& path, const BedTable& bed) {
  const auto n = bed.size();
  if (bed.position.size() != n || bed.radius.size() != n || bed.density.size() != n || bed.material.size() != n ||
      bed.velocity.size() != n || bed.spin.size() != n)
    throw std::invalid_argument("bed file " + path.string() + ": its columns are not of one length");
}

/// What tables of text are asked line by line.
void check_numbers(const std::filesystem::path& path, const BedTable& bed) {
  const auto finite = [](const dem::Vec3& v) { return dem::norm(v) < kBeyond; };
  for (std::size_t i = 0; i < bed.size(); ++i) {
    const bool density = std::isnan(bed.density[i]) || (bed.density[i] > 0 && bed.density[i] < kBeyond);
    if (!(bed.radius[i] > 0 && bed.radius[i] < kBeyond) || !density || !finite(bed.position[i]) ||
        !finite(bed.velocity[i]) || !finite(bed.spin[i]))
      throw std::invalid_argument(fmt::format(
          "{}: sphere {} has radius {:g} m, density {:g} kg/m^3, place ({:g}, {:g}, {:g}) m, speed {:g} m/s, spin {:g} "
          "rad/s: radius and density must be above 0, all finite",
          path.string(), i + 1, bed.radius[i], bed.density[i], bed.position[i].x, bed.position[i].y, bed.position[i].z,
          dem::norm(bed.velocity[i]), dem::norm(bed.spin[i])));
  }
}

}  // namespace

void save_bed(const std::filesystem::path& path, const BedTable& bed) {
  check_sizes(path, bed);
  if (is_csv(path))
    save_csv(path, bed);
  else
    save_hdf5(path, bed);
}

BedTable load_bed(const std::filesystem::path& path, const UnitFactor& factor) {
  auto bed = is_csv(path) ? CsvBed(path, factor).read() : load_hdf5(path);
  check_sizes(path, bed);
  check_numbers(path, bed);
  auto ids = bed.id;
  std::sort(ids.begin(), ids.end());
  if (const auto twice = std::adjacent_find(ids.begin(), ids.end()); twice != ids.end())
    throw std::invalid_argument(fmt::format("{}: id {} stands twice", path.string(), *twice));
  return bed;
}

}  // namespace subsoil::sim
