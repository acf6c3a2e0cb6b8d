"""The bill of materials of the two programs, CycloneDX 1.5, from what cargo links: sbom.py > arcline.cdx.json

Dependencies of tests and of builds are not in it. The same sources give the same bytes.
"""

import json
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).parent.parent
PROGRAMS = ["arcline-server", "arcline-client"]


def main():
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", "x86_64-unknown-linux-gnu"]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, capture_output=True, check=True).stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    lock = (ROOT / "Cargo.lock").read_text()
    checksums = {
        (name, version): checksum
        for name, version, checksum in re.findall(
            r'name = "([^"]+)"\nversion = "([^"]+)"\nsource = [^\n]+\nchecksum = "([0-9a-f]+)"', lock
        )
    }

    def linked(id):
        return sorted(d["pkg"] for d in nodes[id]["deps"] if any(kind["kind"] is None for kind in d["dep_kinds"]))

    reached, todo = set(), [id for id, package in packages.items() if package["name"] in PROGRAMS]
    while todo:
        id = todo.pop()
        if id not in reached:
            reached.add(id)
            todo += linked(id)

    def reference(id):
        return f"pkg:cargo/{packages[id]['name']}@{packages[id]['version']}"

    def component(id):
        package = packages[id]
        made = {
            "type": "application" if package["name"] in PROGRAMS else "library",
            "bom-ref": reference(id),
            "name": package["name"],
            "version": package["version"],
            "purl": reference(id),
        }
        if package.get("license"):
            made["licenses"] = [{"expression": package["license"].replace("/", " OR ")}]
        checksum = checksums.get((package["name"], package["version"]))
        if checksum:
            made["hashes"] = [{"alg": "SHA-256", "content": checksum}]
        return made

    version = next(package["version"] for package in packages.values() if package["name"] == PROGRAMS[0])
    document = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": {"type": "application", "bom-ref": "arcline", "name": "arcline", "version": version}},
        "components": sorted((component(id) for id in reached), key=lambda made: made["bom-ref"]),
        "dependencies": sorted(
            ({"ref": reference(id), "dependsOn": sorted(map(reference, linked(id)))} for id in reached),
            key=lambda dependency: dependency["ref"],
        ),
    }
    print(json.dumps(document, indent=1, sort_keys=True))


if __name__ == "__main__":
    main()
