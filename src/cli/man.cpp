#include <string_view>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "input/vocabulary.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar::cli {

namespace {

/// Text as roff takes it: hyphens that can be copied, nothing that begins a request.
std::string roff(std::string_view text) {
  std::string out;
  if (text.starts_with('.') || text.starts_with('\'')) out = "\\&";
  for (const char c : text) {
    switch (c) {
      case '\\': out += "\\e"; break;
      case '-': out += "\\-"; break;
      case '^': out += "\\(ha"; break;
      case '`': out += "\\(ga"; break;
      default: out += c;
    }
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

std::string section(const CLI::App& command) {
  std::string arguments, details;
  for (const OptionText& option : options_of(command)) {
    const std::string type = italic(option.type);
    if (option.is_argument()) arguments += option.required ? " " + type : " [" + type + "]";
    details += fmt::format(".TP\n{}\n{}{}\n", head(option), roff(option.description),
                           option.fallback.empty() ? "" : fmt::format(" (default: {})", roff(option.fallback)));
  }
  return fmt::format(".SS {}{} [options]\n{}.\n{}", bold("viscobar " + command.get_name()), arguments,
                     roff(command.get_description()), details);
}

std::string key_entry(const SceneKey& key) {
  return fmt::format(".TP\n{}\n{} ({})\n", bold(key.name), roff(key.meaning), roff(facts(key)));
}

constexpr std::string_view closing = R"(.SH FILES
A run leaves in its directory \fIsummary.json\fR, \fIends.csv\fR, \fIevents.csv\fR, \fIenergy.csv\fR, \fIfield.h5\fR
with \fIfield.xdmf\fR for ParaView, and \fIreport.html\fR. Studies leave \fIcompare.json\fR and \fIcompare.html\fR,
and so on.
.PP
One command at a time works in a directory; another one is refused. A whole result there stays until the next run is
whole, whose files are in \fIunfinished\fR until then; after an interrupt \fBviscobar resume\fR goes on there. Files
that are not of a result are never touched.
.SH ENVIRONMENT
.TP
.B NO_COLOR
Where set and not empty, messages have no colours on a terminal either.
.TP
.B VISCOBAR_LEVEL
The level of x86\-64 (x86\-64, x86\-64\-v2, x86\-64\-v3, x86\-64\-v4) that the program may use; else the highest that
the processor has and the program was built for.
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

std::string man_page(const CLI::App& app) {
  std::string text = fmt::format(R"(.TH VISCOBAR 1 "" "viscobar {0}" "User Commands"
.SH NAME
viscobar \- {1}
.SH SYNOPSIS
.B viscobar
.I COMMAND
[argument] [options]
.br
.B viscobar \-\-version
.SH DESCRIPTION
Computes the motion of a Kelvin\-Voigt bar whose ends, or whose whole length, meet rigid obstacles: by a penalised
semi\-discretisation with adaptive steps and located contact changes, and by fully discrete schemes; and compares
the two. A scene is a TOML file, see SCENE FILE below.
.SH COMMANDS
)",
                                 versions().viscobar, roff(app.get_description()));
  for (const CLI::App* command : app.get_subcommands({})) text += section(*command);
  text += ".SH SCENE FILE\n";
  for (const SceneKey& key : scene_keys()) text += key_entry(key);
  return text + std::string(closing);
}

}  // namespace

Action man_command(CLI::App& command) {
  return [&app = *command.get_parent()] {
    print(man_page(app));
    return success;
  };
}

}  // namespace viscobar::cli
