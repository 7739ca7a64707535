#!/bin/sh
# Prints the man page, made of what the program says of itself: man.sh PROGRAM
program=$1

# Text as roff takes it: hyphens that can be copied, nothing that begins a request.
roff() { sed 's/\\/\\e/g; s/-/\\-/g; s/\^/\\(ha/g; s/`/\\(ga/g'; }

# Lines "  --name TYPE   meaning" of a help text, the meaning below where the name is long.
entries() {
  awk '/^ / {
    sub(/^ +/, "")
    at = match($0, /  +/)
    head = at ? substr($0, 1, at - 1) : $0
    rest = at ? substr($0, at + RLENGTH) : ""
    if (below) { print $0; below = 0; next }
    gsub(/\\-(\\-)?[a-z]+(\\-[a-z]+)*/, "\\fB&\\fR", head)
    print ".TP"; print head
    if (rest == "") below = 1; else print rest
  }'
}

cat <<END
.TH VISCOBAR 1 "" "$("$program" --version | cut -d' ' -f1,2)" "User Commands"
.SH NAME
viscobar \\- $("$program" help | head -n 1 | roff)
.SH SYNOPSIS
.B viscobar
.I COMMAND
[argument] [options]
.br
.B viscobar \\-\\-version
.SH DESCRIPTION
Computes the motion of a Kelvin\\-Voigt bar whose ends, or whose whole length, meet rigid obstacles: by a penalised
semi\\-discretisation with adaptive steps and located contact changes, and by fully discrete schemes; and compares
the two. A scene is a TOML file, see SCENE FILE below.
.SH COMMANDS
END
for command in $("$program" help | awk 'tolower($1) == "subcommands:" { below = 1 } below && /^ +[a-z]/ { print $1 }'); do
  printf '%s\n' ".SS \\fBviscobar $command\\fR"
  "$program" help "$command" | head -n 1 | roff
  "$program" help "$command" | roff | entries
done
echo '.SH SCENE FILE'
"$program" list keys | roff | awk '{ sub(/^ +/, "") }
  NR % 3 == 1 { print ".TP"; print "\\fB" $0 "\\fR" } NR % 3 == 2 { meaning = $0 } NR % 3 == 0 { print meaning " (" $0 ")" }'
cat <<'END'
.SH FILES
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
a run failed (integrator, disk), or does not keep the error requested; what was reached is kept
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
END
