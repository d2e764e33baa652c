#include "libsim/studies/wear/wear_study.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/plot/chart.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/studies/sweep/tables.hpp"
#include "libsim/studies/wear/stl.hpp"

namespace subsoil::sim {
namespace {

void refuse_bad_steps(const WearRequest& r) {
  if (r.hectares.empty() == r.passes.empty())
    throw std::invalid_argument("wear: give one of --hectares and --passes: how much the tool is to work");
  double before = 0;
  for (const double one : r.hectares.empty() ? r.passes : r.hectares) {
    if (!std::isfinite(one))
      throw std::invalid_argument(fmt::format("{} {:g}: is no finite number; give how many, such as 10",
                                              r.hectares.empty() ? "--passes" : "--hectares", one));
    if (!(one > before))
      throw std::invalid_argument(fmt::format("{} {:g}: comes after {:g}: steps end above 0, each after the one before",
                                              r.hectares.empty() ? "--passes" : "--hectares", one, before));
    before = one;
  }
  if (!(r.spread >= 0)) throw std::invalid_argument(fmt::format("--spread {:g} m: must be 0 or above", r.spread));
}

/// "10 ha" -> "10ha", of file names.
std::string joined(const std::string& label) {
  std::string out;
  for (const char c : label)
    if (c != ' ') out += c;
  return out;
}

std::vector<WearStep> steps_of(const WearRequest& r, const std::optional<WorkedStrip>& strip) {
  std::vector<WearStep> out;
  for (const double h : r.hectares) out.push_back({fmt::format("{:g} ha", h), h / strip->hectares(), h, {}});
  for (const double n : r.passes)
    out.push_back({fmt::format("{:g} pass{}", n, n == 1 ? "" : "es"), n, strip ? n * strip->hectares() : NAN, {}});
  return out;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Wearing {
 public:
  explicit Wearing(const WearRequest& request)
      : r_(request), folder_(std::filesystem::absolute(request.out)), base_(read_run_folder(request.run)) {
    result_.surfaces = worn_surfaces(base_, r_.law);
    if (!r_.hectares.empty() || (r_.width && r_.length)) result_.strip = worked_strip(base_, r_.width, r_.length);
    result_.steps = steps_of(r_, result_.strip);
    std::filesystem::create_directories(folder_);
  }

  WearResult from_one_run() {
    for (WearStep& step : result_.steps) {
      wear(step, result_.surfaces, step.passes, nullptr);
      write(step, true);
    }
    write_csv();
    return std::move(result_);
  }

  WearResult from_a_run_each() {
    const StudyLock lock(folder_);
    begin_study();
    result_.steps.insert(result_.steps.begin(), new_tool());
    std::vector<WornSurface> surfaces = result_.surfaces;
    std::string failure;
    for (std::size_t k = 0; k + 1 < result_.steps.size() && failure.empty(); ++k) {
      const WearStep& before = result_.steps[k];
      WearStep& step = result_.steps[k + 1];
      wear(step, surfaces, step.passes - before.passes, &before);
      if (!run(step, k)) {
        result_.interrupted = true;
        return std::move(result_);
      }
      const PointResult point = read_result(study_, folder_, k);
      step.value = point.value, step.half_width = point.half_width;
      if (point.end != PointResult::End::reached) {
        failure = fmt::format("the run with the tool after {} failed: {}", step.label, point.cause);
        result_.steps.resize(k + 2);
        break;
      }
      surfaces = worn_surfaces(read_run_folder(point_folder(folder_, k)), r_.law);
    }
    write_csv();
    write_study();
    if (!failure.empty()) throw std::runtime_error(failure);
    return std::move(result_);
  }

 private:
  /// @param before state from which the surfaces come; null: new
  void wear(WearStep& step, const std::vector<WornSurface>& surfaces, double passes, const WearStep* before) {
    for (std::size_t k = 0; k < surfaces.size(); ++k) {
      const WornSurface& one = surfaces[k];
      std::vector<double> volumes = one.volumes;
      for (double& v : volumes) v *= passes;
      try {
        const Recession receded = recede(one.mesh, volumes, r_.spread);
        WornState state{.name = one.name, .file = folder_ / fmt::format("{}-{}.stl", one.name, joined(step.label))};
        state.volume = passes * one.volume + (before == nullptr ? 0 : before->surfaces[k].volume);
        state.mass = one.density * state.volume;
        state.by = recessed(result_.surfaces[k].mesh, receded.mesh);
        step.surfaces.push_back(state);
        meshes_.push_back(stl_text(receded.mesh, one.name));
      } catch (const RecessionLimit& limit) {
        const double most = (before == nullptr ? 0 : before->passes) + limit.share * passes;
        throw std::invalid_argument(fmt::format("{} after {}: {}; it lasts {}", one.name, step.label, limit.what(),
                                                r_.hectares.empty()
                                                    ? fmt::format("{:.2g} passes", most)
                                                    : fmt::format("{:.2g} ha", most * step.hectares / step.passes)));
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(fmt::format("{} after {}: {}", one.name, step.label, error.what()));
      }
    }
  }

  std::vector<std::string> files_of(const WearStep& step) const {
    std::vector<std::string> files;
    for (const WornState& s : step.surfaces) files.push_back(s.file.string());
    return files;
  }

  /// Meshes and a scenario with them. `over`: files that are there and others are written over; else they are refused.
  void write(WearStep& step, bool over) {
    for (std::size_t k = 0; k < step.surfaces.size(); ++k) {
      const std::filesystem::path& file = step.surfaces[k].file;
      if (!over && text_of(file) != meshes_[k])
        throw ScenarioError(
            fmt::format("{}: was worn by another request, and its run is done; name another --out", file.string()));
      write_atomically(file, meshes_[k]);
    }
    meshes_.clear();
    step.scenario = folder_ / fmt::format("worn-{}.yaml", joined(step.label));
    write_atomically(step.scenario, write_scenario(with_meshes(*base_.scenario, result_.surfaces, files_of(step))));
  }

  WearStep new_tool() const {
    WearStep out{.label = "new", .hectares = result_.strip ? 0 : NAN};
    for (const WornSurface& one : result_.surfaces) out.surfaces.push_back({.name = one.name});
    for (const SweepNumber& n : study_.numbers) {
      const NumberOfRun number = take_number(base_, n);
      out.value.push_back(number.value), out.half_width.push_back(number.half_width);
    }
    return out;
  }

  void begin_study() {
    const Scenario& scenario = *base_.scenario;
    study_.title = "wear of " + base_.name;
    study_.scenario = std::filesystem::absolute(r_.run / "scenario.yaml").string();
    study_.parameters = {r_.hectares.empty() ? "passes" : "hectares"};
    study_.numbers = usual_numbers(scenario);
    study_.keep = Keep::all;
    for (const double at : r_.hectares.empty() ? r_.passes : r_.hectares)
      study_.points.push_back({{fmt::format("{:g}", at)}, {at}, {}});
    for (const SweepNumber& n : study_.numbers) result_.numbers.push_back(with_unit(n.name, unit_of(base_, n)));
  }

  /// False: a signal came.
  bool run(WearStep& step, std::size_t k) {
    // The meshes have to be there before the scenario that names them is read.
    const bool done = std::filesystem::exists(point_folder(folder_, k) / "point.json");
    write(step, !done);
    study_.points[k].sets = sets_of_meshes(*base_.scenario, result_.surfaces, files_of(step));
    if (!point_is_open(study_, folder_, k, true)) return true;
    return run_points(study_, folder_, {k}, r_.pool);
  }

  void write_csv() const {
    std::string text =
        "hectares,passes,surface,volume [m3],mass [kg],maximum depth [m],mean depth [m],worn area [m2],farthest vertex "
        "[m]";
    for (const SweepNumber& n : study_.numbers) {
      const std::string unit = unit_of(base_, n);
      text += ',' + csv::quoted(with_unit(n.name, unit)) + ',' + csv::quoted(with_unit(n.name + " half width", unit));
    }
    const auto add = [&](double v) {
      if (std::isfinite(v)) csv::append_number(text, v, csv::exact_digits);
      text += ',';
    };
    text += '\n';
    for (const WearStep& step : result_.steps)
      for (const WornState& s : step.surfaces) {
        add(step.hectares), add(step.passes);
        text += csv::quoted(s.name) + ',';
        add(s.volume), add(s.mass), add(s.by.deepest), add(s.mean_depth()), add(s.by.area), add(s.by.farthest);
        for (std::size_t n = 0; n < result_.numbers.size(); ++n)
          add(n < step.value.size() ? step.value[n] : NAN), add(n < step.value.size() ? step.half_width[n] : NAN);
        text.back() = '\n';
      }
    write_atomically(folder_ / "wear.csv", text);
  }

  void write_study() const {
    const std::vector<PointResult> results = read_results(study_, folder_);
    write_tables(study_, results, folder_);
    write_sweep_page(sweep_json(study_, results, {}), folder_ / "sweep.html");
    if (study_.numbers.empty()) return;
    ChartCurve mean, low, high;
    mean.name = "mean", low.name = "95 %", low.style = high.style = ChartCurve::Style::dashed;
    for (const WearStep& step : result_.steps) {
      if (step.value.empty() || !std::isfinite(step.value[0])) continue;
      const double x = r_.hectares.empty() ? step.passes : step.hectares;
      mean.x.push_back(x), mean.y.push_back(step.value[0]);
      if (!std::isfinite(step.half_width[0])) continue;
      low.x.push_back(x), low.y.push_back(step.value[0] - step.half_width[0]);
      high.x.push_back(x), high.y.push_back(step.value[0] + step.half_width[0]);
    }
    ChartCurve dots = mean;
    dots.name.clear(), dots.style = ChartCurve::Style::dots;
    Chart chart;
    chart.title = study_.title;
    chart.x_label = r_.hectares.empty() ? "passes" : "worked [ha]", chart.y_label = result_.numbers[0];
    chart.curves = {mean, dots, low, high};
    draw_chart(chart, folder_ / ("wear." + r_.pictures));
  }

  const WearRequest& r_;
  std::filesystem::path folder_;
  RunFolder base_;
  WearResult result_;
  Study study_;
  std::vector<std::string> meshes_;  ///< text of a step's STL files
};

}  // namespace

WearResult wear_study(const WearRequest& request) {
  refuse_bad_steps(request);
  Wearing wearing(request);
  return request.repeat ? wearing.from_a_run_each() : wearing.from_one_run();
}

}  // namespace subsoil::sim
