# Sourced by ./run: the environment of its commands. Uses ws (the workspace) and ros_dir (a ROS 1 beside Debian's, or empty).
# shellcheck shell=bash
: "${ws=}" "${ros_dir=}"
: "${repo:=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)}"

# Clear inherited ROS settings, then source the workspace (not with the argument `build`). Also written to the workspace
# as env.bash.
# shellcheck disable=SC2120
enter_workspace() {
  ! has_default_master || unset ROS_MASTER_URI
  unset PYTHONPATH PYTHONHOME LD_LIBRARY_PATH CMAKE_PREFIX_PATH PKG_CONFIG_PATH ROS_PACKAGE_PATH ROS_ROOT ROS_ETC_DIR
  unset ROS_DISTRO ROS_VERSION ROS_PYTHON_VERSION ROS_TEST_RESULTS_DIR AMENT_PREFIX_PATH COLCON_PREFIX_PATH PYTEST_ADDOPTS
  unset PYTHONDONTWRITEBYTECODE # many container images set it: each node and grading would compile its modules again
  export PYTHONNOUSERSITE=1 PATH="/usr/bin:/bin:$PATH" VIRTUAL_ENV="$ws/venv"
  [ -n "${LC_ALL:-}${LC_CTYPE:-}${LANG:-}" ] || export LANG=C.UTF-8
  [ -n "${ROS_IP:-}${ROS_HOSTNAME:-}" ] || export ROS_HOSTNAME=localhost
  export ROS_MASTER_URI="${ROS_MASTER_URI:-http://localhost:$(master_port)}"
  find_temporary_room
  if [ "${1:-}" != build ] && [ -f "$ws/devel/setup.bash" ]; then
    # shellcheck disable=SC1091
    . "$ws/devel/setup.bash"
  elif [ -n "$ros_dir" ]; then
    # shellcheck disable=SC1091
    . "$ros_dir/setup.bash"
  fi
  export PATH="$ws/bin:$ws/venv/bin:$PATH"
}

