#include "libsim/studies/calibrate/store.hpp"

#include <fmt/format.h>

#include <fstream>

#include "libsim/base/deflate.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"

namespace subsoil::sim {
namespace {

constexpr const char* words[] = {"truth", "design", "search"};

std::string mark_of(const Plan& plan) {
  Problems problems;
  std::string text = emit(read_document(plan.scenario, {}, problems));
  for (const PlanParameter& p : plan.parameters) text += p.keys + '|' + p.unit + '|';
  for (const PlanTarget& t : plan.targets) text += t.name() + '|';
  return fmt::format("# scenario, keys and targets {:08x}", crc32(bytes_of(text)));
}

std::string header_of(const Plan& plan) {
  std::string text = "why";
  for (const PlanParameter& p : plan.parameters)
    text += fmt::format(",{}", csv::quoted(p.name + (p.unit.empty() ? "" : fmt::format(" [{}]", p.unit))));
  for (const PlanTarget& t : plan.targets)
    text += fmt::format(",{} [{}],{} error [{}]", t.name(), t.unit, t.name(), t.unit);
  return text + ",failure";
}

std::string line_of(const Evaluation& e) {
  std::string line = words[static_cast<int>(e.why)];
  const auto add = [&line](double value) {
    line += ',';
    csv::append_number(line, value, csv::exact_digits);
  };
  for (const double p : e.parameters) add(p);
  for (std::size_t k = 0; k < e.found.size(); ++k) add(e.found[k]), add(e.error[k]);
  return line + "," + csv::quoted(e.failure);
}

}  // namespace

EvaluationStore::EvaluationStore(std::filesystem::path file, const Plan& plan)
    : file_(std::move(file)),
      mark_(mark_of(plan)),
      header_(header_of(plan)),
      parameters_(plan.parameters.size()),
      targets_(plan.targets.size()) {
  std::ifstream stream(file_);
  if (!stream) return;
  std::string line;
  std::getline(stream, line);
  if (line != mark_)
    throw std::runtime_error(
        file_.string() + ": holds evaluations of another scenario, other keys or other targets; name another folder");
  std::getline(stream, line);
  while (std::getline(stream, line)) {
    const std::vector<std::string> fields = csv::split(line);
    if (fields.size() != 2 + parameters_ + 2 * targets_) continue;
    Evaluation e;
    for (int k = 0; k < 3; ++k)
      if (fields[0] == words[k]) e.why = static_cast<Evaluation::Why>(k);
    std::vector<double> numbers(fields.size() - 2);
    bool whole = true;
    for (std::size_t k = 0; k < numbers.size(); ++k) whole = csv::to_number(fields[k + 1], numbers[k]) && whole;
    if (!whole) continue;
    e.parameters.assign(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(parameters_));
    for (std::size_t k = parameters_; k < numbers.size(); k += 2)
      e.found.push_back(numbers[k]), e.error.push_back(numbers[k + 1]);
    e.failure = fields.back();
    kept_.push_back(std::move(e));
  }
}

std::optional<Evaluation> EvaluationStore::find(Evaluation::Why why, const std::vector<double>& parameters) const {
  const auto same = [why](const Evaluation& e) {
    return (e.why == Evaluation::Why::truth) == (why == Evaluation::Why::truth);
  };
  for (const Evaluation& e : kept_)
    if (e.parameters == parameters && same(e)) return e;
  return {};
}

void EvaluationStore::add(const Evaluation& evaluation) {
  kept_.push_back(evaluation);
  write();
}

void EvaluationStore::write() const {
  std::string text = mark_ + '\n' + header_ + '\n';
  for (const Evaluation& e : kept_) text += line_of(e) + '\n';
  write_atomically(file_, text);
}

}  // namespace subsoil::sim
