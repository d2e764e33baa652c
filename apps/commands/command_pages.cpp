#include "apps/commands/command_pages.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <vector>

#include "libsim/base/version.hpp"

namespace subsoil::sim {
namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<const CLI::Option*> arguments_of(const CLI::App& command, bool by_place) {
  return command.get_options([&](const CLI::Option* option) { return option->get_positional() == by_place; });
}

bool is_flag(const CLI::Option& option) { return option.get_items_expected_max() == 0; }

std::string long_name(const CLI::Option& option) { return "--" + option.get_lnames().front(); }

/// The words of `{svg,png,pdf}` in a type's name, blanks between; empty: any text.
std::string words_of_type(const std::string& type) {
  const std::size_t open = type.find('{'), close = type.rfind('}');
  if (open == std::string::npos || close == std::string::npos) return {};
  std::string words = type.substr(open + 1, close - open - 1);
  std::replace(words.begin(), words.end(), ',', ' ');
  return words;
}

// ---- completion ----------------------------------------------------------------------------------------------------

/// What the script below does with a value.
std::string kind_of(const CLI::Option& option) {
  const std::string type = option.get_type_name(), words = words_of_type(type);
  if (!words.empty()) return fmt::format("kind=words words='{}'", words);
  if (type == takes_yaml) return "kind=yaml";
  if (type == takes_folder) return "kind=folder";
  return type.starts_with("TEXT") ? "kind=file" : "kind=number";
}

constexpr const char* completion_head =
    R"(# bash completion of subsoil, printed by `subsoil reference --completion bash`

# _subsoil_option COMMAND OPTION: what its value is; fails for a flag.
_subsoil_option() {
  case "$1 $2" in
)";

constexpr const char* completion_arguments = R"(    *) return 1 ;;
  esac
}

# _subsoil_argument COMMAND PLACE: what stands there, counted from 0.
_subsoil_argument() {
  case "$1 $2" in
)";

constexpr const char* completion_options = R"(    *) kind=file ;;
  esac
}

_subsoil_options_of() {
  case "$1" in
)";

constexpr const char* completion_tail = R"(  esac
}

_subsoil() {
  local cur=${COMP_WORDS[COMP_CWORD]} command= place=0 kind= words= i
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; ++i)); do
    if [[ -z $command ]]; then
      [[ ${COMP_WORDS[i]} == -* ]] || command=${COMP_WORDS[i]}
    elif [[ ${COMP_WORDS[i]} == -* ]]; then
      _subsoil_option "$command" "${COMP_WORDS[i]}" && ((++i))
    else
      ((++place))
    fi
  done
  if ((i == COMP_CWORD)); then  # not the value of an option
    kind=words
    if [[ $cur == -* || -z $command ]]; then
      words=$(_subsoil_options_of "$command")
    else
      _subsoil_argument "$command" "$place"
    fi
  fi
  case $kind in
    words) mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur") ;;
    file) compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen -f -- "$cur") ;;
    folder) compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen -d -- "$cur") ;;
    yaml)
      compopt -o filenames 2>/dev/null
      mapfile -t COMPREPLY < <(compgen -f -X '!*.yaml' -- "$cur"; compgen -f -X '!*.yml' -- "$cur"; compgen -d -- "$cur")
      ;;
  esac
} && complete -F _subsoil subsoil
)";

std::string option_names(const CLI::App& app) {
  std::string names;
  for (const CLI::Option* option : arguments_of(app, false)) names += " " + long_name(*option);
  return names;
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  std::string options, places, names, commands;
  for (const CLI::App* command : commands_of(app)) {
    const std::string& word = command->get_name();
    commands += " " + word;
    names += fmt::format("    {}) echo '{}' ;;\n", word, option_names(*command).substr(1));
    for (const CLI::Option* option : arguments_of(*command, false))
      if (!is_flag(*option)) options += fmt::format("    '{} {}') {} ;;\n", word, long_name(*option), kind_of(*option));
    int place = 0;
    for (const CLI::Option* argument : arguments_of(*command, true)) {
      const bool many = argument->get_items_expected_max() > 1;
      places += fmt::format("    '{} '{}) {} ;;\n", word, many ? "*" : std::to_string(place++), kind_of(*argument));
    }
  }
  names += fmt::format("    '') echo '{}{}' ;;\n", commands.substr(1), option_names(app));
  return completion_head + options + completion_arguments + places + completion_options + names + completion_tail;
}

