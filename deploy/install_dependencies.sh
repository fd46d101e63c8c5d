#!/usr/bin/env bash
# Installs what Cairn builds and runs with, all from Debian 12's own packages. Idempotent: when nothing is missing it
# touches neither apt nor the network.
#   deploy/install_dependencies.sh          build, train, evaluate, spy
#   deploy/install_dependencies.sh --test   and what only the tests and linters need
set -euo pipefail

packages=(
  # Build.
  g++ cmake ninja-build pkg-config git ca-certificates
  # Messages. pkg-config's lcm asks for GLib's headers, which liblcm-dev does not bring.
  liblcm-dev liblcm-bin libglib2.0-dev
  # Keys of runs that span hosts.
  libsodium-dev
  # Physics, planning, collision. OMPL's CMake package links Boost libraries that libompl-dev does not bring.
  libode-dev libompl-dev libfcl-dev libboost-serialization-dev libboost-filesystem-dev libboost-system-dev
  # Mathematics and files.
  libeigen3-dev libxsmm-dev libprotobuf-dev protobuf-compiler nlohmann-json3-dev libxxhash-dev
  # Maps: map_server's yaml and png, Gazebo's worlds.
  libyaml-cpp-dev libpng-dev libpugixml-dev
  # Command line and log.
  libcli11-dev libfmt-dev libspdlog-dev
  # Pages of worlds in space.
  libjs-three
  # (cairn-bench-learner with -DCAIRN_BENCH_TORCH=ON needs libtorch-dev libopenblas-dev besides.)
  # `ip`, for looking into a run's network.
  iproute2
  # `cairn spy`: our message types for Java, lcm-spy and the chart library that its package forgets.
  default-jdk-headless default-jre liblcm-java libjchart2d-java
)
test_packages=(
  libgtest-dev libgmock-dev libbenchmark-dev clang-14 libclang-rt-14-dev clang-format-14 clang-tidy-14 python3 procps
  # Writes the trees that our reader of OctoMap files is held against.
  liboctomap-dev
  # The other engine in cairn-bench-vehicles.
  libbullet-dev
  # The firewall rules of SECURITY.md.
  nftables
  # A cluster of three nodes on one machine, for deploy/slurm.
  slurm-wlm munge
  # Interactive pages are drawn in it.
  chromium
  # A window system without a screen, to look at `cairn spy`.
  xvfb xauth xdotool imagemagick
)

case "${1-}" in
  "") ;;
  --test) packages+=("${test_packages[@]}") ;;
  *)
    echo "install_dependencies.sh: unknown argument '$1'; usage: install_dependencies.sh [--test]" >&2
    exit 2
    ;;
esac

if ! command -v apt-get > /dev/null; then
  echo "install_dependencies.sh: needs apt-get (Debian 12 or a relative)" >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2> /dev/null || true)
  [[ $status == ii* ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "All ${#packages[@]} packages are installed."
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  if ! command -v sudo > /dev/null; then
    echo "install_dependencies.sh: installing ${missing[*]} needs root or sudo, and there is neither" >&2
    exit 1
  fi
  as_root=(sudo)
fi

# apt's hundreds of lines are for the case that it fails.
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() {
  if ! "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -y "$@" > "$log" 2>&1; then
    tail -n 40 "$log" >&2
    echo "install_dependencies.sh: apt-get $1 failed, see above" >&2
    exit 1
  fi
}
echo "Installing ${#missing[@]} packages and what they need (a minute or two): ${missing[*]}"
apt update
apt install --no-install-recommends "${missing[@]}"
