#!/bin/bash
# Runs the kernels of the detectors on AArch64, compiled by Debian's cross compiler and emulated by QEMU: they must pass
# the same checks and give the same results to the bit as on this machine. Skipped if one of the two is not installed.
#
#   kernels_cross.sh SOURCE_DIR KERNELS_CHECK
set -euo pipefail
source=$1 native=$2
for program in aarch64-linux-gnu-g++ qemu-aarch64; do
  command -v "$program" >/dev/null || {
    echo "skipped: needs $program (./setup --cross)"
    exit 77
  }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

cd "$source"
aarch64-linux-gnu-g++ -std=c++20 -O2 -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow -Werror -static -I. \
  library/detectors/kernels/kernels.cc library/detectors/kernels/kernels_avx2.cc \
  tests/library/detectors/kernels/kernels_check.cc -o "$folder/kernels_check"
expected=$("$native") || { echo "$expected"; exit 1; }
got=$(qemu-aarch64 "$folder/kernels_check") || { echo "on AArch64: $got"; exit 1; }
[ "$got" = "$expected" ] || { echo "digest of all results: $expected here, $got on AArch64"; exit 1; }
