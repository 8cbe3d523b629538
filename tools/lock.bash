#!/bin/bash
# Writes the .lock file beside each requirements.txt: every Python package with its version and hashes, for all Pythons
# from 3.8 on. Needs uv (https://docs.astral.sh/uv). Packages that ./run installs from Debian are left out.
set -eu
cd "$(dirname "$0")/.."
mapfile -t files < <(git ls-files '*requirements.txt')
debian=(catkin-pkg docutils jinja2 markupsafe psutil pyparsing python-dateutil pyyaml setuptools six tornado)
compile=(uv pip compile --quiet --universal --python-version 3.8 --no-annotate)
left_out=("${debian[@]}" appnope colorama pywin32)  # of other systems
all=$(mktemp)
trap 'rm "$all"' EXIT
"${compile[@]}" "${files[@]}" --output-file "$all"  # versions that fit each other
for file in "${files[@]}"; do
  present=("${left_out[@]}")
  [[ $file = *terminal* ]] || present+=(cffi pycparser)  # of other Pythons
  [ "$file" = requirements.txt ] || present+=(numpy)  # requirements.lock has it, and is always installed, too
  "${compile[@]}" --generate-hashes --custom-compile-command tools/lock.bash --constraint "$all" \
    "${present[@]/#/--no-emit-package=}" "$file" --output-file "${file%.txt}.lock"
done
echo "pip; python_version < '3.9'" | "${compile[@]}" --generate-hashes --custom-compile-command tools/lock.bash - \
  --output-file tools/pip.lock
