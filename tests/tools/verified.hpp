#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "tests/tools/paths.hpp"

/// Rows of docs/verification/index.md. A test states what it found through this helper instead of a bare EXPECT_NEAR:
///
///     const Verified dem04("rolling", "MFiX DEM04", "closed form; MFiX VVUQ manual 4.4");
///     dem04.near("speed when it rolls", "m/s", ours, 5 * u0 / 7, share(2e-3), "vibration of the tangential spring, mu
///     g/omega_t");
///
/// It expects |ours - reference| <= tolerance, hands the row to `scripts/verify`, which writes the report, and fails
/// when the row of the committed report is missing or holds another figure: the page shows what the program finds. That
/// second expectation keeps the page true and is no evidence of correctness; the reference is.
namespace subsoil::test {

/// A tolerance: a share of the reference, or absolute in the row's unit.
struct Tolerance {
  double share = 0, absolute = 0;
  double of(double reference) const { return share * std::abs(reference) + absolute; }
};
inline Tolerance share(double part) { return {.share = part}; }
inline Tolerance absolute(double amount) { return {.absolute = amount}; }

/// The figures of the committed report by "case | quantity"; "ours" as it is printed.
class CommittedReport {
 public:
  explicit CommittedReport(const std::string& file) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) take(line);
  }
  /// Nothing found: NaN.
  double ours(const std::string& name, const std::string& quantity) const {
    const auto at = figures_.find(name + " | " + quantity);
    return at == figures_.end() ? std::numeric_limits<double>::quiet_NaN() : at->second;
  }

 private:
  /// | case | source | quantity | ours | ...
  void take(const std::string& line) {
    std::string cell[4];
    std::size_t from = 2;
    if (line.rfind("| ", 0) != 0) return;
    for (std::string& c : cell) {
      const std::size_t to = line.find(" | ", from);
      if (to == std::string::npos) return;
      c = line.substr(from, to - from), from = to + 3;
    }
    char* end = nullptr;
    const double figure = std::strtod(cell[3].c_str(), &end);
    if (end != cell[3].c_str()) figures_[cell[0] + " | " + cell[2]] = figure;
  }
  std::map<std::string, double> figures_;
};

/// Whether a figure still agrees with what the committed report prints of it. The report prints two digits beyond the
/// tolerance (at most twelve in all). Instruction sets differ by some ulps that an impact magnifies; a thirtieth of the
/// tolerance is far more than that and far less than what would matter to a reader.
inline bool still_agrees(double ours, double printed, double tolerance) {
  return std::abs(ours - printed) <= tolerance / 30 + 1e-11 * std::abs(ours);
}

/// One verification case.
class Verified {
 public:
  /// @param field section of the report; @param name of the case: a literal, a test looks for it in the sources;
  /// @param source of the reference
  Verified(std::string field, std::string name, std::string source)
      : field_(std::move(field)), name_(std::move(name)), source_(std::move(source)) {}

  /// @param because why the tolerance is what it is, some words; @param at of a sweep: where this was
  void near(const std::string& quantity, const std::string& unit, double ours, double reference, Tolerance tolerance,
            const std::string& because, const std::string& at = "") const {
    expect(quantity, unit, ours, reference, tolerance.of(reference), because, at, Kind::repeatable);
  }
  /// Of many bodies, whose last digits are a matter of chance: the committed figure only has to lie within the
  /// tolerance.
  void near_by_chance(const std::string& quantity, const std::string& unit, double ours, double reference,
                      Tolerance tolerance, const std::string& because) const {
    expect(quantity, unit, ours, reference, tolerance.of(reference), because, "", Kind::by_chance);
  }
  /// A published figure of another program, whose conventions may differ: no agreement is claimed. The row shows the
  /// difference, and "not reproduced" where it exceeds `reading`, to which the figure is printed or was read.
  void compare(const std::string& quantity, const std::string& unit, double ours, double published, double reading,
               const std::string& remark, const std::string& at = "") const {
    expect(quantity, unit, ours, published, reading, remark, at, Kind::comparison);
  }

