#!/bin/bash
# ./run test: run_tests.bash REPOSITORY WORKSPACE [--fast] [NAME ...], inside the built workspace.
# Every case leaves a folder results/KIND/NAME; test/summary.py reads them all, and expected.tsv says which must be there.
set -eu

export repo=$1 ws=$2
shift 2
export results stress_seconds=240 rostest_seconds=600 grading_seconds=600 page_seconds=900 check_seconds=120
mkdir -p "$ws/test_results"
results=$(mktemp -d "$ws/test_results/$(date +%F_%H%M%S)_XXXX")
jobs=${TURTLE_ROBOTONT_JOBS:-$(($(nproc) * 2))}  # of those that start nodes, and so mostly wait
computing='^(unit|ruff|mypy|catkin_lint)'  # kinds that only compute
. "$repo/test/cases.bash"

# Where a real package is used instead of a stand-in, the tests of the stand-in's own ways are left out.
cases_here() {
  local dir left_out='^$'
  for dir in "$repo"/*/*/package.xml; do
    dir=${dir%/*}
    [ -e "$ws/src/$(basename "$dir")" ] || left_out+="|${dir#"$repo"/}/test/"
  done
  chosen_cases "$@" | grep -vE "$left_out"
}

# Ends, by their id, the processes that were started for the case with this folder (or for all below it).
end_leftovers() {
  local file
  { grep -lzF "TURTLE_ROBOTONT_CASE=$1" /proc/[0-9]*/environ 2>/dev/null || true; } | while read -r file; do
    file=${file#/proc/}
    if kill -KILL "${file%/environ}" 2>/dev/null; then echo "ended left-over process ${file%/environ}"; fi
  done
}

# unit_tests REPORT FILE ...: the tests of a few files are sooner done by one process.
unit_tests() {
  local at_once=(-n "$(nproc)" --dist worksteal) few_files=5
  [ $# -gt "$few_files" ] || at_once=()
  cd "$repo"
  python3 -m pytest -q --tb=short ${at_once[@]+"${at_once[@]}"} --junitxml="$1" "${@:2}"
}

all_unit_tests() {
  local files
  mapfile -t files < <(sed -n 's/^unit\t//p' "$results/expected.tsv")
  unit_tests "$results/unit/pytest.xml" "${files[@]}"
}

case_command() {
  case $1 in
    unit) if [ "$2" = pytest ]; then all_unit_tests; else unit_tests "$3/pytest.xml" "$2"; fi ;;
    rostest) timeout -s INT -k 20 "$rostest_seconds" rostest --results-base-dir "$3/xml" "$repo/$2" ;;
    page) timeout -s INT -k 60 "$page_seconds" python3 "$repo/test/pages/check_page.py" "$2" "$3" ;;
    grading) timeout -s INT -k 20 "$grading_seconds" python3 "$repo/test/check_grading.py" "$2" "$3/files" ;;
    stress)
      PYTHONPATH="$repo/bench:$PYTHONPATH" timeout -s INT -k 20 "$stress_seconds" python3 "$repo/stress/stress.py" \
        "$2" --small --seed 1 --json "$3/figures.json"
      ;;
    catkin_lint)
      # The root package holds the stand-ins' scripts too, which the stand-ins install themselves.
      if [ "$2" = . ]; then set -- "$@" --ignore uninstalled_script; fi
      timeout "$check_seconds" catkin_lint -q -W1 --strict "${@:4}" "$repo/$2"
      ;;
    mypy) cd "$repo" && timeout "$rostest_seconds" bash -c check_types ;;
    ruff) timeout "$check_seconds" ruff check --output-format concise --cache-dir "$ws/ruff_cache" "$repo" ;;
  esac
}

# The types of numpy before 2.3, as in Debian 13, are incomplete: a later one is put beside it, for mypy alone to read.
check_types() {
  if python3 -c 'import numpy, sys; sys.exit(tuple(map(int, numpy.__version__.split(".")[:2])) >= (2, 3))'; then
    [ -d "$ws/numpy_types" ] || pip install -q --no-deps --target "$ws/numpy_types" 'numpy==2.4.*' || return
    export PYTHONPATH=$ws/numpy_types:$PYTHONPATH
  fi
  MYPYPATH=$(printf "%s:" */*/src)src mypy --cache-dir "$ws/mypy_cache"
}

run_case() {
  local dir=$results/$1/$2 start=$SECONDS code=0 verdict=ok
  mkdir -p "$dir"
  export TURTLE_ROBOTONT_CASE=$dir/ ROS_HOME=$dir/ros_home
  case_command "$1" "$2" "$dir" >"$dir/output.txt" 2>&1 </dev/null || code=$?
  [ "$1" != rostest ] || TURTLE_ROBOTONT_CASE='' end_leftovers "$dir/" >>"$dir/output.txt"
  echo "$code" >"$dir/exit_code"
  [ "$code" = 0 ] || verdict=FAILED
  printf '%-6s %3d s  %s %s\n' "$verdict" $((SECONDS - start)) "$1" "$2"
}

# run_cases JOBS [COMMAND ...]: reads `KIND<TAB>NAME` lines and runs these cases, JOBS at a time, each by the COMMAND.
run_cases() { tr '\t\n' '\0\0' | xargs -0 -r -n 2 -P "$1" "${@:2}" bash -c 'run_case "$@"' run_case; }

# Of a file of cases those that only compute, all unit tests as one.
computing_cases() {
  sed -n '/^unit/{s/\t.*/\tpytest/p;q}' "$1"
  grep -E "$computing" "$1" | grep -v '^unit'
}

# Runs all cases: those that only compute at a lower priority, in the time in which the nodes of the others wait.
# The two run at once as a pipeline, because bash would start a background command with SIGINT ignored.
run_all() {
  local cases=$results/expected.tsv
  {
    grep -vE "$computing" "$cases" | run_cases "$jobs" >&3 |
      computing_cases "$cases" | run_cases 2 nice -n 10
  } 3>&1
}

# What failed beside others is run again with nothing beside it; what it left at first is kept in NAME.beside_others.
repeat_failed() {
  local kind name
  python3 "$repo/test/summary.py" --to-repeat "$results" >"$results/repeated.tsv"
  [ -s "$results/repeated.tsv" ] || return 0
  echo "Once more, one at a time, what failed beside others:"
  while IFS=$'\t' read -r kind name; do
    [ "$kind" = unit ] || mv "$results/$kind/$name" "$results/$kind/$name.beside_others"
  done <"$results/repeated.tsv"
  run_cases 1 <"$results/repeated.tsv"
}

cases_here "$@" >"$results/expected.tsv" || true
if [ ! -s "$results/expected.tsv" ]; then
  echo "./run test: no test's name contains: $*. Names look like rostest/test/rostest/x.test or ruff/check." >&2
  exit 2
fi
ln -sfn "$results" "$ws/test_results/latest"
find "$ws/test_results" -mindepth 1 -maxdepth 1 -type d -mtime +2 -exec rm -rf {} +
trap 'end_leftovers "$results/"' EXIT
export -f run_case check_types case_command all_unit_tests unit_tests end_leftovers
run_all
repeat_failed
python3 "$repo/test/summary.py" "$results"
