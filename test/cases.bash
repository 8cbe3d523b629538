# Sourced by ./run and run_tests.bash: the cases that ./run test has, and what they need beyond the demo.
# A case is a line `KIND<TAB>NAME`. Uses repo.
# shellcheck shell=bash
: "${repo:?}"

# all_cases: what takes longest comes first.
all_cases() (
  cd "$repo" || return
  printf 'mypy\tcheck\nruff\tcheck\n'
  find test/unit */*/test/unit bench/test */bench/test stress/test -name 'test_*.py' -printf 'unit\t%p\n' | sort
  printf 'page\t%s\n' docs/course.md docs/course_next.md README.md
  printf 'stress\t%s\n' web interrupts soak
  printf 'grading\tcourse_nodes\n'
  find test/data/submissions -mindepth 1 -maxdepth 1 -type d -printf 'grading\t%p\n' | sort
  printf 'grading\t%s\n' same_ten_times red_team_namespace red_team_uid red_team_none
  find . -name '.?*' -prune -o -name '*.test' -printf 'rostest\t%P\n' | sort
  printf 'catkin_lint\t%s\n' . support simulation vision lessons browser grading demo
)

# chosen_cases [--fast] [NAME ...]: those whose KIND/NAME contains one of the NAMEs; with --fast, those without ROS.
chosen_cases() {
  local kind name filter kinds=.
  if [ "${1:-}" = --fast ]; then kinds='^(unit|catkin_lint|ruff|mypy)'; shift; fi
  all_cases | grep -E "$kinds" | while IFS=$'\t' read -r kind name; do
    [ $# -gt 0 ] || printf '%s\t%s\n' "$kind" "$name"
    for filter in "$@"; do
      case "$kind/$name" in *"$filter"*) printf '%s\t%s\n' "$kind" "$name"; break ;; esac
    done
  done
}

# needs_of_cases: of the cases on standard input, the Debian packages and the files of Python requirements, one a line;
# a ? marks a package without which tests are left out loudly, where a system does not offer it.
needs_of_cases() {
  local cases pattern need
  cases=$(cat)
  while read -r pattern need; do
    if grep -qE "$pattern" <<<"$cases"; then echo "$need"; fi
  done <<END
/network/|^page|/doctor/ iproute2
/test_sheet                    poppler-utils
/(test_)?window                 xvfb
browser|class_page             ?chromium
browser|class_page             ?chromium-driver
browser|class_page             ?python3-selenium
^(unit|catkin_lint|ruff|mypy)  $repo/test/requirements.txt
/test_remote                   $repo/grading/course_grader/dask_requirements.txt
test_notebooks                 $repo/test/notebook_requirements.txt
recordings?\.test              $repo/test/requirements.txt
attack                         $repo/test/requirements.txt
END
}
