#include "libsim/studies/design/in_step.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace subsoil::sim {
namespace {

/// Ends a search from outside.
struct SearchCalledOff {};

class Rendezvous {
 public:
  explicit Rendezvous(std::size_t count) : seats_(count) {}

  std::vector<Worth> ask(std::size_t search, const std::vector<Design>& places) {
    std::unique_lock lock(mutex_);
    Seat& seat = seats_[search];
    seat.places = places, seat.waits = true;
    changed_.notify_all();
    changed_.wait(lock, [&] { return !seat.waits || off_; });
    if (off_) throw SearchCalledOff();
    return std::move(seat.worths);
  }

  void end(std::size_t search, std::exception_ptr fault) {
    const std::scoped_lock lock(mutex_);
    seats_[search].ended = true;
    if (fault && !fault_) fault_ = fault, off_ = true;
    changed_.notify_all();
  }

  /// Questions of all that search; none when all have ended or one has failed.
  std::vector<Question> wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] {
      return off_ || std::all_of(seats_.begin(), seats_.end(), [](const Seat& s) { return s.ended || s.waits; });
    });
    std::vector<Question> questions;
    for (std::size_t k = 0; k < seats_.size() && !off_; ++k)
      if (!seats_[k].ended) questions.push_back({k, seats_[k].places});
    return questions;
  }

  void answer(const std::vector<Question>& questions, std::vector<std::vector<Worth>> worths) {
    const std::scoped_lock lock(mutex_);
    for (std::size_t i = 0; i < questions.size(); ++i) {
      Seat& seat = seats_[questions[i].search];
      seat.worths = std::move(worths[i]), seat.waits = false;
    }
    changed_.notify_all();
  }

  void call_off() {
    const std::scoped_lock lock(mutex_);
    off_ = true;
    changed_.notify_all();
  }
  std::exception_ptr fault() const { return fault_; }

 private:
  struct Seat {
    std::vector<Design> places;
    std::vector<Worth> worths;
    bool waits = false, ended = false;
  };
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Seat> seats_;
  bool off_ = false;
  std::exception_ptr fault_;
};

}  // namespace

void search_in_step(std::size_t count, const std::function<void(std::size_t, const Ask&)>& search,
                    const std::function<std::vector<std::vector<Worth>>(const std::vector<Question>&)>& answer) {
  Rendezvous rendezvous(count);
  std::vector<std::jthread> threads;
  for (std::size_t k = 0; k < count; ++k)
    threads.emplace_back([&, k] {
      std::exception_ptr fault;
      try {
        search(k, [&rendezvous, k](const std::vector<Design>& places) { return rendezvous.ask(k, places); });
      } catch (const SearchCalledOff&) {
      } catch (...) {
        fault = std::current_exception();
      }
      rendezvous.end(k, fault);
    });
  try {
    for (std::vector<Question> q = rendezvous.wait(); !q.empty(); q = rendezvous.wait())
      rendezvous.answer(q, answer(q));
  } catch (...) {
    rendezvous.call_off();
    throw;  // the threads are joined on the way
  }
  threads.clear();
  if (rendezvous.fault()) std::rethrow_exception(rendezvous.fault());
}

}  // namespace subsoil::sim
