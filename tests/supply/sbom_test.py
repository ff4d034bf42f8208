#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sbom_test.py CHECKOUT: the bill of materials is well formed, the same each time, and names every package of the lists."""
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(sys.argv[1])
SBOM = [sys.executable, str(ROOT / "cmake/sbom.py")]
# Licences that Debian's copyright files are known to give.
LICENCES = {"libhwy-dev": "Apache-2.0", "libcli11-dev": "BSD-3-clause", "zlib1g-dev": "Zlib"}
failures = []


def expect(holds, what):
    if not holds:
        failures.append(what)


def run(*options):
    return subprocess.run([*SBOM, *options], capture_output=True, text=True, check=False)


first = run()
expect(first.returncode == 0, "exit code %d: %s" % (first.returncode, first.stderr))
expect(first.stdout == run().stdout, "two calls give two documents")
document = json.loads(first.stdout)
expect(document["bomFormat"] == "CycloneDX" and document["specVersion"] == "1.5", "not CycloneDX 1.5")
expect(not {"serialNumber", "timestamp"} & (set(document) | set(document["metadata"])), "changes from call to call")

components = document["components"]
refs = [component["bom-ref"] for component in components]
expect(len(set(refs)) == len(refs), "a bom-ref stands twice")
for component in components:
    expect(component["type"] == "library" and component["name"] and component["purl"] == component["bom-ref"],
           "component: %s" % component)
    missing = {"name": "poise:installed", "value": "no"} in component.get("properties", [])
    expect(missing or component["version"], "no version: %s" % component["name"])
for link in document["dependencies"]:
    for ref in [link["ref"], *link["dependsOn"]]:
        expect(ref in refs or ref == "poise", "a link to nothing: %s" % ref)

by_kind = {kind: {c["name"]: c for c in components if c["purl"].startswith("pkg:%s/" % kind)} for kind in ("deb", "npm")}
packages = [line.split()[1] for line in (ROOT / "cmake/debian-packages.txt").read_text().splitlines()
            if line and not line.startswith("#")]
expect(len(packages) > 30, "the list of packages is not where it was")
for package in packages:
    expect(package in by_kind["deb"], "not named: %s" % package)
expect(any(name.startswith("g++-") for name in by_kind["deb"]), "the compiler that g++ stands for is not named")
for package, licence in LICENCES.items():
    component = by_kind["deb"].get(package, {})
    if "version" in component and (Path("/usr/share/doc") / package / "copyright").exists():
        names = [entry["license"]["name"] for entry in component.get("licenses", [])]
        expect(licence in names, "%s: %s is not in %s" % (package, licence, names))

lock = json.loads((ROOT / "viewer/package-lock.json").read_text())
for path, fields in lock["packages"].items():
    if not path:
        continue
    name = path.rsplit("node_modules/", 1)[1]
    purl = "pkg:npm/%s@%s" % (name.replace("@", "%40"), fields["version"])
    expect(purl in refs, "not named: %s" % purl)
    if purl in refs and "license" in fields:
        expect("licenses" in components[refs.index(purl)], "no licence: %s" % purl)

# The table in the docs has a row for each; its versions are those that were tested when it was made.
table = (ROOT / "docs/supply.md").read_text()
for line in run("--table").stdout.splitlines()[2:]:
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    expect("| %s | %s | " % (cells[0], cells[1]) in table, "docs/supply.md has no row for %s %s" % (cells[0], cells[1]))

readme = (ROOT / "README.md").read_text()
for page in ("SECURITY.md", "docs/supply.md"):
    expect((ROOT / page).exists() and "(%s)" % page in readme, "README.md does not lead to %s" % page)

wrong = run("--tables")
expect(wrong.returncode == 2 and "--table" in wrong.stderr, "an unknown option is not refused")

print("\n".join(failures) or "%d components" % len(components))
sys.exit(1 if failures else 0)
