#!/usr/bin/env bash
# What a newcomer does, on a clean tree, with the commands, the scene and the program as they stand on the pages:
# from a clone to a picture by one command, from the README to an own scene, from the installation to an own program.
# Given: the source directory, a directory to work in. Ends with 77 where there is no clone to start from.
set -euo pipefail
source=$1 work=$2
git -C "$source" rev-parse --git-dir >/dev/null 2>&1 || { echo "no git clone: nothing to start from"; exit 77; }
rm -rf "$work" && mkdir -p "$work"/{tree,scene,program,home}
git -C "$source" ls-files -z | (cd "$source" && tar --null -cf - -T -) | tar -xf - -C "$work/tree"
export XDG_CACHE_HOME=${XDG_CACHE_HOME:-$HOME/.cache}  # where a compiler cache is
export HOME=$work/home
# What decides the compiler's options stays: the cache then has what the tree above has compiled.
warnings=${VISCOBAR_WARNINGS_AS_ERRORS:-}
unset "${!VISCOBAR_@}" "${!CTEST_@}" CMAKE_PREFIX_PATH CMAKE_BUILD_PARALLEL_LEVEL NINJA_STATUS 2>/dev/null || true

[ -z "$warnings" ] || export VISCOBAR_WARNINGS_AS_ERRORS=$warnings

# The indented lines of a page from one that matches on to the first that is not, without remarks.
commands() { # PAGE PATTERN
  awk -v pattern="$2" '/^    / && (found || $0 ~ pattern) { found = 1; sub(/^    /, ""); sub(/ +# .*$/, ""); print; next } found { exit }' "$1"
}
# The first block of a language.
block() { # PAGE LANGUAGE
  awk -v fence="\`\`\`$2" '$0 == fence { inside = 1; next } /^```/ && inside { exit } inside' "$1"
}
step() { echo "== $1 ($SECONDS s)"; }
run() { # DIRECTORY COMMANDS
  [ -n "$2" ] || { echo "the page has no such commands"; exit 1; }
  echo "$2"
  (cd "$1" && bash -euo pipefail -c "$2")
}

SECONDS=0
step "from the clone to a picture"
run "$work/tree" "$(commands "$work/tree/README.md" 'scripts/demo' | head -1)" | tee "$work/demo.txt"
picture=$(sed -n 's/^The pictures: open \(.*\) in a browser\.$/\1/p' "$work/demo.txt")
grep -q '<svg' "$picture"

step "from the README to an own scene"
begun=$SECONDS
export PATH=$work/tree/build/release:$PATH
block "$work/tree/README.md" toml >"$work/scene/scene.toml"
run "$work/scene" "$(commands "$work/tree/README.md" 'viscobar new')"
grep -q '<svg' "$work/scene/out/report.html"
run "$work/scene" "sed -i 's/^gap = 0.1/gap = 0.2/' mine.toml
viscobar run mine.toml
viscobar info mine.out"
[ $((SECONDS - begun)) -lt 300 ] || { echo "took more than five minutes"; exit 1; }

step "from the installation to an own program"
page=$work/tree/docs/library.md
block "$work/tree/README.md" cpp >"$work/program/mine.cpp"
[ "$(wc -l <"$work/program/mine.cpp")" -le 20 ] || { echo "the README's program has more than 20 lines"; exit 1; }
block "$page" cmake >"$work/program/CMakeLists.txt"
run "$work/tree" "$(commands "$page" 'cmake --install')"
run "$work/program" "$(commands "$page" 'cmake -G Ninja -S')" | tee "$work/program/by-cmake.txt"
grep -q '^closes at t = 0.2000$' "$work/program/by-cmake.txt"
run "$work/program" "$(commands "$page" 'export PKG_CONFIG_PATH')" | tee "$work/program/by-pkg-config.txt"
grep -q '^closes at t = 0.2000$' "$work/program/by-pkg-config.txt"
step "done"
