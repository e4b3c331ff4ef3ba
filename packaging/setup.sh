# Shared by packaging/run and packaging/test, which source it: installs what is missing.
# After `set_up run` or `set_up test` the folder "$root/.venv" holds a working leafscope.

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)"
venv="$root/.venv"

run_packages=(
  libgl1 libegl1 libopengl0 libglx-mesa0 libegl-mesa0 libgl1-mesa-dri libx11-xcb1
  libxcb-cursor0 libxcb-icccm4 libxcb-image0 libxcb-keysyms1 libxcb-randr0
  libxcb-render-util0 libxcb-shape0 libxcb-sync1 libxcb-xfixes0 libxcb-xkb1 libxcb-xinerama0
  libxkbcommon-x11-0 libdbus-1-3 libfontconfig1 libfreetype6 libglib2.0-0 fonts-dejavu-core
)
test_packages=(xvfb xauth x11-utils xdotool openbox)
libraries=(
  libGL.so.1 libEGL.so.1 libOpenGL.so.0 libX11-xcb.so.1 libxcb-cursor.so.0 libxcb-icccm.so.4
  libxcb-image.so.0 libxcb-keysyms.so.1 libxcb-randr.so.0 libxcb-render-util.so.0
  libxcb-shape.so.0 libxcb-sync.so.1 libxcb-xfixes.so.0 libxcb-xkb.so.1
  libxkbcommon-x11.so.0 libdbus-1.so.3 libfontconfig.so.1 libfreetype.so.6 libglib-2.0.so.0
)

say() { printf '%s\n' "$*"; }
stop() { printf 'leafscope set-up: %s\n' "$*" >&2; exit 1; }

# timed SENTENCE COMMAND...: the output is shown only when the command fails.
timed() {
  local sentence=$1 log start=$SECONDS
  shift
  log=$(mktemp)
  say "$sentence ..."
  if ! "$@" >"$log" 2>&1; then
    cat "$log" >&2
    rm -f "$log"
    stop "this step failed: $sentence"
  fi
  rm -f "$log"
  say "  done in $((SECONDS - start)) s"
}

is_root() { [[ $EUID -eq 0 ]]; }
has() { command -v "$1" >/dev/null 2>&1; }

# Names that newer Debian and Ubuntu give up (libglib2.0-0) live on under Provides.
installed_packages() {
  dpkg-query -W -f='${db:Status-Status} ${Package} ${Provides}\n' |
    sed -n 's/^installed //p' | tr ', ' '\n\n'
}

missing_packages() {
  local package present
  present=" $(installed_packages | tr '\n' ' ') "
  for package in "$@"; do
    [[ $present == *" $package "* ]] || printf '%s ' "$package"
  done
}

install_packages() {
  local lock=(-o DPkg::Lock::Timeout=300)
  local -a as_root=(env DEBIAN_FRONTEND=noninteractive)
  if ! is_root; then
    if ! has sudo || ! sudo -n true 2>/dev/null; then
      stop "these system packages are missing; install them and start again:
  sudo apt-get update && sudo apt-get install -y --no-install-recommends $*"
    fi
    as_root=(sudo -n "${as_root[@]}")
  fi
  timed "Reading the lists of system packages" "${as_root[@]}" apt-get "${lock[@]}" -q update
  timed "Installing system packages: $*" "${as_root[@]}" apt-get "${lock[@]}" -q install \
    -y --no-install-recommends "$@"
}

# Elsewhere than on Debian and its children: say what is missing, then try.
report_libraries() {
  local library known missing=()
  if ! has ldconfig; then
    say "This system has neither apt-get nor ldconfig: its libraries are not checked."
    return
  fi
  known=$(ldconfig -p)
  for library in "${libraries[@]}"; do
    [[ $known == *"$library"* ]] || missing+=("$library")
  done
  if [[ ${#missing[@]} -gt 0 ]]; then
    say "These libraries are missing, the window may not open: ${missing[*]}"
  fi
}

is_new_enough() { "$@" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; }

# A name on PATH may be an empty shim: only one that starts counts.
find_python() {
  local name
  for name in python3.11 python3.12 python3.13 python3; do
    if is_new_enough "$name"; then
      printf '%s' "$name"
      return
    fi
  done
}

python_packages() {
  local python=$1 version
  if [[ -z $python ]]; then
    printf 'python3 python3-venv'
  elif ! "$python" -c 'import ensurepip' >/dev/null 2>&1; then
    version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    printf 'python%s-venv' "$version"
  fi
}

set_up_system() {
  local -a wanted=("${run_packages[@]}") missing=()
  if [[ $1 == test ]]; then wanted+=("${test_packages[@]}"); fi
  if has apt-get && has dpkg-query; then
    read -ra missing <<<"$(missing_packages "${wanted[@]}")"
    if ! venv_is_sound; then
      read -ra missing <<<"${missing[*]} $(python_packages "$(find_python)")"
    fi
    if [[ ${#missing[@]} -gt 0 ]]; then
      install_packages "${missing[@]}"
    else
      say "System packages: all there."
    fi
  else
    report_libraries
    if [[ $1 == test ]] && ! has xvfb-run; then say "xvfb-run is missing (package xvfb)."; fi
  fi
}

# A moved folder breaks the scripts inside .venv, which hold its old path.
venv_is_sound() {
  is_new_enough "$venv/bin/python" &&
    grep -qF "$venv" "$venv/bin/activate" 2>/dev/null &&
    "$venv/bin/python" -m pip --version >/dev/null 2>&1
}

make_venv() {
  local python
  python=$(find_python)
  [[ -n $python ]] || stop "Python 3.11 or newer is missing; install it and start again"
  timed "Making .venv with $("$python" --version)" "$python" -m venv --clear "$venv"
}

# fingerprint PURPOSE: changes when .venv has to be filled again.
fingerprint() {
  { cat "$root/pyproject.toml" "$root/packaging/constraints.txt"; say "$venv $1"; } |
    "$venv/bin/python" -c 'import hashlib, sys
print(hashlib.sha256(sys.stdin.buffer.read() + sys.version.encode()).hexdigest())'
}

is_filled() {
  local stamp="$venv/.filled-$1"
  [[ -f $stamp && $(<"$stamp") == "$(fingerprint "$1")" ]]
}

pip_install() (
  cd "$root"
  "$venv/bin/python" -m pip install --quiet --no-input --disable-pip-version-check \
    -c packaging/constraints.txt -e ".$1"
)

# The stamp comes last: an interrupted installation is done again.
fill_venv() {
  rm -f "$venv"/.filled-*
  timed "Installing the locked Python packages into .venv (a minute or more)" pip_install "$2"
  fingerprint "$1" >"$venv/.filled-$1"
}

# set_up run|test: what serves the tests serves a run as well.
set_up() {
  local purpose=$1 extras=''
  if [[ $purpose == test ]]; then extras='[test,report]'; fi
  set_up_system "$purpose"
  venv_is_sound || make_venv
  if is_filled test || is_filled "$purpose"; then
    say "Python packages: all there."
  else
    fill_venv "$purpose" "$extras"
  fi
}
