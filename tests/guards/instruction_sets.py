"""Code for one instruction set stays out of programs that run without it:
instruction_sets.py NM OBJDUMP SETS FOLDER ARCHIVE...

SETS are those of the library, such as x86-64,x86-64-v3. FOLDER has the objects that cmake/choose_at_load.cmake
writes, and the archives contain these objects among others.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

OF_REGISTERS = re.compile(r"6packed|5BatchI")  # types whose values are passed in registers of a set
WIDE = re.compile(r"\t(v[a-z0-9]+|andn|bextr|blsi|blsr|blsmsk|bzhi|mulx|pdep|pext|rorx|sarx|shlx|shrx)\s")
SYSTEM = re.compile(r"\tver[rw]\b")


def visible(nm, file):
    """The definitions in an object that other objects can refer to, with their types."""
    listing = subprocess.run([nm, "--extern-only", "--defined-only", "--portability", file], check=True,
                             capture_output=True, text=True).stdout
    return {line.split()[0]: line.split()[1] for line in listing.splitlines()}


def weak_references(nm, file):
    """The undefined symbols of an object that no linker looks for in archives."""
    listing = subprocess.run([nm, "--undefined-only", "--portability", file], check=True, capture_output=True, text=True).stdout
    return [line.split()[0] for line in listing.splitlines() if line.split()[1] in "wv"]


def visible_faults(nm, folder, group, sets):
    found = []
    for name in sets:
        file = folder / f"{group}_{name}.o"
        allowed = {re.sub(r"\W", "_", f"axode_entries_of_{group}_{name}")}
        if name == sets[0]:
            allowed.add(f"axode_chosen_entries_of_{group}")
        found += [f"{file}: {symbol} is visible" for symbol in sorted(visible(nm, file).keys() ^ allowed)]
    entries = set((folder / f"{group}_entries.txt").read_text().split())
    symbols = visible(nm, folder / f"{group}.o")
    found += [f"{group}.o: {symbol} is no entry, or an entry without code" for symbol in sorted(symbols.keys() ^ entries)]
    found += [f"{group}.o: {symbol} may stay undefined in a program" for symbol in weak_references(nm, folder / f"{group}.o")]
    found += [f"{group}.o: {symbol} is no function" for symbol, kind in sorted(symbols.items()) if kind != "T"]
    found += [f"{group}.o: {entry} passes registers of a set" for entry in sorted(entries) if OF_REGISTERS.search(entry)]
    return found


def wide_instructions(objdump, file):
    """Functions of a file with instructions that x86-64 does not have."""
    listing = subprocess.run([objdump, "--disassemble", "--no-show-raw-insn", file], check=True, capture_output=True, text=True)
    function, found = "", set()
    for line in listing.stdout.splitlines():
        if line.endswith(">:"):
            function = line.split("<", 1)[1][:-2]
        elif WIDE.search(line) and not SYSTEM.search(line):
            found.add(f"{file}: {function} has{line.split(':', 1)[1]}")
    return sorted(found)


def main():
    nm, objdump, sets, folder, *archives = sys.argv[1:]
    sets, folder = sets.split(","), Path(folder)
    groups = sorted(file.name.removesuffix("_entries.txt") for file in folder.glob("*_entries.txt"))
    if len(groups) != 3:
        sys.exit(f"expected the groups of double, in two parts, and of batches, found {groups}")
    found = [fault for group in groups for fault in visible_faults(nm, folder, group, sets)]
    if len(sets) > 1 and not wide_instructions(objdump, folder / f"batch_{sets[-1]}.o"):
        sys.exit(f"found no instruction of {sets[-1]} in the code for it")
    for group in groups:
        found += wide_instructions(objdump, folder / f"{group}_{sets[0]}.o")
    with tempfile.TemporaryDirectory() as rest:
        for archive in archives:
            copy = Path(rest, Path(archive).name)
            copy.write_bytes(Path(archive).read_bytes())
            subprocess.run(["ar", "d", copy, *(f"{group}.o" for group in groups)], check=True, capture_output=True)
            found += wide_instructions(objdump, copy)
    if found:
        sys.exit("code for another processor may use these:\n" + "\n".join(found))


if __name__ == "__main__":
    main()
