#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The software bill of materials: what the build, the tests and the viewer take from others, in the versions that are
installed (Debian packages) or locked (npm packages), as CycloneDX 1.5 in JSON. The same machine gives the same bytes.

  cmake/sbom.py            > poise.cdx.json
  cmake/sbom.py --table    the table of tested versions of docs/supply.md, as Markdown

The packages are those of cmake/debian-packages.txt, with what each of them depends on directly, and those of
viewer/package-lock.json. Licences are those of Debian's copyright files where these are in the machine-readable form.
Exit code 1: dpkg-query is missing, or none of the packages is installed.
"""
import json
import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import quote

ROOT = Path(__file__).resolve().parent.parent
FIELDS = ["Package", "Version", "Architecture", "source:Package", "source:Version", "Depends"]


def asked_packages():
    """(step, package) of each line of the list."""
    lines = (ROOT / "cmake/debian-packages.txt").read_text().splitlines()
    return [tuple(line.split()) for line in lines if line and not line.startswith("#")]


def installed(names):
    """The fields of those packages that are installed, by name."""
    form = "${db:Status-Abbrev}\x1f" + "\x1f".join("${%s}" % field for field in FIELDS) + "\x1e"
    out = subprocess.run(["dpkg-query", "-W", "-f", form, *names], capture_output=True, text=True, check=False).stdout
    found = {}
    for row in out.split("\x1e"):
        status, *values = row.split("\x1f")
        if status.startswith("ii"):
            fields = dict(zip(FIELDS, values))
            found[fields["Package"]] = fields
    return found


def direct_dependencies(fields):
    """The first alternative of each dependency that names a package."""
    names = [part.split("|")[0].split("(")[0].split(":")[0].strip() for part in fields["Depends"].split(",")]
    return sorted({name for name in names if name})


def debian_licences(package):
    """The short names of the licences of a copyright file in the machine-readable form, in its order."""
    file = Path("/usr/share/doc") / package / "copyright"
    try:
        text = file.read_text(errors="replace")
    except OSError:
        return []
    if "copyright-format/1.0" not in text.split("\n\n")[0]:
        return []
    names = re.findall(r"^License:[ \t]*(\S[^\n]*)$", text, re.MULTILINE)
    return list(dict.fromkeys(name.strip() for name in names))


def debian_component(fields, step):
    name, version = fields["Package"], fields["Version"]
    purl = "pkg:deb/debian/%s@%s?arch=%s" % (quote(name, safe=""), quote(version, safe=""), fields["Architecture"])
    component = {"type": "library", "bom-ref": purl, "name": name, "version": version, "purl": purl}
    licences = debian_licences(name)
    if licences:
        component["licenses"] = [{"license": {"name": licence}} for licence in licences]
    component["properties"] = [
        {"name": "poise:step", "value": step},
        {"name": "poise:source", "value": "%s %s" % (fields["source:Package"], fields["source:Version"])},
    ]
    return component


def missing_component(name, step):
    purl = "pkg:deb/debian/%s" % quote(name, safe="")
    return {"type": "library", "bom-ref": purl, "name": name, "purl": purl, "scope": "excluded",
            "properties": [{"name": "poise:step", "value": step}, {"name": "poise:installed", "value": "no"}]}


def npm_component(path, fields):
    name = path.rsplit("node_modules/", 1)[1]
    # In a purl the scope of a package is its namespace, and its at sign is escaped.
    purl = "pkg:npm/%s@%s" % (quote(name, safe="/"), quote(fields["version"], safe=""))
    component = {"type": "library", "bom-ref": purl, "name": name, "version": fields["version"], "purl": purl,
                 "scope": "excluded" if fields.get("dev") else "required"}
    if "license" in fields:
        licence = fields["license"]
        component["licenses"] = [{"expression": licence} if " " in licence else {"license": {"id": licence}}]
    if "integrity" in fields:
        component["properties"] = [{"name": "poise:integrity", "value": fields["integrity"]}]
    return component


def bill():
    version = re.search(r"project\(poise VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
    step_of = {package: step for step, package in asked_packages()}
    packages = installed(list(step_of))
    if not packages:
        sys.exit("sbom.py: none of the packages of cmake/debian-packages.txt is installed")
    below = {name: direct_dependencies(packages[name]) for name in packages}
    more = installed(sorted({name for names in below.values() for name in names} - set(packages)))
    debian = {name: debian_component(packages[name], step) if name in packages else missing_component(name, step)
              for name, step in step_of.items()}
    for name in sorted(below):
        for dependency in below[name]:
            if dependency in more and dependency not in debian:
                debian[dependency] = debian_component(more[dependency], step_of[name])
    lock = json.loads((ROOT / "viewer/package-lock.json").read_text())
    npm = [npm_component(path, fields) for path, fields in sorted(lock["packages"].items()) if path]
    npm = list({component["bom-ref"]: component for component in npm}.values())
    own = {"type": "application", "bom-ref": "poise", "name": "poise", "version": version,
           "licenses": [{"license": {"id": "MIT"}}]}
    direct = [debian[name]["bom-ref"] for name in step_of] + [component["bom-ref"] for component in npm]
    links = [{"ref": "poise", "dependsOn": sorted(direct)}]
    links += [{"ref": debian[name]["bom-ref"], "dependsOn": [debian[d]["bom-ref"] for d in below[name] if d in debian]}
              for name in sorted(packages)]
    return {
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {"component": own},
        "components": [debian[name] for name in sorted(debian)] + npm, "dependencies": links,
    }, packages, lock


def table(packages, lock):
    rows = ["| step | package | tested version | licence |", "|---|---|---|---|"]
    for step, name in asked_packages():
        licences = debian_licences(name)
        shown = ", ".join(licences[:3]) + (", ..." if len(licences) > 3 else "")
        rows.append("| %s | %s | %s | %s |" % (step, name, packages[name]["Version"] if name in packages else "-", shown))
    for path, fields in sorted(lock["packages"].items()):
        if not path or fields.get("optional"):
            continue
        name = path.rsplit("node_modules/", 1)[1]
        rows.append("| %s | %s (npm) | %s | %s |" % ("viewer-test" if fields.get("dev") else "viewer", name,
                                                      fields["version"], fields.get("license", "")))
    return "\n".join(rows)


def main():
    if sys.argv[1:] not in ([], ["--table"]):
        print("sbom.py: the only option is --table", file=sys.stderr)
        return 2
    try:
        document, packages, lock = bill()
    except FileNotFoundError as error:
        print("sbom.py: %s: this needs a Debian system" % error, file=sys.stderr)
        return 1
    print(table(packages, lock) if sys.argv[1:] else json.dumps(document, indent=1, ensure_ascii=False))
    return 0


if __name__ == "__main__":
    sys.exit(main())