// ---- zsh -----------------------------------------------------------------------------------------------------------

namespace {

/// Text inside single quotes of a shell, with `marks` behind a backslash.
std::string quoted(const std::string& text, const std::string& marks) {
  std::string out;
  for (const char c : text.substr(0, text.find('\n'))) {
    if (marks.find(c) != std::string::npos) out += '\\';
    out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return out;
}

std::string zsh_action(const CLI::Option& option) {
  const std::string type = option.get_type_name(), words = words_of_type(type);
  if (!words.empty()) return "(" + words + ")";
  if (type == takes_yaml) return "_files -g \"*.(yaml|yml)\"";
  if (type == takes_folder) return "_files -/";
  return type.starts_with("TEXT") ? "_files" : "";
}

/// The specification of `_arguments` for each option and argument of a command.
std::string zsh_arguments(const CLI::App& command) {
  std::string lines;
  for (const CLI::Option* option : arguments_of(command, false)) {
    lines += fmt::format(" \\\n        '{}[{}]", long_name(*option), quoted(option->get_description(), "[]:\\"));
    lines += is_flag(*option) ? "'" : fmt::format(":value:{}'", zsh_action(*option));
  }
  int place = 0;
  for (const CLI::Option* argument : arguments_of(command, true)) {
    const std::string at = argument->get_items_expected_max() > 1 ? "*" : std::to_string(++place);
    lines += fmt::format(" \\\n        '{}:{}:{}'", at, quoted(argument->get_name(true), ":\\"), zsh_action(*argument));
  }
  return lines;
}

/// `complete` of each option of a command, where `where` holds.
std::string fish_options(const CLI::App& command, const std::string& where) {
  std::string lines;
  for (const CLI::Option* option : arguments_of(command, false)) {
    lines += fmt::format("complete -c subsoil -n '{}' -l {} -d '{}'", where, option->get_lnames().front(),
                         quoted(option->get_description(), "\\"));
    const std::string type = option->get_type_name(), words = words_of_type(type);
    if (is_flag(*option))
      lines += "\n";
    else if (!words.empty())
      lines += fmt::format(" -x -a '{}'\n", words);
    else if (type == takes_folder)
      lines += " -x -a '(__fish_complete_directories)'\n";
    else if (type == takes_yaml)
      lines += " -x -a '(__fish_complete_suffix .yaml)'\n";
    else
      lines += type.starts_with("TEXT") ? " -r -F\n" : " -x\n";
  }
  return lines;
}

constexpr const char* fish_head = R"(# fish completion of subsoil, printed by `subsoil reference --completion fish`

function __subsoil_needs_command
    for word in (commandline -opc)[2..-1]
        string match -q -- '-*' $word; or return 1
    end
    return 0
end

)";

}  // namespace

std::string zsh_completion(const CLI::App& app) {
  std::string commands, cases;
  for (const CLI::App* command : commands_of(app)) {
    const std::string& word = command->get_name();
    commands += fmt::format(" \\\n    '{}:{}'", word, quoted(command->get_description(), ":\\"));
    cases += fmt::format("    {})\n      _arguments{}\n      ;;\n", word, zsh_arguments(*command));
  }
  return "#compdef subsoil\n# zsh completion of subsoil, printed by `subsoil reference --completion zsh`\n\n"
         "_subsoil() {\n  local curcontext=$curcontext state line\n  typeset -A opt_args\n  local -a commands\n"
         "  commands=(" +
         commands +
         ")\n"
         "  _arguments -C" +
         zsh_arguments(app) +
         " \\\n        '1:command:->command' '*::argument:->argument'\n"
         "  case $state in\n    command) _describe command commands; return ;;\n  esac\n"
         "  case $words[1] in\n" +
         cases + "  esac\n}\n\n_subsoil \"$@\"\n";
}

