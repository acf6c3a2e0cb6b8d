#!/bin/sh
# Makes an FMU of FMI 3.0 from a machine and a program: fmi/make.sh MACHINE.toml PROGRAM.st OUT.fmu [input|output TAG]...
# Needs Rust, and Python 3 to pack. The library is built for this computer (x86_64-linux).
set -eu
machine=$1 program=$2 out=$3
shift 3
here=$(dirname "$0")
target=${CARGO_TARGET_DIR:-$here/../target}
cargo build --manifest-path "$here/Cargo.toml" --release --locked --quiet
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$target/release/arcline-fmu" "$folder" "$machine" "$program" "$@"
mkdir -p "$folder/binaries/x86_64-linux"
cp "$target/release/libarcline_fmu.so" "$folder/binaries/x86_64-linux/arcline.so"
out=$(cd "$(dirname "$out")" && pwd)/$(basename "$out")
rm -f "$out"
(cd "$folder" && python3 -m zipfile -c "$out" modelDescription.xml resources binaries)
