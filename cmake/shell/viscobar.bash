# bash completion of viscobar, which is asked for its commands, options, keys and words
_viscobar_words() { COMPREPLY=($(compgen -W "$1" -- "$word")); }
_viscobar_list() {  # words with commas between them
  local done=
  [[ $word == *,* ]] && done=${word%,*},
  COMPREPLY=($(compgen -P "$done" -W "$1" -- "${word##*,}"))
}
_viscobar_files() {  # of a kind, -d or -f; and those that are like $2
  local IFS=$'\n'
  compopt -o filenames 2>/dev/null
  COMPREPLY=($(compgen "$1" -- "$word"))
  [[ $2 ]] && COMPREPLY+=($(compgen -f -X "!$2" -- "$word"))
}
_viscobar_commands() { viscobar help | awk 'tolower($1) == "subcommands:" { below = 1 } below && /^ +[a-z]/ { print $1 }'; }
# A line for each argument and option of a command: the type of its value, or -, and the names of the option.
_viscobar_options() {
  viscobar help "$1" | awk '/^  [-a-zA-Z]/ {
    names = ""
    count = split($0, part, /[ ,]+/)
    for (i = 2; i <= count && part[i] ~ /^-/; ++i) names = names " " part[i]
    type = part[i]
    if (type !~ /^([A-Z][A-Z]|N$|[a-z]+\|)/) type = "-"
    print type names }'
}
# Words that the value of a key may be.
_viscobar_value() {
  viscobar list keys | awk -v key="$1" '$1 == key && NF == 1 {
    getline; getline
    sub(/;.*/, ""); sub(/list of/, ""); gsub(/,/, "")
    if (!/number|text/) print }'
}
_viscobar() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]} options type
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    _viscobar_words "$(_viscobar_commands) --help --version -V"
    return
  fi
  if [[ $before == = ]]; then  # bash takes "=" for a word of its own
    _viscobar_words "$(_viscobar_value "${COMP_WORDS[COMP_CWORD - 2]}")"
    return
  elif [[ $word == = ]]; then
    word=
    _viscobar_words "$(_viscobar_value "$before")"
    return
  fi
  options=$(_viscobar_options "$command")
  type=$(awk -v name="$before" '{ for (i = 2; i <= NF; ++i) if ($i == name && $1 != "-") print $1 }' <<<"$options")
  if [[ ! $type && $word == -* ]]; then
    _viscobar_words "$(awk '{ for (i = 2; i <= NF; ++i) print $i }' <<<"$options")"
    return
  fi
  [[ $type ]] || type=$(awk 'NF == 1 { print $1; exit }' <<<"$options")
  case $type,$before in
    TABLE.KEY*) compopt -o nospace 2>/dev/null; _viscobar_words "$(viscobar list keys | awk 'NF == 1 { print $1 "=" }')" ;;
    *,--methods) _viscobar_list "$(_viscobar_value method.name)" ;;
    *,--mass) _viscobar_words "$(_viscobar_value mesh.mass)" ;;
    SCENE* | SWEEP*) _viscobar_files -d '*.toml' ;;
    DIR*) _viscobar_files -d ;;
    FILE*) _viscobar_files -f ;;
    COMMAND*) _viscobar_words "$(_viscobar_commands)" ;;
    *'|'*) _viscobar_words "$(tr '|' ' ' <<<"$type")" ;;
  esac
}
complete -F _viscobar viscobar
