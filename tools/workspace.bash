# Sourced by ./run: finds, installs, builds and locks the workspace.
# Uses repo and typed (the command); sets ws (the workspace), ros_dir (a ROS 1 beside Debian's, or empty) and log.
# shellcheck shell=bash
: "${repo:?}" "${typed=}"

debian_packages=(bash-completion bubblewrap g++ make cmake nano pybind11-dev python3-cairo python3-cbor2 python3-dev
  python3-jinja2 python3-psutil python3-tk python3-tornado python3-venv)
debian_ros_packages=(
  catkin catkin-tools ros-environment rosbash python3-rospy python3-roslaunch python3-rostest librostest-dev
  python3-rosservice python3-rostopic python3-rosmsg python3-rosnode python3-rosparam python3-roswtf
  libroscpp-dev ros-message-generation ros-message-runtime
  ros-std-msgs libstd-msgs-dev python3-std-msgs ros-std-srvs libstd-srvs-dev python3-std-srvs
  ros-geometry-msgs libgeometry-msgs-dev python3-geometry-msgs
  ros-sensor-msgs libsensor-msgs-dev python3-sensor-msgs
  ros-nav-msgs libnav-msgs-dev python3-nav-msgs ros-visualization-msgs libvisualization-msgs-dev python3-visualization-msgs
  ros-diagnostic-msgs libdiagnostic-msgs-dev python3-diagnostic-msgs
  python3-tf2-ros python3-tf python3-tf-conversions python3-tf2-geometry-msgs ros-tf2-msgs libtf2-msgs-dev libtf-dev tf-tools
  tf2-tools python3-message-filters python3-move-base-msgs
  python3-dynamic-reconfigure libdynamic-reconfigure-config-init-mutex-dev ros-robot-state-publisher
  joint-state-publisher libtopic-tools-dev topic-tools
)
command_packages=()
optional_packages=()  # wanted where the system has them: Ubuntu has Chromium only as a snap
requirement_files=("$repo/requirements.txt")
required_ros=(catkin rospy roscpp roslaunch rostest rosbash rosservice rostopic rosmsg rosnode rosparam
  message_generation message_runtime std_msgs std_srvs geometry_msgs sensor_msgs nav_msgs visualization_msgs diagnostic_msgs
  tf2_msgs tf2_ros dynamic_reconfigure robot_state_publisher joint_state_publisher topic_tools)
no_network='could not resolve|temporary failure (resolving|in name resolution)|network is unreachable|could not connect|'
no_network+='failed to establish a new connection|cannot connect to proxy|connection (timed out|refused|failed)|'
no_network+='read timed out|unable to connect|newconnectionerror|connecttimeout|from versions: none'
not_offered='Not offered by apt: '
other_systems=("With Docker, type in the folder $repo: docker compose run --rm course ./run demo"
  "With ROS 1 in another folder, type: TURTLE_ROBOTONT_ROS=/folder/with/setup.bash ./run demo")
default_parent=${HOME:-}/.cache/turtle_robotont
products=(build devel venv terminal bin tmp ros_home test_results env.bash shell.bash rosbash.bash run.log
  .built .unfinished .venv_made .users .catkin_workspace '.master_port.*')  # what ./run makes in a workspace, besides src
debian_prefix=/usr
beside_debian=' cv_bridge '  # stand-ins that stay where Debian's package is: libcv-bridge-dev has no Python part

# ---------------------------------------------------------------------------------------------------- messages

say() { printf '%s\n' "$@" >&2; }
die() { say "" "./run: $1" "${@:2}"; exit 1; }

# step NUMBER TEXT COMMAND...: shows how far it is, keeps the command's output for the log.
step() {
  local number=$1 text=$2 start=$SECONDS code=0 interrupted='' ticker
  printf '\n==== %s: %s\n' "$(date '+%F %T')" "$text" >>"$log"
  say "[$number/3] $text ..."
  show_progress "$number" 9>&- &
  ticker=$!
  trap 'interrupted=yes' INT
  (
    trap 'exit 130' INT
    export LC_ALL=C.UTF-8
    umask go+rx  # graded programs of root run as other users
    "${@:3}"
  ) >>"$log" 2>&1 9>&- || code=$?
  trap - INT
  kill "$ticker" 2>/dev/null || true
  wait "$ticker" 2>/dev/null || true
  [ ! -t 2 ] || printf '\r\033[K' >&2
  if [ -n "$interrupted" ]; then
    say "[$number/3] interrupted after $((SECONDS - start)) s. Type ./run build to continue where it stopped."
    exit 130
  elif [ "$code" = 0 ]; then
    say "[$number/3] done in $((SECONDS - start)) s"
  else
    say "[$number/3] FAILED after $((SECONDS - start)) s"
    explain_failure "$text"
  fi
}

