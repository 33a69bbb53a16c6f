#!/bin/sh
# Installs the Debian 12 packages with which axode is built and tested, as far as they are missing.
# Does nothing, and needs no network, when all are there. Uses sudo only when not root.
#   tools/install_dependencies.sh            what building and testing needs
#   tools/install_dependencies.sh nightly    with emulated processors and the compiler for AArch64
set -eu

packages="
  g++ clang-14 clang-format-14 clang-tidy-14 libclang-rt-14-dev llvm-14
  cmake ninja-build make pkg-config ccache
  libeigen3-dev libtbb-dev libtinyxml2-dev libcli11-dev libfmt-dev nlohmann-json3-dev libzip-dev libqhull-dev
  libgtest-dev libgmock-dev libbenchmark-dev libsdformat-dev
  gnuplot-nox mandoc zsh fish
  python3 python3-dev python3-venv doxygen"

if ! command -v dpkg-query >/dev/null; then
  echo "dependencies: this is not Debian; please see to these packages yourself:" $packages
  exit 0
fi

if [ "${1:-}" = nightly ]; then
  dpkg --print-foreign-architectures | grep -qx arm64 || $(test "$(id -u)" -eq 0 || echo sudo) dpkg --add-architecture arm64
  packages="$packages qemu-user g++-aarch64-linux-gnu"
  for library in libtbb-dev libtinyxml2-dev libfmt-dev libzip-dev libqhull-dev libgtest-dev libgmock-dev; do
    packages="$packages $library:arm64"
  done
fi

# The viewer and its tests need these programs. If they come from another source, Debian's packages are not
# installed, because they may be in conflict with those.
command -v npm >/dev/null || packages="$packages nodejs npm"
command -v "${CHROMIUM:-chromium}" >/dev/null || packages="$packages chromium"

installed=$(dpkg-query --show --showformat '${binary:Package} ${db:Status-Status}\n' |
  sed -n 's/^\([^: ]*\):arm64 installed$/\1:arm64/p; s/^\([^: ]*\)[^ ]* installed$/\1/p')
missing=$(printf '%s\n' $packages | grep -vxF "$installed" || true)
if [ -z "$missing" ]; then
  echo "dependencies: all $(printf '%s\n' $packages | wc -l) packages are installed"
  exit 0
fi
echo "dependencies: installing" $missing

as_root=
if [ "$(id -u)" -ne 0 ]; then
  as_root=sudo
  if ! command -v sudo >/dev/null; then
    echo "dependencies: run this as root (there is no sudo): apt-get install" $missing >&2
    exit 1
  fi
fi

$as_root apt-get update -q
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends \
  -o DPkg::Lock::Timeout=600 $missing