# Whether ROS_MASTER_URI has the value that every setup.bash gives it, and nobody else has set it: not the user in a
# ./run shell, and no file that a terminal starts with.
has_default_master() {
  [ "${ROS_MASTER_URI:-}" = http://localhost:11311 ] && [ -n "${ROS_DISTRO:-}" ] && [ "${VIRTUAL_ENV:-}" != "$ws/venv" ] &&
    ! grep -qs '^[^#]*ROS_MASTER_URI' ~/.bashrc ~/.bash_aliases ~/.bash_profile ~/.bash_login ~/.profile ~/.zshrc \
      ~/.zshenv /etc/environment /etc/profile /etc/profile.d/*.sh /etc/bash.bashrc
}

# enter_overlays PREFIXES PACKAGES: sources the user's catkin workspaces of a CMAKE_PREFIX_PATH on top of this one, and
# puts the other folders of a ROS_PACKAGE_PATH before its own. Each alone: what they were built on may be another ROS.
enter_overlays() {
  local prefixes packages path number
  IFS=: read -ra prefixes <<<"$1"
  for ((number = ${#prefixes[@]} - 1; number >= 0; number--)); do
    path=${prefixes[number]}
    # shellcheck disable=SC1091
    if is_own "$path" && [ -f "$path/.catkin" ] && [ -f "$path/setup.bash" ]; then . "$path/setup.bash" --extend --local; fi
  done
  IFS=: read -ra packages <<<"$2"
  for ((number = ${#packages[@]} - 1; number >= 0; number--)); do
    path=${packages[number]}
    case ":${ROS_PACKAGE_PATH:-}:" in *":$path:"*) continue ;; esac
    if is_own "$path" && [ -d "$path" ]; then export ROS_PACKAGE_PATH="$path${ROS_PACKAGE_PATH:+:$ROS_PACKAGE_PATH}"; fi
  done
}

# Whether a folder belongs to the user: not to a ROS, nor to the workspace of a ./run.
is_own() {
  case $1 in "" | /usr | /usr/* | /opt/ros/* | "${ros_dir:-/usr}" | "${ros_dir:-/usr}"/* | "$ws"/*) return 1 ;; esac
  [ ! -f "$1/../env.bash" ] || ! grep -q enter_turtle_robotont "$1/../env.bash"
}

# The port of this user's master in this workspace, chosen once: with ROS's own, 11311, all users of a machine would share
# one master, where a second turtlesim_node ends the first.
master_port() {
  local file port="" first=12000 number=8000  # below the ports that free_port and Linux give
  file=$ws/.master_port.$(id -u)
  [ ! -f "$file" ] || read -r port <"$file" || true
  if [ -z "$port" ]; then
    port=$((first + $(id -u) % number))
    while grep -qsx "$port" "${ws%/*}"/*/.master_port.* || (: <"/dev/tcp/localhost/$port") 2>/dev/null; do
      port=$((first + RANDOM % number))
    done
    { echo "$port" >"$file"; } 2>/dev/null || true
  fi
  echo "$port"
}

# For a command that must not meet the user's own roscore, log folder or namespace.
enter_apart() {
  unset ROS_IP ROS_HOSTNAME ROS_MASTER_URI ROS_NAMESPACE ROS_LOG_DIR ROSCONSOLE_CONFIG_FILE ROS_IPV6
  ROS_MASTER_URI=http://localhost:$(free_port)
  export ROS_HOME=$ws/ros_home
  set +eu
  # shellcheck disable=SC2119
  enter_workspace
  set -eu
  find "$ROS_HOME" -mindepth 2 -maxdepth 2 -mtime +2 -exec rm -rf {} + 2>/dev/null || true
}

# In bash, because ./run needs it before a workspace is built; a Python with rospy_support.ports takes 0.14 s.
free_port() {
  local port
  while :; do
    port=$((20000 + RANDOM % 10000))
    (: <"/dev/tcp/localhost/$port") 2>/dev/null || break
  done
  echo "$port"
}

# Prints rosbash (roscd, rosls, completion) changed: it skips every path with a hidden folder in it, and so all of
# ~/.cache; it only has to skip the hidden folders below a workspace's src.
rosbash() {
  local file=/usr/share/bash-completion/completions/rosbash
  [ ! -f "$ros_dir/share/rosbash/rosbash" ] || file=$ros_dir/share/rosbash/rosbash
  sed -e 's#"\.\*/\[\.\]#".*/src/.*/[.]#g' -e 's#-regex \.\*/\[\.\]\.\*#-regex ".*/src/.*/[.].*"#' "$file"
}

# Temporary files go into the workspace where the usual folder is full, missing or not writable: catkin's setup needs one.
find_temporary_room() {
  local probe=
  if probe=$(mktemp 2>/dev/null) && head -c 65536 /dev/zero 2>/dev/null >"$probe"; then
    rm -f -- "$probe"
    return 0
  fi
  [ -z "$probe" ] || rm -f -- "$probe"
  echo "The temporary folder ${TMPDIR:-/tmp} has no room or cannot be written: using $ws/tmp instead." >&2
  mkdir -p "$ws/tmp"
  export TMPDIR="$ws/tmp"
}

# env.bash brings any bash into the workspace, with the user's own workspaces that it has sourced before (unless
# turtle_robotont_alone is set); shell.bash starts the one of ./run shell.
write_shell_files() {
  local functions=(enter_workspace has_default_master enter_overlays is_own find_temporary_room master_port)
  rosbash >"$ws/rosbash.bash"
  {
    printf '# Written by ./run. In a bash of your own, type: source %s/env.bash\n' "$ws"
    declare -f "${functions[@]}"
    printf 'enter_turtle_robotont() {\n  local ws=%q ros_dir=%q\n' "$ws" "$ros_dir"
    echo '  local prefixes=${CMAKE_PREFIX_PATH:-} packages=${ROS_PACKAGE_PATH:-}'
    echo '  enter_workspace'
    echo '  [ -n "${turtle_robotont_alone:-}" ] || enter_overlays "$prefixes" "$packages"'
    printf '}\nenter_turtle_robotont; unset -f enter_turtle_robotont %s\n' "${functions[*]}"
    printf '. %q\n' "$ws/rosbash.bash"
    echo '# The texts of all programs say ./run: here it works in every folder, as run does.'
    echo './run() { if [ -x ./run ]; then command ./run "$@"; else run "$@"; fi; }'
  } >"$ws/env.bash"
  cat >"$ws/shell.bash" <<END
# Written by ./run, for an interactive ./run shell.
turtle_robotont_folder=\$PWD
# A ~/.bashrc with exec zsh or exit would end this shell, one with set -e at the first command that fails.
exec() { [ \$# = 0 ] || echo "Left out of your ~/.bashrc: exec \$*. ./run shell needs bash." >&2; }
exit() { echo "Left out of your ~/.bashrc: exit. It would end this shell." >&2; }
if [ -f ~/.bashrc ]; then . ~/.bashrc || true; fi
set +eu
unset -f exec exit
[ -n "\${BASH_COMPLETION_VERSINFO:-}" ] || . /usr/share/bash-completion/bash_completion
. "$ws/env.bash"
cd "\$turtle_robotont_folder"
unset turtle_robotont_folder
PS1="(turtle_robotont) \$PS1"
cat <<'GREETING'
ROS is ready, in every folder. Here run is the same as ./run: run doctor says what is wrong, run help lists the rest.
Open three terminals, type ./run shell in each, and then type:
  1: roscore    2: rosrun turtlesim turtlesim_node    3: rosrun turtlesim turtle_teleop_key
exit leaves this shell.
GREETING
if [ "\$ROS_MASTER_URI" = "http://localhost:\$(cat "$ws/.master_port.\$UID" 2>/dev/null)" ]; then
  echo "Your ROS master is \$ROS_MASTER_URI; other users of this machine have another one."
else
  echo "The ROS master is \$ROS_MASTER_URI: ROS_MASTER_URI was set before."
fi
END
  mkdir -p "$ws/bin"
  printf '#!/bin/bash\n# Written by ./run: itself, with this workspace.\nTURTLE_ROBOTONT_WS=%q %s exec %q "$@"\n' \
    "$ws" "${ros_dir:+TURTLE_ROBOTONT_ROS=$(printf %q "$ros_dir")}" "$repo/run" >"$ws/bin/run"
  cat >"$ws/bin/roscore" <<'END'
#!/bin/bash
# Written by ./run: ROS's roscore, at the port of ROS_MASTER_URI; by itself it takes 11311 whatever that says.
port=${ROS_MASTER_URI##*:}
port=${port%%/*}
[[ $port =~ ^[0-9]+$ ]] && set -- -p "$port" "$@"
while read -r roscore; do
  [ "$roscore" -ef "$0" ] || exec "$roscore" "$@"
done < <(type -aP roscore)
echo "roscore: ROS is not in the PATH; type ./run shell" >&2
exit 127
END
  chmod +x "$ws/bin/run" "$ws/bin/roscore"
}
