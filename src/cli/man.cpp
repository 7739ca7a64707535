#include <fmt/format.h>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "input/scene_keys.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar::cli {

namespace {

/// Text as roff takes it: hyphens that can be copied, nothing that begins a request.
std::string roff(std::string_view text) {
  std::string out;
  if (text.starts_with('.') || text.starts_with('\'')) out = "\\&";
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (c == '^')
      out += "\\(ha";
    else if (c == '`')
      out += "\\(ga";
    else
      out += c;
  }
  return out;
}

std::string bold(std::string_view text) { return fmt::format("\\fB{}\\fR", roff(text)); }
std::string italic(std::string_view text) { return text.empty() ? "" : fmt::format("\\fI{}\\fR", roff(text)); }

std::string head(const OptionText& option) {
  if (option.is_argument()) return italic(option.type);
  std::string text;
  for (const std::string& name : option.names) text += (text.empty() ? "" : ", ") + bold(name);
  return option.type.empty() ? text : text + " " + italic(option.type);
}

std::string section(const CommandText& command) {
  std::string arguments, details;
  for (const OptionText& option : command.options) {
    const std::string type = italic(option.type);
    if (option.is_argument()) arguments += option.required ? " " + type : " [" + type + "]";
    details += fmt::format(".TP\n{}\n{}{}\n", head(option), roff(option.description),
                           option.fallback.empty() ? "" : fmt::format(" (default: {})", roff(option.fallback)));
  }
  return fmt::format(".SS {}{} [options]\n{}.\n{}", bold("viscobar " + command.name), arguments,
                     roff(command.description), details);
}

std::string key_entry(const SceneKey& key) {
  std::string type = type_words(key), fallback = default_words(key);
  std::erase(type, '`');
  std::erase(fallback, '`');
  const std::string unit = key.unit.empty() || key.unit == "1" ? "" : fmt::format("; unit: {}", roff(key.unit));
  return fmt::format(".TP\n{}\n{} ({}; default: {}{})\n", bold(key.name), roff(key.meaning), roff(type), roff(fallback),
                     unit);
}

constexpr std::string_view closing = R"(.SH FILES
A run leaves in its directory
.IR summary.json ,
.IR ends.csv ,
.IR events.csv ,
.IR energy.csv ,
.I field.h5
with
.I field.xdmf
for ParaView, and
.IR report.html .
Studies leave
.I compare.json
and
.IR compare.html ,
and so on.
.PP
One command at a time works in a directory; another one is refused. A whole result there stays until the next run is whole, whose files are in
.I unfinished
until then; after an interrupt
.B viscobar resume
goes on there. Files that are not of a result are never touched.
.SH ENVIRONMENT
.TP
.B NO_COLOR
Where set and not empty, messages have no colours on a terminal either.
.SH EXIT STATUS
.TP
.B 0
done
.TP
.B 1
a run failed (integrator, disk); what was reached is kept
.TP
.B 2
the input is wrong: command line or scene file
.TP
.B 130
interrupted, or stopped by \-\-wall\-time; what was reached is kept
.SH EXAMPLES
.EX
viscobar new scene.toml
viscobar check scene.toml
viscobar run scene.toml \-o out
viscobar run scene.toml \-\-set method.name=rigid \-\-json
viscobar limit scene.toml \-\-epsilon 1e\-2:1e\-8
.EE
)";

}  // namespace

std::string man_page(const CLI::App& app) {
  std::string text = fmt::format(
      ".TH VISCOBAR 1 \"\" \"viscobar {0}\" \"User Commands\"\n.SH NAME\nviscobar \\- {1}\n.SH SYNOPSIS\n"
      ".B viscobar\n.I COMMAND\n[argument] [options]\n.br\n.B viscobar \\-\\-version\n.SH DESCRIPTION\n"
      "Computes the motion of a Kelvin\\-Voigt bar whose ends, or whose whole length, meet rigid obstacles: by a "
      "penalised\n"
      "semi\\-discretisation with adaptive steps and located contact changes, and by fully discrete schemes; and "
      "compares\n"
      "the two. A scene is a TOML file, see SCENE FILE below.\n.SH COMMANDS\n",
      versions().viscobar, roff(app.get_description()));
  for (const CommandText& command : command_texts(app)) text += section(command);
  text += ".SH SCENE FILE\n";
  for (const SceneKey& key : scene_keys()) text += key_entry(key);
  return text + std::string(closing);
}

ManCommand::ManCommand(CLI::App& app) : Command(app, "man", "Print the man page"), app_(app) {}

int ManCommand::operator()() const {
  print(man_page(app_));
  return success;
}

}  // namespace viscobar::cli
