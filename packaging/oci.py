"""An image for containers from one static program, without a container engine: oci.py PROGRAM OUT.oci.tar

The archive is an OCI image layout, with the manifest.json of `docker save` beside it, so that `docker load`, `podman load` and `skopeo copy oci-archive:` take
it. There is nothing in the image but the program, the folder of its state, and the names of its user. The same program gives the same bytes: times are SOURCE_DATE_EPOCH.
"""

import gzip
import hashlib
import io
import json
import os
import re
import sys
import tarfile
from datetime import UTC, datetime
from pathlib import Path

ROOT = Path(__file__).parent.parent
USER = 65532
EPOCH = int(os.environ["SOURCE_DATE_EPOCH"])
VERSION = re.search(r'^version = "(.*)"$', (ROOT / "Cargo.toml").read_text(), re.M).group(1)
PORTS = ["44818/tcp", "44818/udp", "2221/tcp", "2222/udp", "8080/tcp", "8443/tcp"]


def entry(archive, name, mode, owner=0, content=None):
    """A file, or without content a folder."""
    info = tarfile.TarInfo(name)
    info.mode, info.uid, info.gid, info.mtime = mode, owner, owner, EPOCH
    if content is None:
        info.type = tarfile.DIRTYPE
        archive.addfile(info)
    else:
        info.size = len(content)
        archive.addfile(info, io.BytesIO(content))


def layer(program):
    users = f"root:x:0:0:root:/:/sbin/nologin\narcline:x:{USER}:{USER}:Arcline server:/state:/sbin/nologin\n"
    groups = f"root:x:0:\narcline:x:{USER}:\n"
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        entry(archive, "etc", 0o755)
        entry(archive, "etc/group", 0o644, content=groups.encode())
        entry(archive, "etc/passwd", 0o644, content=users.encode())
        entry(archive, "state", 0o750, USER)
        entry(archive, "tmp", 0o1777)
        entry(archive, "usr", 0o755)
        entry(archive, "usr/bin", 0o755)
        entry(archive, "usr/bin/arcline-server", 0o755, content=program)
    return out.getvalue()


def image(created, diff_id):
    seconds = 1_000_000_000
    return {
        "created": created,
        "architecture": "amd64",
        "os": "linux",
        "config": {
            "User": f"{USER}:{USER}",
            "ExposedPorts": {port: {} for port in PORTS},
            "Env": ["PATH=/usr/bin"],
            "Entrypoint": ["/usr/bin/arcline-server"],
            "Cmd": ["run", "--state", "/state/state", "--listen", "0.0.0.0:44818", "--hmi", "0.0.0.0:8080", "--open-to-network"],
            "Volumes": {"/state": {}},
            "WorkingDir": "/state",
            "StopSignal": "SIGTERM",
            # Engines that know it ask by it; others have probes of their own.
            "Healthcheck": {
                "Test": ["CMD", "/usr/bin/arcline-server", "health"],
                "Interval": 30 * seconds,
                "Timeout": 5 * seconds,
                "StartPeriod": 5 * seconds,
                "Retries": 3,
            },
            "Labels": {
                "org.opencontainers.image.title": "arcline",
                "org.opencontainers.image.description": "A coordinated-motion server that looks like a Logix controller",
                "org.opencontainers.image.version": VERSION,
                "org.opencontainers.image.licenses": "MIT OR Apache-2.0",
                "org.opencontainers.image.created": created,
            },
        },
        "rootfs": {"type": "layers", "diff_ids": [diff_id]},
        "history": [{"created": created, "created_by": "packaging/oci.py"}],
    }


def main(program, out):
    created = datetime.fromtimestamp(EPOCH, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    blobs = {}

    def blob(content, kind):
        digest = hashlib.sha256(content).hexdigest()
        blobs[digest] = content
        return {"mediaType": f"application/vnd.oci.image.{kind}", "digest": f"sha256:{digest}", "size": len(content)}

    def text(value):
        return json.dumps(value, sort_keys=True, separators=(",", ":")).encode()

    files = layer(Path(program).read_bytes())
    packed = blob(gzip.compress(files, 9, mtime=0), "layer.v1.tar+gzip")
    config = blob(text(image(created, f"sha256:{hashlib.sha256(files).hexdigest()}")), "config.v1+json")
    manifest_type = "manifest.v1+json"
    manifest = blob(
        text({"schemaVersion": 2, "mediaType": f"application/vnd.oci.image.{manifest_type}", "config": config, "layers": [packed]}), manifest_type
    )
    names = {"io.containerd.image.name": f"docker.io/library/arcline:{VERSION}", "org.opencontainers.image.ref.name": VERSION}
    index = {"schemaVersion": 2, "mediaType": "application/vnd.oci.image.index.v1+json", "manifests": [{**manifest, "annotations": names}]}

    def place(descriptor):
        return "blobs/" + descriptor["digest"].replace(":", "/")

    saved = [{"Config": place(config), "RepoTags": [f"arcline:{VERSION}"], "Layers": [place(packed)]}]
    with tarfile.open(out, "w", format=tarfile.USTAR_FORMAT) as archive:
        entry(archive, "blobs", 0o755)
        entry(archive, "blobs/sha256", 0o755)
        for digest, content in sorted(blobs.items()):
            entry(archive, f"blobs/sha256/{digest}", 0o644, content=content)
        entry(archive, "index.json", 0o644, content=text(index))
        entry(archive, "manifest.json", 0o644, content=text(saved))
        entry(archive, "oci-layout", 0o644, content=text({"imageLayoutVersion": "1.0.0"}))


if __name__ == "__main__":
    main(*sys.argv[1:])
