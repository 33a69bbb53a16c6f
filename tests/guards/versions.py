"""Every file that contains the version has the version in CMakeLists.txt: versions.py SOURCE_DIR."""

import re
import sys
from pathlib import Path

PLACES = {
    "CITATION.cff": r"^version: (\S+)$",
    "package.xml": r"<version>(.*?)</version>",
    "packaging/conda/meta.yaml": r"^  version: (\S+)$",
    "packaging/debian/changelog": r"\Aaxode \((\S+?)\)",
    "packaging/vcpkg/axode/vcpkg.json": r'"version": "(.*?)"',
    "CHANGELOG.md": r"^## (\d+\.\d+\.\d+)",
}


def version_in(source, place, pattern):
    found = re.search(pattern, (source / place).read_text(encoding="utf-8"), re.MULTILINE)
    return found[1] if found else "none"


def main(source):
    version = version_in(source, "CMakeLists.txt", r"^project\(axode VERSION (\d+\.\d+\.\d+)")
    wrong = [f"{place} has version {found}, CMakeLists.txt {version}" for place, pattern in PLACES.items()
             if (found := version_in(source, place, pattern)) != version]
    print("\n".join(wrong) or f"version {version} everywhere")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