std::string fish_completion(const CLI::App& app) {
  std::string script =
      std::string(fish_head) + "complete -c subsoil -f\n" + fish_options(app, "__subsoil_needs_command");
  for (const CLI::App* command : commands_of(app)) {
    const std::string& word = command->get_name();
    const std::string where = "__fish_seen_subcommand_from " + word;
    script += fmt::format("complete -c subsoil -n __subsoil_needs_command -a {} -d '{}'\n", word,
                          quoted(command->get_description(), "\\"));
    script += fish_options(*command, where);
    for (const CLI::Option* argument : arguments_of(*command, true)) {
      const std::string type = argument->get_type_name(), words = words_of_type(type);
      const std::string what = !words.empty()         ? words
                               : type == takes_yaml   ? "(__fish_complete_suffix .yaml)"
                               : type == takes_folder ? "(__fish_complete_directories)"
                                                      : "";
      script += fmt::format("complete -c subsoil -n '{}' {}\n", where, what.empty() ? "-F" : "-a '" + what + "'");
    }
  }
  return script;
}

// ---- manual page ---------------------------------------------------------------------------------------------------

namespace {

/// Text as roff prints it: no line begins with a request.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool begins = out.empty() || out.back() == '\n';
    if (begins && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') out += "\\e";
    if (c == '-') out += '\\';
    if (c == '\'' && !begins)
      out += "\\(aq";
    else if (c == '"')
      out += "\\(dq";
    else if (c == '`')
      out += "\\(ga";
    else if (c == '~')
      out += "\\(ti";
    else if (c == '^')
      out += "\\(ha";
    else if (c != '\\')
      out += c;
  }
  return out;
}

/// Lines are sentences; a blank at their ends is none's.
std::string paragraphs(const std::string& text) {
  std::string out;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::size_t first = text.find_first_not_of(' ', begin);
    if (first < end) out += roff(text.substr(first, end - first)) + "\n";
    begin = end + 1;
  }
  return out;
}

std::string shown_type(const CLI::Option& option) {
  const std::string words = words_of_type(option.get_type_name());
  if (words.empty()) return option.get_type_name().substr(0, option.get_type_name().find(':'));
  std::string shown = words;
  std::replace(shown.begin(), shown.end(), ' ', '|');
  return shown;
}

std::string argument_names(const CLI::App& command) {
  std::string names;
  for (const CLI::Option* argument : arguments_of(command, true)) {
    const std::string name = argument->get_name(true) + (argument->get_items_expected_max() > 1 ? "..." : "");
    names += argument->get_required() ? " " + name : " [" + name + "]";
  }
  return names;
}

std::string options_page(const CLI::App& command) {
  std::string page;
  for (const CLI::Option* argument : arguments_of(command, true))
    page += fmt::format(".TP\n.I {}\n{}", roff(argument->get_name(true)), paragraphs(argument->get_description()));
  for (const CLI::Option* option : arguments_of(command, false)) {
    if (option->get_lnames().front() == "help") continue;
    page += fmt::format(".TP\n.B {}", roff(long_name(*option)));
    if (!is_flag(*option)) page += " " + roff(shown_type(*option));
    page += "\n" + paragraphs(option->get_description());
  }
  return page;
}

constexpr const char* man_tail = R"(.SH EXIT STATUS
.TP
0
done
.TP
2
bad input; nothing was written
.TP
3
stopped, or with \-\-strict ended with warnings; results up to then are complete
.TP
130, 143
interrupted by SIGINT or SIGTERM;
.B subsoil resume
goes on
.SH SEE ALSO
.BR gnuplot (1),
.BR paraview (1);
.B subsoil COMMAND \-\-help
and the pages in the folder of the documentation, above all start.md and reference/keys.md
)";

}  // namespace

std::string man_page(const CLI::App& app) {
  std::string page = fmt::format(
      ".TH SUBSOIL 1 \"\" \"{}\" \"User Commands\"\n.SH NAME\nsubsoil \\- simulates machines that work in soil\n"
      ".SH SYNOPSIS\n.B subsoil\n.I COMMAND\n[ARGUMENTS] [OPTIONS]\n.SH DESCRIPTION\nThe soil is a bed of spheres "
      "(discrete element method), the machine a planar multibody system; both are\ncoupled in every step, and either "
      "runs alone.\nA YAML file describes a pass.\n.SH COMMANDS\n",
      roff("subsoil " + version()));
  for (const CLI::App* command : commands_of(app)) {
    page += fmt::format(".SS subsoil {}{}\n{}", command->get_name(), roff(argument_names(*command)),
                        paragraphs(command->get_description()));
    page += options_page(*command);
    if (!command->get_footer().empty()) page += ".PP\n" + paragraphs(command->get_footer());
  }
  return page + man_tail;
}

}  // namespace subsoil::sim
