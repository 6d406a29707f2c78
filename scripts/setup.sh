# Sourced by scripts/try, scripts/test, scripts/wheel and scripts/lint: installs what is missing, and says what it does.
# After it, $python is the virtual environment's interpreter and the folder is the repository's root.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
python=$PWD/.venv/bin/python

say() { printf '\033[1m== %s\033[0m\n' "$*"; }

# Debian packages, each with the command or file that shows that it is there.
missing_packages() {
  local multiarch
  multiarch=$(uname -m)-linux-gnu
  has() { command -v "$1" >/dev/null 2>&1; }
  file() { [ -e "/usr/include/$1" ] || [ -e "/usr/include/$multiarch/$1" ] || [ -e "/usr/local/include/$1" ]; }
  has g++ || echo g++
  has pkg-config || echo pkg-config
  has ld || echo binutils
  file CL/cl_icd.h || echo opencl-c-headers
  file glm/glm.hpp || echo libglm-dev
  file gmpxx.h || echo libgmp-dev
  file mpfr.h || echo libmpfr-dev
  file fmt/format.h || echo libfmt-dev
  if [ "${1:-}" = tests ]; then
    file gtest/gtest.h || echo libgtest-dev
    # A system driver beside the one that pip brings: the tests run on every driver they find.
    ls /etc/OpenCL/vendors/pocl*.icd >/dev/null 2>&1 || echo pocl-opencl-icd
  fi
  [ "${1:-}" != oclgrind ] || has oclgrind || echo oclgrind
  python3 -c 'import venv, ensurepip' 2>/dev/null || { echo python3-venv; echo python3-dev; }
  python3 -c 'import sysconfig, os, sys; sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))' \
    2>/dev/null || echo python3-dev
}

install_packages() {
  local packages command
  packages=$(missing_packages "$@" | sort -u | tr '\n' ' ')
  [ -n "${packages// /}" ] || return 0
  command="apt-get update && apt-get install -y --no-install-recommends $packages"
  if ! command -v apt-get >/dev/null 2>&1; then
    echo "These are missing, under their Debian names: $packages" >&2
    exit 1
  fi
  say "installing $packages"
  if [ "$(id -u)" = 0 ]; then
    retry sh -c "DEBIAN_FRONTEND=noninteractive; export DEBIAN_FRONTEND; $command" >/dev/null
  elif sudo -n true 2>/dev/null; then
    retry sudo sh -c "DEBIAN_FRONTEND=noninteractive; export DEBIAN_FRONTEND; $command" >/dev/null
  else
    echo "Some system packages are missing. Run this, then start again:" >&2
    echo "  sudo sh -c '$command'" >&2
    exit 1
  fi
}

# Networks fail now and then.
retry() {
  local attempt
  for attempt in 1 2 3; do
    "$@" && return 0
    [ "$attempt" = 3 ] || sleep $((attempt * 5))
  done
  return 1
}

# Everything that decides what the package is.
fingerprint() {
  { cat pyproject.toml CMakeLists.txt
    find cpp kernels python -type f -not -name '*.pyc' -print0 | sort -z | xargs -0 sha1sum
    python3 --version
    echo "$1"
  } | sha1sum | cut -d' ' -f1
}

# install_package EXTRAS: the package, with extras in brackets, in .venv; nothing to do where nothing changed.
install_package() {
  local stamp=.venv/.installed now
  now=$(fingerprint "$1")
  if [ -f "$stamp" ] && grep -qx "$now" "$stamp"; then return 0; fi
  [ -x "$python" ] || { say "making .venv"; rm -rf .venv; python3 -m venv .venv; }
  say "installing implicitrt$1 into .venv"
  retry "$python" -m pip install --quiet --disable-pip-version-check 'scikit-build-core>=0.10' 'pybind11>=3,<4' cmake ninja
  # Without isolation the build folder stays valid, so that a small change compiles little.
  PATH=$PWD/.venv/bin:$PATH retry "$python" -m pip install --quiet --disable-pip-version-check --no-build-isolation ".$1"
  echo "$now" >>"$stamp"
}
