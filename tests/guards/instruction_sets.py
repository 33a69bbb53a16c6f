"""Functions in objects compiled for AVX must not replace functions of other code: instruction_sets.py NM OBJECT...

If several objects have the same inline function, the linker keeps one copy of it. If that copy came from an object
compiled for AVX, the program would crash on processors without AVX. So every weak definition in such an object must
belong to its own Batch types.
"""

import re
import subprocess
import sys


# Calls std::terminate; an address; constants, which Clang leaves in every object.
BATCH = re.compile(r"Batch<(double|float), |5BatchI[df]Lm")  # nm leaves names mangled that it does not understand
HARMLESS = {"__clang_call_terminate", "DW.ref.__gxx_personality_v0", *(f"axode::series::{name}" for name in "abcg")}


def shared_functions(nm, objects):
    found = []
    for file in objects:
        if not re.search(r"batch_avx", file):
            continue
        listing = subprocess.run([nm, "--demangle", "--defined-only", file], check=True, capture_output=True, text=True)
        for line in listing.stdout.splitlines():
            kind, name = line.split(maxsplit=2)[1:] if not line.startswith(" ") else (None, None)
            if kind in ("W", "V", "w", "v", "u") and name not in HARMLESS and not BATCH.search(name):
                found.append(f"{file}: {name}")
    return found


def main():
    nm, *objects = sys.argv[1:]
    if sum("batch_avx" in file for file in objects) != 4:
        sys.exit("expected four objects for AVX2 and AVX-512 among\n" + "\n".join(objects))
    found = shared_functions(nm, objects)
    if found:
        sys.exit("code for another processor may use these:\n" + "\n".join(found))


if __name__ == "__main__":
    main()