 private:
  enum class Kind { by_chance = 0, repeatable = 1, comparison = 2 };

  void expect(const std::string& quantity, const std::string& unit, double ours, double reference, double bound,
              const std::string& because, const std::string& at, Kind kind) const {
    if (kind != Kind::comparison) {
      EXPECT_LE(std::abs(ours - reference), bound)
          << name_ << ", " << quantity << ": " << ours << ' ' << unit << ", reference " << reference;
    }
    record(quantity, unit, ours, reference, bound, because, at, kind);
    if (std::getenv("SUBSOIL_VERIFY") != nullptr) return;  // the report is being written
    static const CommittedReport report(subsoil::test::source_dir() + "/docs/verification/index.md");
    const double printed = report.ours(name_, quantity);
    EXPECT_FALSE(std::isnan(printed)) << "docs/verification/index.md has no row `" << name_ << " | " << quantity
                                      << "`: run scripts/verify";
    if (!at.empty()) return;  // where a sweep is worst is a matter of last digits, and so which of its figures this is
    EXPECT_TRUE(std::isnan(printed) || still_agrees(ours, printed, kind == Kind::by_chance ? 30 * bound : bound))
        << "docs/verification/index.md prints " << printed << " for `" << name_ << " | " << quantity
        << "`, the program now finds " << ours << ": run scripts/verify";
  }
  void record(const std::string& quantity, const std::string& unit, double ours, double reference, double bound,
              const std::string& because, const std::string& at, Kind kind) const {
    static int rows = 0;
    char key[24], figures[128];
    std::snprintf(key, sizeof key, "row_%05d", rows++);
    std::snprintf(figures, sizeof figures, "%.17g\t%.17g\t%.17g\t%d", ours, reference, bound, static_cast<int>(kind));
    testing::Test::RecordProperty(key, field_ + '\t' + name_ + '\t' + source_ + '\t' + quantity + '\t' + unit + '\t' +
                                           figures + '\t' + because + '\t' + at);
  }
  std::string field_, name_, source_;
};

/// A curve for the pictures of the report: columns of numbers in FOLDER/NAME.dat, where $SUBSOIL_VERIFY_CURVES names
/// the folder; nothing is written without it.
class VerifiedCurve {
 public:
  explicit VerifiedCurve(const std::string& name) {
    if (const char* const folder = std::getenv("SUBSOIL_VERIFY_CURVES"))
      file_.open(std::string(folder) + '/' + name + ".dat");
  }
  /// Whether points are kept: a sweep for the picture alone is left out otherwise.
  bool drawn() const { return file_.is_open(); }
  template <class... Numbers>
  void point(Numbers... numbers) {
    if (file_.is_open()) ((file_ << numbers << ' '), ...) << '\n';
  }
  /// Ends a line in the picture.
  void gap() {
    if (file_.is_open()) file_ << '\n';
  }

 private:
  std::ofstream file_;
};

/// The row of a sweep in which the difference is largest.
class Worst {
 public:
  void take(const std::string& at, double ours, double reference) {
    const double off = std::abs(ours - reference);
    if (!(off <= off_)) off_ = off, at_ = at, ours_ = ours, reference_ = reference;
  }
  void near(const Verified& verified, const std::string& quantity, const std::string& unit, Tolerance tolerance,
            const std::string& because) const {
    verified.near(quantity, unit, ours_, reference_, tolerance, because, at_);
  }
  void compare(const Verified& verified, const std::string& quantity, const std::string& unit, double reading,
               const std::string& remark) const {
    verified.compare(quantity, unit, ours_, reference_, reading, remark, at_);
  }

 private:
  double off_ = -1, ours_ = std::numeric_limits<double>::quiet_NaN(), reference_ = 0;
  std::string at_;
};

}  // namespace subsoil::test
