#!/bin/sh
# Draws docs/images/page.png anew: the page of a server of the default machine while it runs docs/images/page.st.
#
# Needs Chromium, Node.js with npm, and Python 3 with pip, whose Pillow reduces the picture to 256 colours. Builds the two programs, or takes those of the
# folder PROGRAMS. On a busy computer it takes several runs of the program: the picture is taken in one in which no tick was missed.
set -eu
cd "$(dirname "$0")/../.."
programs=${PROGRAMS:-target/release}
[ -n "${PROGRAMS:-}" ] || cargo build --release -p arcline-server -p arcline-client
programs=$(realpath "$programs")
folder=$(mktemp -d)
"$programs/arcline-server" run --listen 127.0.0.1:0 --hmi 127.0.0.1:0 > "$folder/ready" &
server=$!
trap 'kill ${program:-} $server; rm -rf "$folder"' EXIT
until grep -q '^ready' "$folder/ready"; do sleep 0.1; done
eip=$(sed -n 's/^ready eip=\([^ ]*\) .*/\1/p' "$folder/ready")
hmi=$(sed -n 's/^ready .* hmi=\([^ ]*\).*/\1/p' "$folder/ready")
cp tests/browser/package.json tests/browser/package-lock.json "$folder"
[ -n "${NODE_MODULES:-}" ] && ln -s "$NODE_MODULES" "$folder/node_modules" || (cd "$folder" && npm ci --silent --no-audit --no-fund)
(while "$programs/arcline" --server "$eip" run docs/images/page.st && "$programs/arcline" --server "$eip" move-axis S 0; do :; done) > "$folder/run" &
program=$!
script=$(realpath tests/browser/picture.mjs)
(cd "$folder" && node "$script" "http://$hmi" "$folder/page.png")
python3 -m pip install --quiet --disable-pip-version-check --root-user-action ignore --target "$folder/pillow" pillow
PYTHONPATH="$folder/pillow" python3 - "$folder/page.png" docs/images/page.png <<'PYTHON'
import sys
from PIL import Image
picture = Image.open(sys.argv[1]).convert("RGB").quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
picture.save(sys.argv[2], optimize=True)
PYTHON
