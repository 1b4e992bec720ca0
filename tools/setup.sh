# Shared by ./run and ./test: installs what is missing, builds. Sourced, not executed.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# Installs the packages of packages.txt that are missing; silent and offline when all are there.
install_packages() {
  command -v dpkg-query > /dev/null || { echo "No Debian here: packages.txt lists what must be installed."; return; }
  local wanted installed line choice missing="" sudo=""
  wanted=$(grep -v '^#' "$root/packages.txt")
  installed=" $({ dpkg-query -W -f='${Package} ${db:Status-Status}\n' ${wanted//|/ } 2> /dev/null || true; } |
    awk '$2 == "installed" {print $1}' | xargs) " # it fails when it does not know one of them
  for line in $wanted; do
    for choice in ${line//|/ }; do
      [[ $installed == *" $choice "* ]] && continue 2
    done
    missing+=" ${line%%|*}"
  done
  [ -z "$missing" ] && return
  echo "Installing" $missing
  [ "$(id -u)" = 0 ] || sudo=sudo
  $sudo apt-get -q update
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get -q -y install --no-install-recommends --no-remove $missing
}

# build [target...]: the Release build in build/release. Progress on a terminal, silence elsewhere, the log on an error.
build() {
  local folder="$root/build/release" log
  if [ -x "$folder/bin/coupler" ] && [ ! -w "$folder" ]; then return; fi # of somebody else, who has built it
  mkdir -p "$folder" || { echo "error: $folder is not yours to build in: ask its owner for ./run there" >&2; exit 8; }
  log="$folder/build.log"
  exec 9> "$folder/.lock"
  flock 9 # two runs at once must not build at once
  [ -x "$folder/bin/coupler" ] || echo "First build, 5 to 10 minutes on two cores; later ones take seconds. Log: $log"
  if [ ! -f "$folder/build.ninja" ] && ! (cd "$root" && cmake --preset release) > "$log" 2>&1; then
    cat "$log"
    echo "error: the configuration failed" >&2
    exit 1
  fi
  if [ -t 1 ]; then
    ninja -C "$folder" -j "$(nproc)" "$@"
  else
    ninja -C "$folder" -j "$(nproc)" "$@" > "$log" 2>&1 || { cat "$log"; echo "error: the build failed" >&2; exit 1; }
  fi
  exec 9>&-
}

# More processes than cores, most of them idle at any time: they must sleep rather than spin, and may share cores.
export OMPI_MCA_mpi_yield_when_idle=1 OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none
export OMP_NUM_THREADS=1
if [ "$(id -u)" = 0 ]; then
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi
