#!/usr/bin/env bash
# Makes a minimal Debian, of the release that this one is, installs the package of the program there with its dependencies and nothing else, runs the program, and
# removes it again. Given: the directory that holds the package. Needs root, mmdebstrap and Debian's packages; ends with
# 77 without the first two. Nothing stays behind.
set -euo pipefail
[ "$(id -u)" -eq 0 ] || { echo "only root can make a root file system"; exit 77; }
command -v mmdebstrap >/dev/null || { echo "mmdebstrap is not installed"; exit 77; }
packages=("$1"/viscobar_*.deb) sources=()
suite=$(. /etc/os-release && echo "$VERSION_CODENAME")
for file in /etc/apt/sources.list /etc/apt/sources.list.d/debian.sources; do
  if [ -s "$file" ]; then sources+=("$file"); fi
done
in_it() { echo "--customize-hook=chroot \"\$1\" sh -ec '$1'"; }
mmdebstrap --quiet --variant=apt --format=null "$suite" /dev/null "${sources[@]}" \
  --customize-hook="copy-in '${packages[0]}' /root" \
  "$(in_it 'apt-get install -y --no-install-recommends /root/*.deb')" \
  "$(in_it 'cd /root && viscobar --version && viscobar new mine.toml && viscobar run mine.toml && viscobar info mine.out')" \
  "$(in_it 'test -s /root/mine.out/report.html && viscobar check /usr/share/doc/viscobar/examples/scenes/chatter.toml')" \
  "$(in_it 'apt-get purge -y --auto-remove viscobar && ! command -v viscobar')"
