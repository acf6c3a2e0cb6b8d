#!/usr/bin/env bash
# Tries the packages of packaging/build.sh as users would: packaging/try.sh FOLDER
# What a machine cannot try (no root, no umoci, no debootstrap, no lintian) it says as NOT RUN; with CI=true that is a failure.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
cd "$1"
folder=$PWD
[ -e SHA256SUMS ] || { echo "$folder has no packages" >&2; exit 2; }
deb=$(echo arcline_*_amd64.deb) archive=$(echo arcline-*-linux.tar.gz) image=$(echo arcline-*.oci.tar) parts=$(echo arcline-*.cdx.json)
work=$(mktemp -d)
server=
finish() {
    # A server that a check has left behind, by the id that it was started with.
    [ -z "$server" ] || kill "$server" 2>/dev/null || true
    rm -rf --one-file-system "$work"
}
trap finish EXIT
not_run() {
    echo "NOT RUN: $1"
    [ "${CI:-false}" != true ]
}
has() { command -v "$1" >/dev/null; }
is_root() { [ "$(id -u)" = 0 ]; }
wrong() {
    echo "WRONG: $1" >&2
    exit 1
}

# answers COMMAND...: starts a server by these words on free ports, asks it who it is by its own `health`, and ends it.
answers() {
    local line= address
    # The file is there before the first look at it.
    : >"$work/ready"
    "$@" run --listen 127.0.0.1:0 --hmi off --state off >"$work/ready" 2>"$work/log" &
    server=$!
    for _ in $(seq 200); do
        line=$(head -1 "$work/ready")
        [ -z "$line" ] || break
        sleep 0.05
    done
    address=$(sed -n 's/^ready .*eip=\([^ ]*\).*/\1/p' <<<"$line")
    [ -n "$address" ] || { cat "$work/log" >&2; wrong "$1 was not ready within 10 s"; }
    "$@" health --server "$address" || wrong "$* health --server $address failed"
    kill "$server"
    wait "$server" || wrong "the server ended with $?"
    server=
    ! "$@" health --server "$address" 2>/dev/null || wrong "health is well though the server has ended"
}

echo "--- sums"
sha256sum --check --quiet SHA256SUMS

echo "--- $archive"
tar -C "$work" -xzf "$archive"
static=$(echo "$work"/arcline-*/bin/arcline-server)
! readelf -l "$static" | grep -q INTERP || wrong "$static asks for a loader"
answers "$static"
printf 'MCLM(CS1, Move1, Absolute, [100, 50, 25], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);\n' >"$work/part.st"
"$static" simulate "$work/part.st" --trace "$work/static.csv" 2>/dev/null
mkdir "$work/deb"
dpkg-deb -x "$deb" "$work/deb"
"$work/deb/usr/bin/arcline-server" simulate "$work/part.st" --trace "$work/dynamic.csv" 2>/dev/null
cmp "$work/static.csv" "$work/dynamic.csv"

echo "--- $image"
[ "$(stat -c %s "$image")" -le 20000000 ] && [ "$(stat -c %s "$static")" -le 20000000 ] || wrong "it is larger than 20 MB"
if has umoci && is_root; then
    mkdir "$work/layout"
    tar -C "$work/layout" -xf "$image"
    umoci --log=error unpack --image "$work/layout:$(umoci ls --layout "$work/layout")" "$work/bundle"
    files=$work/bundle/rootfs
    [ "$(cd "$files" && find . -type f | sort | xargs)" = "./etc/group ./etc/passwd ./usr/bin/arcline-server" ] || wrong "other files are in it"
    answers chroot --userspec=65532:65532 "$files" /usr/bin/arcline-server
    python3 - "$work/bundle/config.json" <<'EOF'
import json, sys

process = json.load(open(sys.argv[1]))["process"]
assert process["args"][:2] == ["/usr/bin/arcline-server", "run"], process["args"]
assert process["user"]["uid"] == process["user"]["gid"] == 65532, process["user"]
EOF
else
    not_run "the image is not unpacked and started: that needs root and umoci"
fi

echo "--- $deb"
if has lintian; then
    lintian --allow-root --fail-on error,warning "$deb"
else
    not_run "lintian is missing"
fi
if is_root && has debootstrap; then
    debian=$work/debian
    debootstrap --variant=minbase bookworm "$debian" >"$work/log" 2>&1 || { tail -5 "$work/log" >&2; wrong "debootstrap failed"; }
    cp "$deb" "$debian/tmp/"
    in_debian() { chroot "$debian" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive "$@"; }
    in_debian apt-get install -y -q --no-install-recommends "/tmp/$deb" >"$work/log" 2>&1 || { tail -5 "$work/log" >&2; wrong "it is not installed"; }
    in_debian getent passwd arcline >/dev/null || wrong "there is no user arcline"
    in_debian arcline-server check --config /etc/arcline/machine.toml >/dev/null
    in_debian arcline --version
    answers chroot --userspec=arcline "$debian" /usr/bin/arcline-server
    in_debian dpkg --purge arcline >"$work/log" 2>&1
    left=$(cd "$debian" && find etc usr var/lib -xdev -name '*arcline*')
    [ -z "$left" ] || wrong "a purge leaves $left"
else
    not_run "it is not installed: that needs root and debootstrap"
fi
if has systemd-analyze; then
    # Its program stands in a folder here, not where the unit names it.
    sed "s#/usr/bin/arcline-server#$work/deb&#" "$work"/deb/*/systemd/system/arcline.service >"$work/arcline.service"
    said=$(systemd-analyze verify --man=no "$work/arcline.service" 2>&1) && [ -z "$said" ] || wrong "systemd-analyze verify: $said"
    systemd-analyze security --offline=true --root="$work/deb" --threshold=20 --no-pager arcline.service | tail -1
else
    not_run "systemd-analyze is missing"
fi

echo "--- $parts"
python3 - "$parts" "$root/Cargo.lock" <<'EOF'
import json, re, sys

parts = json.load(open(sys.argv[1]))
locked = set(re.findall(r'name = "([^"]+)"\nversion = "([^"]+)"', open(sys.argv[2]).read()))
named = {(part["name"], part["version"]) for part in parts["components"]}
assert named <= locked, named - locked
references = {part["bom-ref"] for part in parts["components"]}
assert len(references) == len(parts["components"]) > 100, len(references)
assert {reference for one in parts["dependencies"] for reference in [one["ref"], *one["dependsOn"]]} == references
print(len(references), "components")
EOF
