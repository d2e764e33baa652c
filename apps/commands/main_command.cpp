#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <iostream>

#include "apps/commands/command_pages.hpp"
#include "apps/commands/commands.hpp"
#include "apps/commands/design_command.hpp"
#include "apps/commands/export_command.hpp"
#include "apps/commands/fields_command.hpp"
#include "apps/commands/fmu_command.hpp"
#include "apps/commands/plan_options.hpp"
#include "apps/commands/report_command.hpp"
#include "apps/commands/sweep_command.hpp"
#include "apps/commands/templates.hpp"
#include "apps/commands/version_text.hpp"
#include "apps/commands/view_command.hpp"
#include "apps/commands/wear_command.hpp"
#include "libsim/document/library.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/plot/furrow_picture.hpp"
#include "libsim/plot/movie.hpp"
#include "libsim/plot/plot.hpp"
#include "libsim/plot/strip.hpp"
#include "libsim/run/column_table.hpp"
#include "libsim/run/resume.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/studies/laboratory/tests.hpp"

namespace subsoil::sim {
namespace {

void add_scenario(CLI::App& command, RunRequest& request, std::string& simd) {
  command.add_option("scenario", request.scenario, "scenario file (YAML)")->required()->type_name(takes_yaml);
  command.add_option("--set", request.sets, "override a value of the scenario: path=value (may be repeated)")
      ->allow_extra_args(false)
      ->type_name("PATH=VALUE");
  command
      .add_option("--threads", request.threads,
                  "threads of the bed; default: as the scenario says, else one per 1,000 spheres, at most all cores")
      ->check(CLI::Range(1, 1024));
  command.add_option("--simd", simd, "instruction set")->type_name(takes_simd);
}

/// `subsoil plot`: what it was asked to draw.
struct PlotRequest {
  std::vector<std::filesystem::path> runs;
  std::filesystem::path picture = "plot.png";
  PlotOptions curves;
  StripOptions strip;
  bool furrow = false;
  std::filesystem::path film;
  MovieOptions movie;
};

void add_plot(CLI::App& command, PlotRequest& request) {
  command.add_option("runs", request.runs, "result directories")->required()->type_name(takes_folder);
  command.add_option("--out", request.picture, "picture: .png, .svg or .pdf");
  CLI::Option* columns =
      command.add_option("--columns", request.curves.columns, "columns of series.csv to draw instead")->delimiter(',');
  command.add_option("--over", request.curves.over, "column to draw over instead of time: blade.y, a travel ...");
  command
      .add_option("--strip", request.strip.count,
                  "draw the mechanism at so many instants instead; of modes: so many shapes")
      ->check(CLI::PositiveNumber)
      ->excludes(columns);
  command.add_option("--times", request.strip.times, "instants of the strip, s")->delimiter(',')->excludes(columns);
  command
      .add_option("--paths", request.strip.paths, "markers and bodies whose paths the strip shows; default: markers")
      ->delimiter(',');
  command
      .add_flag("--furrow", request.furrow,
                "draw the cross-section that the pass left: surface before and after, displacement, porosity")
      ->excludes(columns);
  command.add_option("--follow", request.strip.follow, "body that stays in its place in the strip");
  command.add_option("--movie", request.film, "make a film of the frames instead: .mp4 or .webm (by ffmpeg)")
      ->excludes(columns);
  command.add_option("--rate", request.movie.rate, "pictures of the film per second; default: 25")
      ->check(CLI::Range(0.1, 240.0));
}

void draw(const PlotRequest& request, bool strip_wanted) {
  if (request.furrow) {
    if (strip_wanted || request.runs.size() != 1)
      throw std::invalid_argument("--furrow: draws one run and nothing else; name a single result directory");
    draw_furrow(request.runs.front(), request.picture);
    std::cout << request.picture.string() << "\n";
    return;
  }
  if (!request.film.empty()) {
    if (strip_wanted || request.runs.size() != 1)
      throw std::invalid_argument("--movie: films one run and draws nothing else; name a single result directory");
    MovieOptions options = request.movie;
    options.follow = request.strip.follow;
    movie(request.runs.front(), request.film, options);
    std::cout << request.film.string() << "\n";
    return;
  }
  if (strip_wanted && request.runs.size() != 1)
    throw std::invalid_argument("--strip: draws one run; name a single result directory");
  if (strip_wanted || (request.runs.size() == 1 && request.curves.columns.empty() && is_still(request.runs.front())))
    strip(request.runs.front(), request.picture, request.strip);
  else
    plot(request.runs, request.picture, request.curves);
  std::cout << request.picture.string() << "\n";
}

CLI::App* add_impact(CLI::App& app, ImpactRequest& request) {
  CLI::App* word = app.add_subcommand("impact", "one impact of two bodies, or of a body and the ground, by a model");
  word->allow_extras();
  word->footer(
      "subsoil impact [FILE.yaml] [--KEY VALUE ...]: every key of the file may stand as a flag, as in\n  subsoil "
      "impact --model hunt-crossley --c \"1.7135e10 N/m^1.5\" --b "
      "\"0.1 s/m\"\n  --mass \"0.1 kg\" --speed \"0.5 2 5 m/s\". Keys: docs/reference/keys.md; models: "
      "docs/reference/impact.md");
  word->add_option("--out", request.out, "folder for tables, x(t), v(t), F(t) and pictures; left out: print only");
  word->add_option("--pictures", request.pictures, "kind of the pictures in it")
      ->check(CLI::IsMember({"svg", "png", "pdf"}));
  word->add_option("--fit", request.data, "CSV of measured impacts: find the model's parameters from it")
      ->check(CLI::ExistingFile);
  word->add_option("--free", request.free, "parameters that the fit may move, such as b,c")->delimiter(',');
  word->add_option("--set", request.sets, "override a value of the file: path=value")
      ->allow_extra_args(false)
      ->type_name("PATH=VALUE");
  return word;
}

CLI::App* add_test(CLI::App& app, TestRequest& request) {
  CLI::App* word = app.add_subcommand("test", "one laboratory test of a scenario's material: repose, shear, ...");
  word->footer(
      "Sizes, loads and packings stand in the section `test` of the scenario, or in --set, as in\n  subsoil test "
      "shear configs/laboratory/dry.yaml --set \"test.shear.loads=2 4 8 kPa\". Keys: docs/reference/keys.md; tests: "
      "docs/reference/laboratory-tests.md");
  word->add_option("test", request.test, "which test")->required()->check(CLI::IsMember(test_words()));
  word->add_option("scenario", request.scenario, "scenario file (YAML)")->required()->type_name(takes_yaml);
  word->add_option("--set", request.sets, "override a value of the scenario: path=value (may be repeated)")
      ->allow_extra_args(false)
      ->type_name("PATH=VALUE");
  word->add_option("--out", request.out, "folder for tables, curves and pictures; left out: print only");
  word->add_option("--pictures", request.pictures, "kind of the pictures in it")
      ->check(CLI::IsMember({"svg", "png", "pdf"}));
  word->add_option("--threads", request.threads, "specimens side by side; default: all cores")
      ->check(CLI::PositiveNumber);
  return word;
}

CLI::App* add_calibrate(CLI::App& app, CalibrateRequest& request) {
  CLI::App* word = app.add_subcommand("calibrate", "find contact parameters that meet measured laboratory tests");
  word->footer(
      "Evaluations are kept in the folder: the same command goes on where it was stopped. Keys: "
      "docs/reference/keys.md; method: docs/reference/calibrate.md");
  add_plan_options(*word, request, "scenario, parameters, targets");
  word->add_option("--pictures", request.pictures, "kind of the pictures in it")
      ->check(CLI::IsMember({"svg", "png", "pdf"}));
  word->add_option("--threads", request.threads, "specimens side by side; default: all cores")
      ->check(CLI::PositiveNumber);
  return word;
}

/// `subsoil new`: which scenario to start from.
struct NewRequest {
  std::string name;
  bool list = false;
  std::filesystem::path out;
};

CLI::App* add_new(CLI::App& app, NewRequest& request) {
  CLI::App* word = app.add_subcommand("new", "print a scenario to start from: one that shows every key, or a template");
  word->add_option("template", request.name, "tine, rotor, wheel, ...: see --list; left out: every key commented")
      ->type_name(template_words());
  word->add_flag("--list", request.list, "list the templates");
  word->add_option("--out", request.out, "file to write it to, with the STL file that it names; left out: print it");
  return word;
}

void write_new(const std::filesystem::path& path, std::string_view text) {
  if (std::filesystem::exists(path))
    throw ScenarioError(path.string() + ": exists; choose another --out, or remove it");
  write_atomically(path, std::string(text));
  std::cout << path.string() << "\n";
}

void print_new(const NewRequest& request) {
  if (request.list) {
    std::cout << template_list();
    return;
  }
  const std::string all_keys = request.name.empty() ? new_scenario() : "";
  const Template chosen = request.name.empty() ? Template{"", all_keys, ""} : template_of(request.name);
  const std::string text = with_schema_line(chosen.scenario, std::filesystem::read_symlink("/proc/self/exe"));
  if (request.out.empty()) {
    std::cout << text;
    if (!chosen.mesh.empty())
      std::cerr << "it names " << chosen.name << ".stl: `subsoil new " << chosen.name << " --out " << chosen.name
                << ".yaml` writes both\n";
    return;
  }
  if (!chosen.mesh.empty()) write_new(request.out.parent_path() / (std::string(chosen.name) + ".stl"), chosen.mesh);
  write_new(request.out, text);
}

/// `subsoil reference`: which page.
struct ReferenceRequest {
  bool columns = false, man = false;
  std::string schema = "scenario", shell = "bash";
};

CLI::App* add_reference(CLI::App& app, ReferenceRequest& request) {
  CLI::App* word = app.add_subcommand("reference", "print the reference of all scenario keys (docs/reference/keys.md)");
  word->add_flag("--columns", request.columns, "print what the columns of series.csv are instead");
  word->add_option("--schema", request.schema,
                   "print a JSON Schema for editors instead: of a scenario (left out), of a part that scenarios "
                   "include, or of the file of a command")
      ->expected(0, 1)
      ->default_str("scenario")
      ->check(CLI::IsMember(schema_names()));
  word->add_option("--completion", request.shell, "print a script that completes command lines in this shell instead")
      ->expected(0, 1)
      ->default_str("bash")
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  word->add_flag("--man", request.man, "print the manual page subsoil(1) instead");
  return word;
}

std::string reference_text(const CLI::App& app, const CLI::App& word, const ReferenceRequest& request) {
  if (word.count("--schema") > 0) return schema_text(request.schema);
  if (word.count("--completion") > 0)
    return request.shell == "zsh"    ? zsh_completion(app)
           : request.shell == "fish" ? fish_completion(app)
                                     : bash_completion(app);
  if (request.man) return man_page(app);
  return request.columns ? columns_markdown() : reference_markdown();
}

/// Runs one command; faults become messages and exit codes here and nowhere else.
template <class Command>
int guarded(Command command) {
  try {
    return command();
  } catch (const ScenarioError& error) {
    std::cerr << error.what() << "\n";
    return exit_bad_input;
  } catch (const std::invalid_argument& error) {
    std::cerr << error.what() << "\n";
    return exit_bad_input;
  } catch (const std::exception& error) {
    std::cerr << "failed: " << error.what() << "\n";
    return exit_failed;
  }
}

}  // namespace

int main_command(int argc, char** argv, const EngineMaker& engine) {
  spdlog::set_pattern("%v");
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on the size of files is said by the write that meets it
  CLI::App app{"subsoil: machines working in soil"};
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);

