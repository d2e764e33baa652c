#include "libsim/io/series_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "libsim/io/csv.hpp"

namespace subsoil::sim {

SeriesWriter::SeriesWriter(const std::filesystem::path& path, const std::vector<SeriesColumn>& columns, int digits,
                           std::optional<std::uint64_t> keep)
    : columns_(columns.size()), digits_(digits), file_(path, keep), flushed_(std::chrono::steady_clock::now()) {
  if (keep) return;
  for (const auto& column : columns) {
    if (!rows_.empty()) rows_ += ',';
    rows_ += csv::quoted(column.label());
  }
  rows_ += '\n';
  flush();
}

SeriesWriter::~SeriesWriter() {
  try {
    flush();
  } catch (const DiskFault&) {
    // Whoever wants to know asks for it.
  }
}

void SeriesWriter::write(std::span<const double> values) {
  if (values.size() != columns_)
    throw std::invalid_argument(fmt::format("series row: {} values for {} columns", values.size(), columns_));
  bool first = true;
  for (const double value : values) {
    if (!std::exchange(first, false)) rows_ += ',';
    csv::append_number(rows_, value, digits_);
  }
  rows_ += '\n';
  constexpr std::size_t many = 1 << 16;
  if (rows_.size() > many || std::chrono::steady_clock::now() - flushed_ > std::chrono::seconds(1)) flush();
}

void SeriesWriter::flush() {
  // What cannot be written is not tried again: half of it may be there.
  const std::string rows = std::exchange(rows_, {});
  file_.write(rows);
  flushed_ = std::chrono::steady_clock::now();
}

std::uint64_t SeriesWriter::sync() {
  flush();
  file_.sync();
  return file_.size();
}

void IntervalMean::add(double duration, std::span<const double> values) {
  duration_ += duration;
  for (std::size_t i = 0; i < sum_.size(); ++i) sum_[i] += duration * values[i];
}

const std::vector<double>& IntervalMean::take() {
  if (duration_ > 0)
    for (std::size_t i = 0; i < sum_.size(); ++i) mean_[i] = sum_[i] / duration_;
  std::fill(sum_.begin(), sum_.end(), 0.0);
  duration_ = 0;
  return mean_;
}

}  // namespace subsoil::sim
