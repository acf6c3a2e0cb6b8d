#!/usr/bin/env bash
# The packages of a release: packaging/build.sh OUT_FOLDER
# Builds the programs, and makes of them
#   arcline_VERSION_amd64.deb               for Debian 12 and newer: both programs, a systemd unit, manual pages, completions
#   arcline-VERSION-x86_64-linux.tar.gz     arcline-server as one static program, with the same pages and completions
#   arcline-VERSION.oci.tar                 the image for containers: that static program and nothing else
#   arcline-VERSION.cdx.json, SHA256SUMS    the bill of materials, the sums
# The same sources give the same bytes where cargo's folder has the same path: times are SOURCE_DATE_EPOCH, by default that of the last commit.
set -euo pipefail
[ $# -eq 1 ] || { echo "usage: packaging/build.sh OUT_FOLDER" >&2; exit 2; }
mkdir -p "$1"
out=$(cd "$1" && pwd)
cd "$(dirname "$0")/.."
root=$PWD
target=${CARGO_TARGET_DIR:-$root/target}
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -1)
umask 022
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

built=$(cargo build --release --workspace --bins --locked --quiet --message-format=json-render-diagnostics)
# Not for cargo: the C of `ring`, which has no dates, would be compiled again, and all that needs it.
export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}
# glibc, linked in: nothing of the server resolves names or users, for which a static glibc would load libraries. Only linking depends on that flag, so
# the program is linked once more from the library that cargo has just built; given to cargo, the flag would have every crate compiled a second time.
library=$(python3 -c '
import json, sys

for message in map(json.loads, sys.stdin):
    if message["reason"] == "compiler-artifact" and message["target"]["name"] == "arcline_server" and "lib" in message["target"]["kind"]:
        print(*(file for file in message["filenames"] if file.endswith(".rlib")))
' <<<"$built")
rustc --edition=2024 --crate-name arcline_server --crate-type bin -C opt-level=3 -C target-feature=+crt-static \
    -L "dependency=$target/release/deps" --extern "arcline_server=$library" -o "$work/linked" server/src/main.rs
static=$work/arcline-server
stripped() {
    strip --strip-all --remove-section=.comment -o "$2" "$1"
    python3 packaging/build_id.py "$2"
}
stripped "$work/linked" "$static"

# pages FOLDER PROGRAM...: manual pages and completions.
pages() {
    local folder=$1 program
    shift
    install -d "$folder/share/man/man1" "$folder/share/bash-completion/completions" "$folder/share/zsh/vendor-completions" "$folder/share/fish/vendor_completions.d"
    for program in "$@"; do
        "$target/release/$program" completions bash >"$folder/share/bash-completion/completions/$program"
        "$target/release/$program" completions zsh >"$folder/share/zsh/vendor-completions/_$program"
        "$target/release/$program" completions fish >"$folder/share/fish/vendor_completions.d/$program.fish"
        "$target/release/$program" man --output "$folder/share/man/man1" >/dev/null
    done
}

# pack FOLDER NAME: a folder, or `.`, as a tar whose bytes depend on its files only.
pack() { tar --sort=name --owner=0 --group=0 --numeric-owner --format=ustar --mtime="@$SOURCE_DATE_EPOCH" -C "$1" -c "$2"; }

# The archive.
name=arcline-$version-x86_64-linux
install -D -m 755 "$static" "$work/$name/bin/arcline-server"
pages "$work/$name" arcline-server
install -m 644 README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE "$work/$name/"
install -D -m 644 packaging/arcline.service packaging/arcline.sysusers -t "$work/$name/systemd/"
pack "$work" "$name" | gzip -9n >"$out/$name.tar.gz"

# The image.
python3 packaging/oci.py "$static" "$out/arcline-$version.oci.tar"

# The Debian package.
tree=$work/tree
control=$work/control
for program in arcline-server arcline; do
    install -d "$tree/usr/bin"
    stripped "$target/release/$program" "$tree/usr/bin/$program"
    chmod 755 "$tree/usr/bin/$program"
done
pages "$tree/usr" arcline-server arcline
gzip -9n "$tree"/usr/share/man/man1/*.1
install -d "$tree/etc/arcline" "$tree/usr/share/doc/arcline" "$control"
"$target/release/arcline-server" default-config >"$tree/etc/arcline/machine.toml"
install -D -m 644 packaging/arcline.service "$tree/lib/systemd/system/arcline.service"
install -D -m 644 packaging/arcline.sysusers "$tree/usr/lib/sysusers.d/arcline.conf"
doc=$tree/usr/share/doc/arcline
install -m 644 README.md CHANGELOG.md "$doc/"
maintainer="The Arcline authors <arcline@example.org>"
printf 'arcline (%s) unstable; urgency=medium\n\n  * CHANGELOG.md beside this file tells what is new.\n\n -- %s  %s\n' \
    "$version" "$maintainer" "$(LC_ALL=C date -R -u -d "@$SOURCE_DATE_EPOCH")" | gzip -9n >"$doc/changelog.gz"
{
    printf 'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: arcline\n\n'
    printf 'Files: *\nCopyright: The Arcline authors\nLicense: Expat or Apache-2.0\n\nLicense: Expat\n'
    sed 's/^$/./; s/^/ /' LICENSE-MIT
    printf '\nLicense: Apache-2.0\n The text is in /usr/share/common-licenses/Apache-2.0.\n'
} >"$doc/copyright"
# The newest version of the C library that a symbol of the programs asks for.
libc=$(objdump -T "$tree"/usr/bin/* | grep -o 'GLIBC_[0-9.]*' | sort -Vu | tail -1)
cat >"$control/control" <<EOF
Package: arcline
Version: $version
Architecture: amd64
Maintainer: $maintainer
Installed-Size: $(du -sk --apparent-size "$tree" | cut -f1)
Depends: libc6 (>= ${libc#GLIBC_}), libgcc-s1, systemd | systemd-standalone-sysusers
Section: science
Priority: optional
Description: coordinated-motion server that looks like a Logix controller
 EtherNet/IP clients connect to it, read and write its tags, and execute motion
 instructions on axes and coordinate systems, whose positions a real-time
 thread computes every millisecond. With a simulator on a virtual clock, a page
 for browsers, and a command line.
EOF
echo /etc/arcline/machine.toml >"$control/conffiles"
install -m 755 packaging/deb/postinst packaging/deb/prerm packaging/deb/postrm "$control/"
(cd "$tree" && find . -type f ! -path './etc/*' -printf '%P\0' | sort -z | xargs -0 md5sum) >"$control/md5sums"
pack "$control" . | gzip -9n >"$work/control.tar.gz"
pack "$tree" . | xz -6 -T1 >"$work/data.tar.xz"
echo 2.0 >"$work/debian-binary"
deb=$out/arcline_${version}_amd64.deb
rm -f "$deb"
# D: times and owners are 0.
(cd "$work" && ar rcD "$deb" debian-binary control.tar.gz data.tar.xz)

python3 packaging/sbom.py >"$out/arcline-$version.cdx.json"
cd "$out"
sha256sum "arcline_${version}_amd64.deb" "$name.tar.gz" "arcline-$version.oci.tar" "arcline-$version.cdx.json" >SHA256SUMS
ls -l "$out"
