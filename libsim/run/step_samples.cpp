#include "libsim/run/step_samples.hpp"

namespace subsoil::sim {

StepSamples::StepSamples(RunOutput& output)
    : o_(output), summarised_(o_.columns.summarised().size()), follows_sums_(o_.columns.history_needs_sums()) {}

void StepSamples::before_step(bool spheres_changed, StepRequest& request) {
  if (request.stop) return;
  const double t = o_.now.t, next = t + o_.simulation.step_length() - o_.close;
  const bool last = o_.now.last;
  spheres_changed_ = spheres_changed;
  // What is due before the next instant is interpolated between this one and that.
  const bool frame = last || o_.frame_due.next() < next,
             sample = last || o_.crossings->needs_sums() || follows_sums_ || o_.sample_due.next() < next;
  o_.now.row = last || o_.sample_due.next() <= t + o_.close;
  stood_ = o_.simulation.window_begins();
  const bool window = stood_ && (o_.rows->wait() || o_.sample_due.next() < t + o_.simulation.window_length());
  request.instant |= sample || window || o_.crossings->any() || o_.columns.needs_every_step();
  request.energies |= sample || window;
  o_.now.energies = request.energies;
  if (!frame) return;
  request.snapshot = o_.frames->begin(t);
  request.contacts = o_.frames->contacts();
}

bool StepSamples::after_step() {
  if (o_.crossings->any()) o_.stops = o_.crossings->look(o_.now.t, o_.values, Crossings::on_a_line);
  write_due();
  return true;
}

void StepSamples::write_due() {
  const double t = o_.now.t;
  const bool signalled = o_.now.last && t < o_.s.time.end - o_.close;
  o_.rows->begin_instant(t, o_.values, spheres_changed_);
  double row = -Schedule::never, frame = row;
  for (; o_.sample_due.next() <= t + o_.close; o_.sample_due.due(row, o_.close))
    o_.rows->add(row = o_.sample_due.next());
  if (signalled && row < t - o_.close) o_.rows->add(t);
  o_.rows->end_instant(stood_ || o_.now.last);
  for (; o_.frame_due.next() <= t + o_.close; o_.frame_due.due(frame, o_.close))
    o_.frames->write(frame = o_.frame_due.next(), o_.steps);
  if (signalled && frame < t - o_.close) o_.frames->write(t, o_.steps);
}

void StepSamples::count_step() {
  const double t = o_.now.t, taken = o_.world.bed ? o_.simulation.step_length() : o_.simulation.time() - t;
  for (std::size_t c = 0; c < summarised_.size(); ++c) summarised_[c] = o_.values[o_.columns.summarised()[c]];
  o_.summary->sample(t + taken, taken, summarised_);
}

}  // namespace subsoil::sim