  RunRequest request;
  request.engine = engine;
  std::string simd;
  CLI::App* run_word = app.add_subcommand("run", "run a scenario");
  add_scenario(*run_word, request, simd);
  run_word->add_option("--out", request.out, "directory for the results; default: ./<name of the scenario>");
  run_word->add_flag("--force", request.force, "write over an existing directory");
  run_word->add_flag("--strict", request.strict, "a run that warns of something ends with exit code 3");
  run_word
      ->add_option("--change", request.changes, "with --from: a key that differs from the state's scenario on purpose")
      ->allow_extra_args(false)
      ->type_name("KEY");
  bool looks_on = false;
  run_word->add_flag("--view", looks_on, "serve a picture that follows the run, as `subsoil view DIR --serve` does");
  run_word->add_option("--from", request.from, "start again from a state file of an earlier run");

  CLI::App* resume_word = app.add_subcommand("resume", "go on with a run that was stopped, killed or cut off");
  std::filesystem::path resumed;
  resume_word->add_option("folder", resumed, "its results")->required()->type_name(takes_folder);
  resume_word->add_option("--threads", request.threads, "threads of the bed; default: as the scenario says")
      ->check(CLI::Range(1, 1024));
  resume_word->add_option("--simd", simd, "instruction set")->type_name(takes_simd);
  resume_word->add_flag("--strict", request.strict, "a run that warns of something ends with exit code 3");

