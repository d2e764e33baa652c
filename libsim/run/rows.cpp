#include "libsim/run/rows.hpp"

#include <utility>

#include "libsim/run/columns.hpp"

namespace subsoil::sim {
Rows::Rows(const Columns& columns, SeriesWriter& series, double close, double machine_time)
    : columns_(columns), series_(series), close_(close), machine_time_(machine_time), means_(columns.list().size()) {
  last_.assign(columns.list().size(), 0.0);
}

double Rows::between(std::size_t column, double before, double now, double share) const {
  if (columns_.is_whole(column)) return share > 0.5 ? before : now;
  return share * before + (1 - share) * now;
}

void Rows::begin_instant(double t, std::span<const double> values, bool jumps) {
  now_.t = t;
  jumps_ = jumps;
  now_.values.assign(values.begin(), values.end());
  if (std::exchange(begun_, true)) return;
  before_ = machine_before_ = machine_now_ = now_, held_until_ = t;
  machine_before_.t = machine_now_.t = machine_time_;
}

double Rows::share_before(const Point& before, const Point& now, double t) const {
  return now.t - t <= close_ ? 0 : t - before.t <= close_ ? 1 : (now.t - t) / (now.t - before.t);
}

void Rows::add(double t) {
  Point row{t, now_.values};
  const double w = share_before(before_, now_, t);
  for (std::size_t c = 0; c < row.values.size(); ++c) {
    const double share = jumps_ && columns_.is_sum(c) ? 1 : w;
    row.values[c] = between(c, before_.values[c], now_.values[c], share);
  }
  if (w == 0) row.values = now_.values;  // what is not finite too
  if (w > 0 && w < 1) columns_.follow_back(t, row.values, false);
  row.values[0] = t;
  if (columns_.has_means() && t > held_until_) {  // at the first instant of all there is no interval yet
    means_.add(t - held_until_, before_.values);
    held_until_ = t;
    const std::vector<double>& mean = means_.take();
    for (std::size_t c = 0; c < mean.size(); ++c)
      if (columns_.is_mean(c)) row.values[c] = mean[c];
  }
  waiting_.push_back(std::move(row));
}

void Rows::end_instant(bool machine_stands) {
  if (columns_.has_means()) means_.add(now_.t - held_until_, before_.values);
  held_until_ = now_.t;
  if (machine_stands) {
    std::swap(machine_before_, machine_now_);
    machine_now_ = now_;
    for (Point& row : waiting_) {
      const double w = share_before(machine_before_, machine_now_, row.t);
      for (const std::size_t c : columns_.of_machine_instant())
        row.values[c] =
            w > 0 ? between(c, machine_before_.values[c], machine_now_.values[c], w) : machine_now_.values[c];
      columns_.follow_back(w == 0 ? machine_now_.t : row.t, row.values, true);
      columns_.take_watches(row.values);
      series_.write(row.values);
    }
    if (!waiting_.empty()) last_ = std::move(waiting_.back().values);
    waiting_.clear();
  }
  std::swap(before_, now_);
}

void Rows::archive(Archive& a) {
  a("before", before_)("machine before", machine_before_)("machine now", machine_now_)("waiting", waiting_)("means",
                                                                                                            means_);
  a("held until", held_until_)("begun", begun_)("last", last_);
}

}  // namespace subsoil::sim
