#!/usr/bin/env bash
# Installs the package by pip into a virtual environment with the system's packages, as docs/python.md says, and runs a
# scene with it from elsewhere. Given: the source directory, a directory to work in, Python. Ends with 77 where pip or venv
# are missing.
set -euo pipefail
source=$1 work=$2 python=$3
{ "$python" -c 'import setuptools, wheel' && "$python" -c 'import ensurepip' && "$python" -m pip --version; } >/dev/null 2>&1 ||
  { echo "pip, venv, setuptools or wheel are not installed"; exit 77; }
git -C "$source" rev-parse --git-dir >/dev/null 2>&1 || { echo "no git clone: nothing to start from"; exit 77; }
rm -rf "$work" && mkdir -p "$work/tree"
git -C "$source" ls-files -z | (cd "$source" && tar --null -cf - -T -) | tar -xf - -C "$work/tree"
warnings=${VISCOBAR_WARNINGS_AS_ERRORS:-}
unset PYTHONPATH "${!VISCOBAR_@}" "${!CTEST_@}" 2>/dev/null || true
[ -z "$warnings" ] || export VISCOBAR_WARNINGS_AS_ERRORS=$warnings # the cache then has what was compiled before
cd "$work/tree"
# The commands of the page, as they stand there.
commands=$(awk '/^    .*-m venv/ { found = 1 } found && /^    / { sub(/^    /, ""); print; next } found { exit }' docs/python.md)
echo "$commands"
bash -euo pipefail -c "$commands"
cd "$work"
tree/.venv/bin/python -c '
import viscobar, pathlib
assert "site-packages" in viscobar.__file__, viscobar.__file__
print(viscobar.run("tree/examples/scenes/chatter.toml", set={"contact.restitution": 0}))'

# A source distribution holds all that its build needs.
(cd tree/python && "$python" setup.py --quiet sdist --dist-dir "$work/sdist")
tar -xf sdist/viscobar-*.tar.gz -C sdist
cd sdist/viscobar-*/
"$python" setup.py --quiet --version
cmake -G Ninja -S source -B configured -DVISCOBAR_TESTS=OFF -DVISCOBAR_PYTHON_EXECUTABLE="$python" >/dev/null
cmake --build configured --target help | grep viscobar_python >/dev/null