  double checkpoint_minutes = 10;
  for (CLI::App* word : {run_word, resume_word})
    word->add_option(
            "--checkpoint-every", checkpoint_minutes,
            "minutes by the clock from one checkpoint, from which `subsoil resume` goes on, to the next; 0: none")
        ->check(CLI::NonNegativeNumber);

  CLI::App* check_word =
      app.add_subcommand("check", "read and try a scenario, say what it would do and cost; writes nothing");
  add_scenario(*check_word, request, simd);

  ShowRequest show_request;
  CLI::App* show_word = add_show(app, show_request);
  ViewWords view_words;
  CLI::App* view_word = add_view(app, view_words);

  std::string path;
  CLI::App* explain_word =
      app.add_subcommand("explain", "unit, default, range and meaning of a key, e.g. soil.bed.radius");
  explain_word->add_option("key", path, "path of the key")->required()->type_name("KEY");

  std::string material;
  CLI::App* materials_word = app.add_subcommand(
      "materials", "the library of soils and other materials: where they are from, what laboratory tests give");
  materials_word->add_option("name", material, "material to tell all about; left out: list them")->type_name("NAME");

  NewRequest new_request;
  CLI::App* new_word = add_new(app, new_request);
  ReferenceRequest reference_request;
  CLI::App* reference_word = add_reference(app, reference_request);