# show_progress NUMBER: prints the elapsed time and the last line of the log: on a terminal in one line, else every 30 s.
show_progress() {
  local start=$SECONDS period=30 before='' after='\n' pipe
  [ ! -t 2 ] || period=1 before='\r' after='\033[K'
  exec {pipe}<> <(:)
  while ! read -rt "$period" -u "$pipe"; do  # no sleep, which would outlive this
    printf "$before[%s/3] %3d s  %.60s$after" "$1" $((SECONDS - start)) "$(tail -n 1 "$log")" >&2
  done
}

disk_is_full() { df --output=avail -k "$ws" / /tmp | awk 'NR > 1 && $1 < 20000 { full = 1 } END { exit !full }'; }

explain_failure() {
  local reason="see the lines above" hint="Type ./run build to try again: it continues where it stopped. To start from scratch, type ./run clean before." part
  local -a lacking
  part=$(tac "$log" | sed '/^==== /q')
  log_has() { grep -qiE "$1" <<<"$part"; }
  say "" "The last lines of the log $log:"
  tail -n 20 "$log" | sed 's/^/  | /' >&2
  if log_has 'no space left|not enough free space|disk quota exceeded' || disk_is_full; then
    reason="the disk is full" hint="About 2 GB are needed. Check with df -h / $ws, make room, then type ./run build."
  elif log_has 'could not get lock|dpkg frontend lock'; then
    reason="another program is installing Debian packages" hint="Wait until it is done, then type ./run build."
  elif log_has 'certificate_verify_failed'; then
    reason="the certificate of the Python package server is not trusted here (is there a proxy?)"
    hint="Type: PIP_CERT=/the/proxy/certificate.crt ./run build"
  elif log_has "$no_network"; then
    reason="no network: cannot reach the package server"
    hint="Check the cable or the wifi (and http_proxy, if you use a proxy), then type ./run build."
  elif log_has "^$not_offered"; then
    read -ra lacking < <(sed -n "s/^$not_offered//p" <<<"$part")
    reason="apt does not offer ${lacking[*]:0:3}"
    [ ${#lacking[@]} -le 3 ] || reason+=" and $((${#lacking[@]} - 3)) more packages"
    hint="Debian 12 and later have these packages in main, Ubuntu 22.04 and 24.04 in universe; see man sources.list."
    hint+=$'\n'"$(printf '%s\n' "${other_systems[@]}")"
  elif log_has 'unmet dependencies|held broken packages'; then
    reason="apt cannot install these packages beside others that are installed"
    hint="See the lines above; packages from packages.ros.org and Debian's can exclude each other."
    hint+=$'\n'"${other_systems[0]}"
  elif own_packages "$ws/src" | grep -q .; then
    hint="If the error is in your own package, correct it or move it out of $ws/src: $(own_packages "$ws/src" | xargs)"
  fi
  die "${1%% (*} failed: $reason." "$hint"
}

# ---------------------------------------------------------------------------------------------------- where things are

find_ros() {
  local dir
  ros_dir=${TURTLE_ROBOTONT_ROS:-}
  if [ -n "$ros_dir" ] && [ ! -f "$ros_dir/setup.bash" ]; then
    die "TURTLE_ROBOTONT_ROS=$ros_dir has no setup.bash." "Set it to a folder like /opt/ros/noetic, or unset it."
  fi
  for dir in /opt/ros/noetic /opt/ros/one; do
    if [ -z "$ros_dir" ] && [ -f "$dir/setup.bash" ]; then ros_dir=$dir; fi
  done
}

find_workspace() {
  local name hash
  name=$(basename "$repo" | tr -c 'A-Za-z0-9_.\n-' '_')
  hash=$(printf '%s' "$repo" | sha256sum)
  if [ -n "${TURTLE_ROBOTONT_WS:-}" ]; then
    case $TURTLE_ROBOTONT_WS in
      /*) ws=$(realpath -m "$TURTLE_ROBOTONT_WS") ;;
      *) die "TURTLE_ROBOTONT_WS=$TURTLE_ROBOTONT_WS is not an absolute path." "Start it with a /." ;;
    esac
  elif [ -n "${HOME:-}" ]; then
    ws=$(realpath -m "$default_parent/$name-${hash:0:8}")
  else
    die "HOME is not set, so ./run has no place for the workspace." \
      "Type: TURTLE_ROBOTONT_WS=/tmp/turtle_ws ./run build"
  fi
  log=$ws/run.log
  case $ws/ in
    "$repo"/*) die "the workspace $ws would be inside the repository $repo, where ROS tools would loop forever." \
      "Set TURTLE_ROBOTONT_WS to a folder outside." ;;
    *[[:space:]]*) die "the path of the workspace, '$ws', contains a space; catkin cannot build there." \
      "Type: TURTLE_ROBOTONT_WS=/a/path/without/spaces ./run build" ;;
  esac
  case $repo/ in
    "$ws"/*) die "the repository $repo is inside the workspace $ws." "Set TURTLE_ROBOTONT_WS to another folder." ;;
  esac
}

# Dies unless the workspace is absent, empty, this checkout's, or that of a checkout that is gone, which it replaces.
check_workspace() {
  local owner=""
  [ -e "$ws" ] || return 0
  if [ -f "$ws/.checkout" ]; then
    owner=$(cat "$ws/.checkout")
    [ "$owner" = "$repo" ] || [ ! -e "$owner/run" ] ||
      die "the workspace $ws belongs to the checkout $owner, not to $repo." "Set TURTLE_ROBOTONT_WS to another folder."
  elif [ -n "$(ls -A "$ws")" ]; then
    die "$ws is not empty and was not made by ./run, so ./run does not touch it." \
      "Set TURTLE_ROBOTONT_WS to a new or empty folder."
  fi
  [ -w "$ws" ] || die "you ($(id -un)) cannot write to $ws; it belongs to $(stat -c %U "$ws")." \
    "Type: sudo chown -R $(id -un) $ws"
  [ -O "$ws" ] || [ "$(id -u)" = 0 ] ||
    die "the workspace $ws belongs to $(stat -c %U "$ws"); you would run that user's programs." \
      "Set TURTLE_ROBOTONT_WS to a folder of your own."
}

open_workspace() {
  check_workspace
  if [ ! -f "$ws/.checkout" ] || [ "$(cat "$ws/.checkout")" != "$repo" ]; then
    { mkdir -p "$ws/src" && printf '%s\n' "$repo" >"$ws/.checkout"; } 2>/dev/null ||
      die "cannot make the workspace $ws." "Set TURTLE_ROBOTONT_WS to a folder that you can write to."
    forget_lost_workspaces
  fi
}

# Every checkout has a workspace of its own. If the checkout is gone, remove all files that can be made again.
forget_lost_workspaces() {
  local marker
  for marker in "$default_parent"/*/.checkout; do
    if [ ! -f "$marker" ] || [ -e "$(cat "$marker")" ]; then continue; fi
    (flock -n -x 8 && discard_workspace "$(dirname "$marker")") 8>"$(dirname "$marker")/.lock" || true
  done
}

# discard_workspace FOLDER: removes what ./run has made there, and nothing else: src has packages of the user's own, the
# folder their bags and maps.
discard_workspace() {
  local name
  for name in "${products[@]}"; do rm -rf "${1:?}"/$name; done  # not quoted: some are patterns
  if [ -d "$1/src" ]; then
    remove_links "$1/src"
    remove_stale_links "$1/src"
    rmdir "$1/src" 2>/dev/null || say "Your own packages are still in $1/src: $(find "$1/src" -mindepth 1 -maxdepth 1 -printf '%f ')"
  fi
  name=$(find "$1" -mindepth 1 -maxdepth 1 ! -name src ! -name .checkout ! -name .lock -printf '%f ')
  [ -z "$name" ] || say "Your own files are still in $1: $name"
  if [ -z "$name" ] && [ ! -e "$1/src" ]; then rm -rf "$1"; fi
}

# programs_of_workspace: the programs that run with files of it, which open shells do not.
programs_of_workspace() {
  ps -ewwo pid=,args= | ws=$ws awk 'index($0, ENVIRON["ws"] "/devel/") || index($0, ENVIRON["ws"] "/venv/") { print "  " substr($0, 1, 110) }'
}

# remove_links SRC: the links into this repository.
remove_links() { find "$1" -maxdepth 1 -type l \( -lname "$repo" -o -lname "$repo/*/*" \) -delete; }

# remove_stale_links SRC: in a workspace of ./run, catkin's own link and those into checkouts that are gone.
remove_stale_links() { find "$1" -maxdepth 1 -type l \( -name CMakeLists.txt -o -xtype l \) -delete; }

# own_packages SRC: the names in a src folder that ./run did not link, and those of packages deeper in it.
own_packages() {
  find "$1" -mindepth 3 -name package.xml ! -path "$repo/*" -printf '%h\n' | sed 's#.*/##'
  find "$1" -mindepth 1 -maxdepth 1 ! -path "$repo" ! -lname "$repo" ! -lname "$repo/*/*" ! -name CMakeLists.txt ! -xtype l -printf '%f\n'
}

# lock MODE: -s to use the workspace, -x to change it; held until the script and the program it became end.
# A file .users/PROCESS says which command it is.
lock() {
  while :; do
    exec 9>>"$ws/.lock"
    flock -n "$1" 9 || { say "Waiting until another terminal is done:" "$(lock_holders)"; flock "$1" 9; }
    if [ ! -e /proc/self/fd/9 ] || [ "$ws/.lock" -ef /proc/self/fd/9 ]; then break; fi
    open_workspace
  done
  mkdir -p "$ws/.users"
  echo "$typed" >"$ws/.users/$$"
}

# lock_holders: the commands that use or change the workspace, and since when.
lock_holders() {
  local file process
  for file in "$ws"/.users/*; do
    process=${file##*/}
    if [ ! "/proc/$process/fd/9" -ef "$ws/.lock" ]; then
      rm -f "$file"
    elif [ "$process" != $$ ]; then
      echo "  $(cat "$file"), which has run for $(ps -o etimes= -p "$process" | tr -d ' ') s (process $process)"
    fi
  done
}

# ---------------------------------------------------------------------------------------------------- install and build

wanted_packages() {
  printf '%s\n' "${debian_packages[@]}" ${command_packages[@]+"${command_packages[@]}"}
  [ ${#optional_packages[@]} = 0 ] || optional_packages_here
  [ -n "$ros_dir" ] || printf '%s\n' "${debian_ros_packages[@]}"
}

# Of the optional packages those that apt offers; all, while apt has no lists to tell.
optional_packages_here() {
  local lacking
  lacking=$(packages_not_offered "${debian_packages[0]}" "${optional_packages[@]}")
  [[ $lacking != *"${debian_packages[0]}"* ]] || lacking=""
  comm -23 <(printf '%s\n' "${optional_packages[@]}" | sort) <(printf '%s\n' "$lacking")
}

missing_packages() {
  command -v dpkg-query >/dev/null || { [ -n "$ros_dir" ] || wanted_packages; return 0; }
  # shellcheck disable=SC2046
  comm -23 <(wanted_packages | sort) \
    <(dpkg-query -W -f '${db:Status-Status} ${Package}\n' $(wanted_packages) 2>/dev/null | sed -n 's/^installed //p' | sort)
}

apt_command() {
  echo "apt-get update && apt-get install -y --no-install-recommends $(missing_packages | xargs)"
}

check_system() {
  local pkg lacking=""
  if [ -n "$ros_dir" ]; then
    for pkg in "${required_ros[@]}"; do
      [ -f "$ros_dir/share/$pkg/package.xml" ] || [ -f "/usr/share/$pkg/package.xml" ] ||
        lacking+=" ros-$(basename "$ros_dir")-${pkg//_/-}"
    done
    [ -z "$lacking" ] || die "the ROS in $ros_dir lacks packages." "Type: sudo apt-get install$lacking"
  elif ! command -v apt-get >/dev/null && [ -n "$(missing_packages)" ]; then
    die "this system has neither apt (as Debian and Ubuntu have) nor ROS 1 in /opt/ros/noetic or /opt/ros/one." \
      "${other_systems[@]}"
  fi
}

as_root() {
  local -a settings=(DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8)
  [ -z "${http_proxy:-}" ] || settings+=("http_proxy=$http_proxy")
  if [ "$(id -u)" = 0 ]; then env "${settings[@]}" "$@"; else sudo -n env "${settings[@]}" "$@"; fi
}

become_root() {
  if [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null; then return 0; fi
  command -v sudo >/dev/null || die "Debian packages are missing; only root can install them (there is no sudo here)." \
    "Become root with su -, type the following line, then type ./run again as yourself:" "  $(apt_command)"
  if (: </dev/tty) 2>/dev/null; then
    say "Debian packages are missing: sudo asks for your password to install them."
    sudo -v && return 0
  fi
  die "Debian packages are missing, and you are not allowed to install them with sudo." \
    "Ask someone who may use sudo to type the following line, then type ./run again:" "  sudo sh -c '$(apt_command)'"
}

# packages_not_offered PACKAGE...: prints those that no source of apt has. Support depends on available packages, not on the system's name.
packages_not_offered() {
  comm -23 <(printf '%s\n' "$@" | sort) \
    <(LC_ALL=C apt-cache policy "$@" | awk '/^[^ ]/ { name = $1 } /^  Candidate: [^(]/ { sub(":", "", name); print name }' | sort)
}

install_packages() {
  local attempt output lacking
  local -a packages
  as_root dpkg --configure -a || true
  for ((attempt = 0; attempt < 60; attempt++)); do
    output=$(as_root apt-get -q update 2>&1) || true
    printf '%s\n' "$output"
    [[ $output == *"Could not get lock"* ]] || break
    sleep 5
  done
  mapfile -t packages < <(missing_packages)
  lacking=$(packages_not_offered "${packages[@]}" | xargs)
  if [ -n "$lacking" ]; then
    echo "$not_offered$lacking"
    return 1
  fi
  as_root apt-get -q install -y --no-install-recommends -o DPkg::Lock::Timeout=300 "${packages[@]}" &&
    [ -z "$(missing_packages)" ]
}

# The Python packages of the requirements, each with the versions and hashes that tools/lock.bash has found.
lock_files() { printf '%s\n' "${requirement_files[@]/%.txt/.lock}" | sort -u; }

venv_stamp() { readlink -f /usr/bin/python3; echo "$ws"; lock_files | xargs -d '\n' sha256sum; }

make_venv() {
  local clear="" before=""
  local -a pip=(env -u PYTHONPATH -u PYTHONHOME PYTHONNOUSERSITE=1 PIP_USER=0 PIP_DISABLE_PIP_VERSION_CHECK=1
    "$ws/venv/bin/python3" -m pip install --require-hashes) locks
  mapfile -t locks < <(lock_files)
  if [ -f "$ws/.venv_made" ]; then before=$(cat "$ws/.venv_made"); else clear=--clear; fi
  rm -f "$ws/.venv_made"
  env -u PYTHONPATH -u PYTHONHOME /usr/bin/python3 -m venv --system-site-packages $clear "$ws/venv" &&
    "${pip[@]}" -r "$repo/tools/pip.lock" &&
    "${pip[@]}" --only-binary numpy,opencv-python-headless,scipy "${locks[@]/#/-r}" &&
    { printf '%s\n' "$before"; venv_stamp; } | sort -u >"$ws/.venv_made"
}

# JupyterLab for ./run view --terminal, in an environment of its own: nodes do not get its packages.
terminal_stamp() { readlink -f /usr/bin/python3; sha256sum <"$repo/packages/web/course_page/terminal_requirements.lock"; }

has_terminal() { [ "$(terminal_stamp)" = "$(cat "$ws/terminal/.made" 2>/dev/null)" ]; }

# need_terminal: makes it if there is none; the workspace is locked as by prepare.
need_terminal() {
  if has_terminal; then return 0; fi
  lock -x
  has_terminal || step 1 "Installing JupyterLab (250 MB)" make_terminal
  flock -s 9
}

make_terminal() {
  local -a python=(env -u PYTHONPATH -u PYTHONHOME PYTHONNOUSERSITE=1 PIP_USER=0 PIP_DISABLE_PIP_VERSION_CHECK=1)
  "${python[@]}" /usr/bin/python3 -m venv --system-site-packages --clear "$ws/terminal" &&
    "${python[@]}" "$ws/terminal/bin/python3" -m pip install --require-hashes -r "$repo/tools/pip.lock" \
      -r "$repo/packages/web/course_page/terminal_requirements.lock" &&
    terminal_stamp >"$ws/terminal/.made"
}

# our_packages SRC: the packages of this repository that belong into a src folder, as `name folder`; the others on file
# descriptor 2, with the reason.
our_packages() {
  local dir pkg own="" real=${ros_dir:-$debian_prefix}
  [ ! -d "$1" ] || own=$'\n'$(own_packages "$1" || true)$'\n'
  for dir in "$repo" "$repo"/packages/*/* "$repo"/packages/*/*/* "$repo"/test/rostest_support; do
    pkg=${dir##*/}
    [ "$dir" != "$repo" ] || pkg=turtle_robotont
    if [ ! -f "$dir/package.xml" ]; then
      continue
    elif [ -f "$real/share/$pkg/package.xml" ] && { [ -n "$ros_dir" ] || [[ $beside_debian != *" $pkg "* ]]; }; then
      say "Left out: the stand-in $pkg, because $real has the real one."
    elif [[ $own == *$'\n'"$pkg"$'\n'* ]]; then
      say "Left out: the stand-in $pkg, because $1/$pkg is your own package."
    else
      echo "$pkg $dir"
    fi
  done
}

# The system that programs are compiled for: a new release, in an image or by apt, has other libraries and another Python.
system_stamp() (
  # shellcheck disable=SC1091
  . /etc/os-release
  echo "system  system=${ID:-}-${VERSION_CODENAME:-}:$(readlink -f /usr/bin/python3)"
)

# Everything that the build depends on, one `hash  name` a line.
build_stamp() (
  echo "ros  ros=$ros_dir"
  system_stamp
  echo "workspace  workspace=$ws"
  our_packages "$ws/src" 2>/dev/null | sed 's/^/package  /'
  cd "$repo" || return
  find . -name '.?*' -prune -o -type f \( -name package.xml -o -name CMakeLists.txt -o -name setup.py -o -name '*.msg' \
    -o -name '*.srv' -o -name '*.action' -o -name '*.cmake' -o -name '*.cfg' -o -path '*/native/*' -o -path ./run \
    -o -path './tools/*.bash' \) -print0 | LC_ALL=C sort -z | xargs -0 sha256sum
  find . -name '.?*' -prune -o -name __pycache__ -prune -o -type f \( -path '*/scripts/*' -o -path '*/launch/*' \
    -o -name '*.test' \) -print | LC_ALL=C sort | sed 's/^/file  /'
)

# link_packages SRC: links this repository's packages into a src folder, in place of earlier links of ./run.
link_packages() {
  local pkg dir
  remove_links "$1"
  our_packages "$1" 2>/dev/null | while read -r pkg dir; do
    [[ $dir/ == "$repo/" && $repo/ == "$1"/* ]] || ln -sfnT "$dir" "$1/$pkg"  # the clone may lie in the workspace itself
  done
}

# source_folder FOLDER: the src folder that is meant by a catkin workspace or by its src folder.
source_folder() {
  local folder
  folder=$(realpath -m "$1")
  if [ -d "$folder/src" ]; then
    folder+=/src
  elif [ ! -d "$folder" ] || [ "$(basename "$folder")" != src ]; then
    die "$1 is not a catkin workspace, nor the src folder of one." "Type: mkdir -p $folder/src"
  fi
  case $folder/ in
    "$repo"/*) die "$folder is inside the repository $repo, where the tools of ROS would loop forever." \
      "Choose a workspace outside." ;;
  esac
  [ -w "$folder" ] || die "you ($(id -un)) cannot write to $folder; it belongs to $(stat -c %U "$folder")."
  echo "$folder"
}

# build_workspace: continues an interrupted build, so that open shells stay usable, and forgets only the packages that
# are gone from the repository.
build_workspace() {
  local name before=$ws/.built
  [ -f "$before" ] || before=$ws/.unfinished
  touch "$ws/.unfinished"
  if grep -qxF "ros  ros=$ros_dir" "$before" && grep -qxF "workspace  workspace=$ws" "$before" &&
    { ! grep -q '^system  ' "$before" || grep -qxF "$(system_stamp)" "$before"; }; then  # stamps of 0.2.0 have no system
    gone_packages "$before" | while read -r name; do forget_products "$name"; done
  else
    rm -rf "$ws/build" "$ws/devel"
  fi
  rm -f "$ws/.built"
  build_stamp >"$ws/.unfinished"
  remove_stale_links "$ws/src"
  link_packages "$ws/src"
  write_shell_files
  (
    set +eu
    enter_workspace build
    # catkin of Debian 12 reads PYTHON_EXECUTABLE, that of 13 Python_EXECUTABLE.
    # Debian testing's CMake 4 refuses what catkin asks for, CMake 3.0.
    # Messages are made for C++ and Python: no program here uses the other languages of ROS.
    export CMAKE_POLICY_VERSION_MINIMUM=3.5 ROS_LANG_DISABLE=geneus:genlisp:gennodejs
    catkin_make -C "$ws" --force-cmake -j"$(nproc)" -D{PYTHON,Python}_EXECUTABLE="$ws/venv/bin/python3" || exit
    # A graded program cannot write there.
    "$ws/venv/bin/python3" -m compileall -q "$ws/devel/lib/python3/dist-packages" || true
    chmod -R go+rX "$ws/devel" "$ws/venv" || true  # they may have been made with a umask of 077
  ) && mv "$ws/.unfinished" "$ws/.built"
}

# gone_packages STAMP: the packages that are gone, or lack a file, since that build_stamp.
gone_packages() {
  comm -23 <(sed 's/^[^ ]*  //' "$1" | sort) <(build_stamp | sed 's/^[^ ]*  //' | sort) |
    sed -nE 's#^(\./(packages/[^/]+(/rqt)?|test)/([^/]+)/.*|([^ ]+) /.*)$#\4\5#p; t; s#^\./.*#turtle_robotont#p' | sort -u
}

# forget_products PACKAGE: removes everything that the build of a package has made.
forget_products() {
  local name=$1 devel=$ws/devel
  rm -rf "$ws/build/$name" "$devel"/{lib,include,share,lib/python3/dist-packages}/"$name" \
    "$devel"/share/{common-lisp,gennodejs,roseus}/ros/"$name" "$devel/lib/pkgconfig/$name.pc" "$devel/lib/lib$name"[._]*
  { grep -lF "/$name/" "$devel"/bin/* "$devel"/etc/catkin/profile.d/* 2>/dev/null || true; } | xargs -r rm -f
}

has_venv() {
  [ -x "$ws/venv/bin/python3" ] && [ -f "$ws/.venv_made" ] &&
    [ -z "$(comm -23 <(venv_stamp | sort) <(sort "$ws/.venv_made"))" ]
}
is_built() { [ -f "$ws/devel/setup.bash" ] && [ "$(build_stamp)" = "$(cat "$ws/.built" 2>/dev/null)" ]; }
is_ready() { has_venv && is_built && [ -z "$(missing_packages)" ]; }

# Install and build missing parts; on return the workspace is ready and locked against changes.
prepare() {
  find_ros
  [ "$(uname -s)" = Linux ] || check_system
  find_workspace
  open_workspace
  lock -s
  if is_ready; then return 0; fi
  lock -x
  is_ready || make_ready
  flock -s 9
}

make_ready() {
  local missing about=""
  check_system
  missing=$(missing_packages | wc -l)
  [ "$missing" = 0 ] || become_root
  [ "$missing" -lt 10 ] || about=" (about a minute)"
  : >"$log"
  [ "$missing" = 0 ] || step 1 "Installing Debian packages: $missing$about" install_packages
  has_venv || step 2 "Installing Python packages" make_venv
  our_packages "$ws/src" >/dev/null
  is_built || step 3 "Building the workspace $ws" build_workspace
}
