#include "libsim/keys/clump_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "libsim/base/byte_order_mark.hpp"
#include "libsim/io/csv.hpp"

namespace subsoil::sim {
namespace {

constexpr std::size_t most_spheres = 10000;  // each one is a particle of the bed for every grain of the shape
constexpr double beyond = 1e30;              // no grain has such numbers, and their squares are still finite
constexpr std::string_view format_mark = "#format ";
constexpr std::array<std::string_view, 4> wanted{"x", "y", "z", "r"};

std::vector<std::string> fields_of(const std::string& line) {
  if (line.find(',') != std::string::npos) return csv::split(line);
  std::istringstream words(line);
  return {std::istream_iterator<std::string>(words), {}};
}

/// `x_y_z_r_clumpId` of YADE.
std::vector<std::string> names_of(std::string_view format) {
  std::vector<std::string> out(1);
  for (const char c : format)
    if (c == '_')
      out.emplace_back();
    else if (std::isspace(static_cast<unsigned char>(c)) == 0)
      out.back() += c;
  return out;
}

class ClumpFile {
 public:
  ClumpFile(const std::filesystem::path& path, double unit) : path_(path), unit_(unit), file_(path) {
    if (!file_) throw std::invalid_argument("cannot read " + path.string() + ": is the name right?");
  }

  std::vector<dem::ClumpMember> read() {
    std::vector<dem::ClumpMember> out;
    for (std::string line; std::getline(file_, line);) {
      ++line_;
      line = std::string(without_byte_order_mark(line));
      if (line.starts_with(format_mark)) take_names(names_of(std::string_view(line).substr(format_mark.size())));
      line.resize(std::min(line.find('#'), line.size()));
      if (line.find(';') != std::string::npos)
        refuse("has its fields separated by `;`: must be blanks or `,`, with decimal points in the numbers");
      const std::vector<std::string> fields = fields_of(line);
      if (fields.empty() || (fields.size() == 1 && fields[0].empty())) continue;
      if (out.empty() && !has_names_ && is_header(fields)) {
        take_names(fields);
        continue;
      }
      if (fields.size() != columns_) refuse_columns(fields);
      if (out.size() == most_spheres) refuse(fmt::format("holds more than {} spheres of one clump", most_spheres));
      out.push_back(sphere(fields));
    }
    if (out.empty()) throw std::invalid_argument(path_.string() + ": holds no sphere; must have lines of x y z radius");
    return out;
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const {
    throw std::invalid_argument(fmt::format("{}:{}: {}", path_.string(), line_, why));
  }

  static bool is_header(const std::vector<std::string>& fields) {
    double number = 0;
    return std::none_of(fields.begin(), fields.end(), [&](const std::string& f) { return csv::to_number(f, number); });
  }

  void take_names(const std::vector<std::string>& names) {
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      const auto at = std::find(names.begin(), names.end(), wanted[k]);
      if (at == names.end())
        refuse(fmt::format("names the columns {}, of which `{}` is missing; must have x, y, z and r",
                           fmt::join(names, ", "), wanted[k]));
      place_[k] = static_cast<std::size_t>(at - names.begin());
    }
    const auto clump = std::find(names.begin(), names.end(), "clumpId");
    if (clump != names.end()) clump_ = static_cast<std::size_t>(clump - names.begin());
    columns_ = names.size(), has_names_ = true;
  }

  [[noreturn]] void refuse_columns(const std::vector<std::string>& fields) const {
    const std::string cure = has_names_ ? "" : "; name them in a first line, such as `#format x_y_z_r_matId`";
    refuse(fmt::format("has {} columns: must be {}{}", fields.size(), has_names_ ? std::to_string(columns_) : "x y z r",
                       fields.size() > columns_ ? cure : ""));
  }

  dem::ClumpMember sphere(const std::vector<std::string>& fields) {
    if (clump_) {
      if (of_.empty()) of_ = fields[*clump_];
      if (fields[*clump_] != of_)
        refuse(fmt::format("is of clump {}, and the lines before of clump {}: must be one clump; give each a file",
                           fields[*clump_], of_));
    }
    std::array<double, 4> v{};
    for (std::size_t k = 0; k < v.size(); ++k) {
      const std::string& text = fields[place_[k]];
      if (!csv::to_number(text, v[k]) || !(std::abs(v[k]) < beyond))
        refuse(fmt::format("{} = '{}': must be a finite number below 1e30", wanted[k], text));
    }
    if (!(v[3] > 0)) refuse(fmt::format("r = {:g}: must be in (0, inf)", v[3]));
    return {unit_ * dem::Vec3{v[0], v[1], v[2]}, unit_ * v[3]};
  }

  const std::filesystem::path& path_;
  double unit_;  ///< m
  std::ifstream file_;
  long line_ = 0;
  std::array<std::size_t, 4> place_{0, 1, 2, 3};  ///< of x, y, z, r in a line
  std::optional<std::size_t> clump_;              ///< of the clump's number
  std::string of_;                                ///< the clump's number
  std::size_t columns_ = wanted.size();
  bool has_names_ = false;
};

}  // namespace

std::vector<dem::ClumpMember> load_clump(const std::filesystem::path& path, double unit) {
  return ClumpFile(path, unit).read();
}

}  // namespace subsoil::sim