  PlotRequest plot_request;
  CLI::App* plot_word = app.add_subcommand(
      "plot", "draw the monitors of one or more runs over time or --over a column, or a mechanism's positions");
  add_plot(*plot_word, plot_request);

  ImpactRequest impact_request;
  CLI::App* impact_word = add_impact(app, impact_request);

  TestRequest test_request;
  CLI::App* test_word = add_test(app, test_request);
  CalibrateRequest calibrate_request;
  CLI::App* calibrate_word = add_calibrate(app, calibrate_request);

  ReportWords report_words;
  CLI::App* report_word = add_report(app, report_words);
  FieldsWords fields_words;
  CLI::App* fields_word = add_fields(app, fields_words);
  ExportWords export_words;
  CLI::App* export_word = add_export(app, export_words);
  WearWords wear_words;
  CLI::App* wear_word = add_wear(app, wear_words);
  FmuWords fmu_words;
  CLI::App* fmu_word = add_fmu(app, fmu_words);
  SweepRequest sweep_request;
  CLI::App* sweep_word = add_sweep(app, sweep_request);
  DesignRequest optimise_request, sensitivity_request;
  CLI::App* optimise_word = add_optimise(app, optimise_request);
  CLI::App* sensitivity_word = add_sensitivity(app, sensitivity_request);
  CredibilityRequest credibility_request;
  CLI::App* credibility_word = add_credibility(app, credibility_request);

  try {
    app.parse(argc, argv);
    impact_request.words = impact_word->remaining();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? exit_ok : exit_bad_input;
  }
  if (!simd.empty()) request.sets.push_back("simd=" + simd);
  if (looks_on) view_when_opened(request);
  set_checkpoint_interval(60 * checkpoint_minutes);
  return guarded([&]() -> int {
    if (run_word->parsed()) return run(request);
    if (resume_word->parsed()) return resume(resumed, request);
    if (check_word->parsed()) return check_command(request);
    if (show_word->parsed()) return show_command(show_request);
    if (view_word->parsed()) return view_command(view_words);
    if (impact_word->parsed()) return impact_command(impact_request);
    if (test_word->parsed()) return test_command(test_request);
    if (calibrate_word->parsed()) return calibrate_command(calibrate_request);
    if (report_word->parsed()) return report_command(report_words);
    if (fields_word->parsed()) return fields_command(fields_words);
    if (export_word->parsed()) return export_command(export_words);
    if (wear_word->parsed()) return wear_command(wear_words);
    if (fmu_word->parsed()) return fmu_command(fmu_words);
    if (sweep_word->parsed()) return sweep_command(sweep_request);
    if (optimise_word->parsed()) return optimise_command(optimise_request);
    if (sensitivity_word->parsed()) return sensitivity_command(sensitivity_request);
    if (credibility_word->parsed()) return credibility_command(credibility_request);
    if (explain_word->parsed()) std::cout << explain(path);
    if (materials_word->parsed())
      std::cout << (material.empty() ? library_table() : library_text(library_material(material)));
    if (new_word->parsed()) print_new(new_request);
    if (reference_word->parsed()) std::cout << reference_text(app, *reference_word, reference_request);
    if (plot_word->parsed()) draw(plot_request, plot_word->count("--strip") + plot_word->count("--times") > 0);
    return exit_ok;
  });
}

}  // namespace subsoil::sim
